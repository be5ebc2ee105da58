"""Observations of agents, for all vehicles of a fleet at once.

part         numbers                                                          frame, unit
target       vector to the target                                             ENU, m
state        velocity; rotation matrix body to world by rows; angular rate    ENU, m/s; FLU, rad/s
last_action  the previous action
imu          specific force; angular rate                                     FLU, m/s^2; rad/s
range        distance below, 30 for none                                      m
mates        vector to each other vehicle of the world; its relative velocity ENU, m; m/s
depth        an image, up to 20 m                                             m
classes      an image: class of each pixel
objects      an image: object of each pixel

The attitude is a rotation matrix, which has neither the jumps of angles nor the two signs of
quaternions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from gymnasium import spaces
from jaxtyping import Float

from flightsim.world import World
from scenarios.environments.cfg import ObservationCfg
from scenarios.environments.interface.actions import N_ACTIONS
from scenarios.environments.interface.images import FAR_M, SEGMENT_DTYPES, CameraImages

MOST_RANGE_M = 30.0
N_NOISES = 12
_NOISE_SIGMAS = np.repeat([0.02, 0.05, 0.01, 0.05], 3)
"""Standard deviations of position, velocity, attitude and angular rate at noise 1."""
_STATE = (("velocity", 3, 100.0), ("rotation", 9, 1.0), ("angular_rate", 3, 100.0))
"""Name, size and bound of each part of a state."""
_MATE = ((3, 1000.0), (3, 100.0))
"""Size and bound of the vector to another vehicle and of its velocity relative to one's own."""

Observation = Any
"""An array (n, k), or with images a dictionary of `numbers`, `depth` and segments."""


class Observed(Protocol):
    """Vehicles that can be observed; a `flightsim.plant.Fleet` is one."""

    @property
    def worlds(self) -> Sequence[World]:
        """World of each of n vehicles."""
        ...

    @property
    def n_together(self) -> int:
        """Number of vehicles in each world."""
        ...

    @property
    def records(self) -> np.ndarray:
        """`PLANT_DTYPE` (n,), the state of all plants."""
        ...

    @property
    def history(self) -> np.ndarray:
        """`HISTORY_DTYPE` (n, k), the last advance."""
        ...


class Observer:
    """Builds the observations of a fleet.

    Attributes:
        space: Space of one vehicle's observation.
    """

    def __init__(
        self,
        fleet: Observed,
        cfg: ObservationCfg,
        n_threads: int | None = None,
        estimate: Sequence[np.ndarray] | None = None,
    ) -> None:
        """Watch a fleet.

        Args:
            fleet: Vehicles whose observations these are.
            cfg: Parts of the observations.
            n_threads: Threads that cast images; None takes one for each core.
            estimate: Arrays that hold the estimated positions, velocities, attitudes and angular
                rates at each observation; None takes those of the plants' own filters.
        """
        self._cfg, self._fleet = cfg, fleet
        # Views into the fleet's arrays: they show every new step without a copy.
        self._truth = [
            fleet.history[name][:, -1]
            for name in (
                "position_true_enu_m",
                "velocity_true_enu_mps",
                "quat_true_wxyz",
                "angular_rate_true_flu_radps",
            )
        ]
        names = ("position_enu_m", "velocity_enu_mps", "quat_wxyz", "angular_rate_flu_radps")
        self._estimate = estimate or [fleet.records["filter"][name] for name in names]
        # Without a state the vector to the target still needs a position: the true one.
        self._known = self._estimate if cfg.state == "estimated" else self._truth
        self._cameras = None
        if cfg.depth is not None:
            self._cameras = CameraImages(
                fleet.worlds,
                cfg.depth,
                cfg.camera,
                cfg.segments,
                n_threads,
                rays=fleet.records["engine"]["rays"],
            )
        n_mates = fleet.n_together - 1
        self._has_numbers = cfg.has_numbers or n_mates > 0
        self._bounds = _bounds(cfg, n_mates)
        self.space = _space(cfg, self._bounds if self._has_numbers else None)

    @property
    def position_enu_m(self) -> Float[np.ndarray, "n 3"]:
        """Position of each vehicle by its own knowledge: true or estimated, ENU, m."""
        return self._known[0]

    @property
    def quat_wxyz(self) -> Float[np.ndarray, "n 4"]:
        """Attitude of each vehicle by its own knowledge, body to ENU."""
        return self._known[2]

    def observe(
        self,
        target_enu_m: Float[np.ndarray, "n 3"],
        last_action: Float[np.ndarray, "n 4"],
        noise: Float[np.ndarray, "n 12"] | None = None,
        before: tuple[Observation, Sequence[int]] | None = None,
    ) -> Observation:
        """Return the observations of all vehicles now, in arrays of their own.

        Args:
            target_enu_m: Their targets.
            last_action: Their previous actions.
            noise: Standard normals times the level of noise of each; None for no noise.
            before: Observations of this moment, and numbers of the vehicles that have been moved
                since; only those get new images. None takes all images anew.
        """
        numbers = None
        if self._has_numbers:
            parts = list(self._parts(target_enu_m, last_action, noise))
            numbers = np.concatenate(parts, axis=1, dtype=np.float32)
            # A vehicle that flies off must not leave the declared space.
            np.clip(numbers, *self._bounds, out=numbers)
        if self._cameras is None:
            return numbers
        position_enu_m, _, quat_wxyz, _ = self._truth
        poses = position_enu_m, rotation_matrices(quat_wxyz)
        if before is None:
            images = self._cameras.render(*poses)
        else:
            seen, moved = before
            changed = self._cameras.render(*poses, moved)
            images = {name: seen[name].copy() for name in changed}
            for name, image in changed.items():
                images[name][moved] = image
        return images if numbers is None else {**images, "numbers": numbers}

    def close(self) -> None:
        """End the threads."""
        if self._cameras is not None:
            self._cameras.close()

    def _parts(
        self, target_enu_m: np.ndarray, last_action: np.ndarray, noise: np.ndarray | None
    ) -> Iterator[np.ndarray]:
        cfg, records = self._cfg, self._fleet.records
        position_enu_m, velocity_enu_mps, quat_wxyz, rate_flu_radps = self._known
        way_enu_m, rotation = target_enu_m - position_enu_m, rotation_matrices(quat_wxyz)
        if noise is not None:
            error = _NOISE_SIGMAS * noise
            way_enu_m -= error[:, :3]
            # New arrays: the known state belongs to the fleet and must not be changed.
            velocity_enu_mps = velocity_enu_mps + error[:, 3:6]
            # A small rotation about the body's axes, to first order: no longer exactly a rotation
            # matrix.
            rotation += rotation @ _cross_matrices(error[:, 6:9])
            rate_flu_radps = rate_flu_radps + error[:, 9:]
        if cfg.target:
            yield way_enu_m
        if cfg.state != "none":
            yield velocity_enu_mps
            yield rotation.reshape(-1, 9)
            yield rate_flu_radps
        if cfg.last_action:
            yield last_action
        if cfg.imu:
            yield records["imu"]["accel_flu_mps2"]
            yield records["imu"]["gyro_flu_radps"]
        if cfg.range:
            range_m = records["range"]["range_m"][:, None]
            # A network cannot use infinity.
            yield np.where(np.isfinite(range_m), range_m, MOST_RANGE_M)
        if self._fleet.n_together > 1:
            position_true_enu_m, velocity_true_enu_mps, *_ = self._truth
            yield _mates(position_true_enu_m, velocity_true_enu_mps, self._fleet.n_together)


def take(observation: Observation, index: int) -> Observation:
    """Return the observation of one vehicle."""
    if isinstance(observation, dict):
        return {name: values[index] for name, values in observation.items()}
    return observation[index]


_IDENTITY = np.eye(3).ravel()
_FACTOR = 2.0 - 4.0 * _IDENTITY
_WX, _WY, _WZ, _XX, _XY, _XZ, _YY, _YZ, _ZZ = 1, 2, 3, 5, 6, 7, 10, 11, 15
_FIRST_PRODUCT = np.array([_YY, _XY, _XZ, _XY, _XX, _YZ, _XZ, _YZ, _XX])
_SECOND_PRODUCT = np.array([_ZZ, _WZ, _WY, _WZ, _ZZ, _WX, _WY, _WX, _YY])
_SIGN = np.array([1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0])
"""Indices for `rotation_matrices`. An entry of a rotation matrix is the identity's entry plus twice
a sum of two products of the quaternion's numbers, or minus twice it on the diagonal."""


def rotation_matrices(quat_wxyz: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 3 3"]:
    """Return the rotation matrices of unit quaternions."""
    # Few calls of numpy for all entries, because each call costs more than its numbers.
    products = (quat_wxyz[:, :, None] * quat_wxyz[:, None]).reshape(-1, 16)
    sums = products[:, _FIRST_PRODUCT] + _SIGN * products[:, _SECOND_PRODUCT]
    return (_IDENTITY + _FACTOR * sums).reshape(-1, 3, 3)


def _cross_matrices(vectors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3 3"]:
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def _mates(
    position_enu_m: Float[np.ndarray, "n 3"], velocity_enu_mps: Float[np.ndarray, "n 3"], k: int
) -> Float[np.ndarray, "n m"]:
    """Vectors to the other vehicles of each k, and relative velocities, one after the other."""
    states = np.concatenate([position_enu_m, velocity_enu_mps], axis=1).reshape(-1, k, 6)
    # The vehicle itself is left out by the mask of the diagonal.
    away = states[:, None] - states[:, :, None]
    return away[:, ~np.eye(k, dtype=bool)].reshape(-1, 6 * (k - 1))


def _space(cfg: ObservationCfg, bounds: tuple[np.ndarray, np.ndarray] | None) -> spaces.Space[Any]:
    parts: dict[str, spaces.Space[Any]] = {}
    if bounds is not None:
        parts["numbers"] = spaces.Box(*bounds, dtype=np.float32)
    if cfg.depth is None:
        return parts["numbers"]
    width, height = cfg.depth
    parts |= {"depth": spaces.Box(0.0, FAR_M, (height, width), dtype=np.float32)}
    for name in cfg.segments:
        kind = SEGMENT_DTYPES[name]
        limits = np.iinfo(kind)
        parts[name] = spaces.Box(limits.min, limits.max, (height, width), dtype=kind)
    return spaces.Dict(parts)


def layout(cfg: ObservationCfg) -> list[tuple[str, int]]:
    """Return name and size of each part of the numbers of one vehicle, in their order."""
    return [(name, size) for name, size, _, _ in _parts_bounds(cfg, 0)]


def _bounds(cfg: ObservationCfg, n_mates: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the greatest value of each number."""
    parts = list(_parts_bounds(cfg, n_mates))
    low, high = (
        np.concatenate([np.zeros(0), *(np.full(part[1], part[k]) for part in parts)])
        for k in (2, 3)
    )
    return low.astype(np.float32), high.astype(np.float32)


def _parts_bounds(cfg: ObservationCfg, n_mates: int) -> Iterator[tuple[str, int, float, float]]:
    """Yield name, size and bounds of each part, in the order of the observation."""
    if cfg.target:
        yield "target", 3, -1000.0, 1000.0
    if cfg.state != "none":
        yield from ((name, size, -most, most) for name, size, most in _STATE)
    if cfg.last_action:
        yield "last_action", N_ACTIONS, -1.0, 1.0
    if cfg.imu:
        yield from (("specific_force", 3, -500.0, 500.0), ("imu_rate", 3, -100.0, 100.0))
    if cfg.range:
        yield "range", 1, 0.0, MOST_RANGE_M
    for _ in range(n_mates):
        yield from (("mate", size, -most, most) for size, most in _MATE)
