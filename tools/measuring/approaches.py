"""Comparison of free flight with MuJoCo: are contacts missed, or come to elsewhere?

The same approach is flown twice at a time, once with the steps that the kernel takes itself
(`flightsim.plant.free_flight`) and once by MuJoCo alone, at one control tick a physics step, so
that the log says in which step the vehicle first touched something.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from aeroscene.sources import load_scene
from flightsim.environment.effects import NO_EFFECTS
from flightsim.plant import Fleet, PlantCfg
from flightsim.plant.cfg import ADVANCE_HZ
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import World, build_world
from measuring.configs import ApproachesBenchCfg
from measuring.plan_pairs import SHIPPED_SCENES
from scenarios.bench.row import OnProgress, Row, higher, lower

_VEHICLE = "vehicle"
N_TOGETHER = 64
"""Approaches that are flown at the same time, at the same speed."""
_SPEED_MPS = (1.0, 20.0)
_RATE_RADPS = 5.0
_WAY_M = (0.5, 2.5)
"""Distance from where the aim is, besides the vehicle's own radius."""
_BEYOND_M = 0.5
"""Way beyond the aim after which an approach that met nothing ends."""
_HEIGHT_M = 100.0
"""Height at which another vehicle is met."""
_ASIDE = 0.8
"""Farthest aim off its middle, over its radius."""
_GROUND_M = 10.0
"""Way from the start within which the ground is aimed at."""
# Coprime to the number of scenes.
_STEP = 613
"""Scenes are taken in steps of this many, which visit all of them in turn."""
_PHYSICS_HZ = 500
_COLUMNS = (
    *("position_true_enu_m", "quat_true_wxyz"),
    *("velocity_true_enu_mps", "angular_rate_true_flu_radps"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Approaches:
    """Results of n approaches, each flown in both ways."""

    kind: np.ndarray
    """Thing that was flown at (n,): the name of a shape, or "vehicle"."""
    first_step: np.ndarray
    """Physics step of the first contact (n, 2), free flight first; -1 without one."""
    apart: np.ndarray
    """Greatest difference until then (n,), of position (m), attitude, velocity (m/s) and body rate
    (rad/s)."""
    free_share: float
    """Share of the steps that the kernel took itself."""

    @property
    def is_missed(self) -> np.ndarray:
        """Approaches (n,) whose first contacts are not in the same step."""
        return self.first_step[:, 0] != self.first_step[:, 1]

    @property
    def is_contact(self) -> np.ndarray:
        """Approaches (n,) in which MuJoCo alone found a contact, and not at the beginning."""
        return self.first_step[:, 1] > 0


def rows(cfg: ApproachesBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Fly all approaches, and count those that differ.

    Args:
        cfg: Options of the benchmark.
        on_progress: Called with what is being done, and the share that is done.

    Returns:
        Rows of results, as they come.
    """
    airframe, rng = airframe_by_name(cfg.vehicle), np.random.default_rng(cfg.seed)
    n_each = math.ceil(cfg.count / (2 * cfg.scenes))
    pair = build_world(load_scene("field"), airframe, airframe)
    parts: list[Approaches] = []
    for k in range(cfg.scenes):
        number = (cfg.seed + k * _STEP) % SHIPPED_SCENES
        on_progress(f"scene {number}", k / cfg.scenes)
        world = build_world(load_scene(str(number)), airframe)
        parts.append(fly_approaches(world, n_each, rng))
        on_progress("another vehicle", (k + 0.5) / cfg.scenes)
        parts.append(fly_approaches(pair, n_each, rng))
    kind = np.concatenate([part.kind for part in parts])
    is_contact = np.concatenate([part.is_contact for part in parts])
    is_missed = np.concatenate([part.is_missed for part in parts])
    for name in sorted(set(kind.tolist())):
        yield higher(f"contacts with: {name}", float(is_contact[kind == name].sum()), "")
        yield lower("of these in another step", float(is_missed[kind == name].sum()), "", 0.0)
    apart = max(float(part.apart.max()) for part in parts)
    yield lower("greatest difference until then", apart, "m, m/s, rad/s", 1e-9)
    share = np.mean([part.free_share for part in parts])
    yield higher("steps in free flight", 100.0 * float(share), "%")


def fly_approaches(world: World, n: int, rng: np.random.Generator) -> Approaches:
    """Let the first vehicle of a world fly at something n times.

    Args:
        world: One with a vehicle, which flies at its solids and its ground, or one with two, of
            which the second waits for it high above everything.
        n: Number of approaches.
        rng: Generator of all that is drawn.
    """
    n_batches = math.ceil(n / N_TOGETHER)
    with _fleet(world, is_free=True) as free, _fleet(world, is_free=False) as engine:
        parts = [_fly(world, free, engine, rng) for _ in range(n_batches)]
    return Approaches(
        kind=np.concatenate([part.kind for part in parts])[:n],
        first_step=np.concatenate([part.first_step for part in parts])[:n],
        apart=np.concatenate([part.apart for part in parts])[:n],
        free_share=float(np.mean([part.free_share for part in parts])),
    )


def _fleet(world: World, *, is_free: bool) -> Fleet:
    # Without noise and effects, so that nothing but the steps can differ; physics and control at
    # one rate.
    cfg = PlantCfg(
        seed=0,
        state="truth",
        has_sensors=False,
        effects=NO_EFFECTS,
        free_flight=is_free,
        physics_hz=_PHYSICS_HZ,
        control_hz=_PHYSICS_HZ,
    )
    return Fleet([world] * N_TOGETHER, [cfg] * N_TOGETHER, n_threads=1)


def _fly(world: World, free: Fleet, engine: Fleet, rng: np.random.Generator) -> Approaches:
    """Fly a batch of approaches."""
    speed_mps = rng.uniform(*_SPEED_MPS)
    kinds = [_begin(world, (free.data(i), engine.data(i)), speed_mps, rng) for i in _firsts(free)]
    longest_m = _WAY_M[1] + world.airframe.collision_radius_m + _BEYOND_M
    n_before = int(free.records["free_flight"]["n_steps"].sum())
    logs: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    n_advances = math.ceil(longest_m / speed_mps * ADVANCE_HZ)
    for _ in range(n_advances):
        for fleet, log in zip((free, engine), logs, strict=True):
            fleet.advance()
            # The first vehicle of each world; the second only waits.
            log.append(fleet.history[:: fleet.n_together].copy())
    flown = [np.concatenate(log, axis=1) for log in logs]
    first = np.stack([_first_step(history["is_touching"] > 0) for history in flown], axis=1)
    # After a contact both may differ, because a bounce magnifies rounding.
    is_before = np.arange(flown[0].shape[1]) < np.where(first < 0, np.inf, first).min(1)[:, None]
    apart = sum(np.abs(flown[0][name] - flown[1][name]).max(2) for name in _COLUMNS)
    n_steps = len(free) * n_advances * _PHYSICS_HZ // ADVANCE_HZ
    n_free = int(free.records["free_flight"]["n_steps"].sum()) - n_before
    return Approaches(
        kind=np.array(kinds),
        first_step=first,
        apart=np.where(is_before, apart, 0.0).max(1),
        free_share=n_free / n_steps,
    )


def _firsts(fleet: Fleet) -> range:
    """Numbers of the first vehicles of all worlds."""
    return range(0, len(fleet), fleet.n_together)


def _first_step(is_touching: np.ndarray) -> np.ndarray:
    return np.where(is_touching.any(1), is_touching.argmax(1), -1)


def _begin(
    world: World, states: Sequence[mujoco.MjData], speed_mps: float, rng: np.random.Generator
) -> str:
    """Put the vehicles of a world where an approach begins, in both simulations alike.

    Returns:
        Thing that the first vehicle flies at.
    """
    kind, aim_enu_m = _draw_aim(world, rng)
    # Normal components make a direction, and a quaternion below, that is evenly distributed.
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    if kind != _VEHICLE:
        # From above, because most things stand on the ground.
        way[2] = -abs(way[2])
    away_m = rng.uniform(*_WAY_M) + world.airframe.collision_radius_m
    poses, velocities = [], []
    for k in range(world.n_vehicles):
        quat = rng.normal(size=4)
        place = aim_enu_m - away_m * way if k == 0 else (0.0, 0.0, _HEIGHT_M)
        poses.append((*place, *quat / np.linalg.norm(quat)))
        rate_radps = rng.normal(scale=_RATE_RADPS, size=3)
        velocities.append((*(speed_mps * way if k == 0 else np.zeros(3)), *rate_radps))
    for data in states:
        data.qpos[:], data.qvel[:] = np.ravel(poses), np.ravel(velocities)
        # The solver begins its search there, and both are to begin at the same place.
        data.qacc_warmstart[:] = 0.0
    return kind


def _draw_aim(world: World, rng: np.random.Generator) -> tuple[str, np.ndarray]:
    """Draw a thing to fly at, and a place in it.

    Each kind of shape is as likely as any other, however many solids have it.
    """
    if world.n_vehicles > 1:
        reach_m = _ASIDE * world.airframe.collision_radius_m
        return _VEHICLE, rng.uniform(-reach_m, reach_m, size=3) + np.array([0.0, 0.0, _HEIGHT_M])
    model = world.model
    # Solids of the scene that collide.
    solids = np.flatnonzero((model.geom_bodyid == 0) & (model.geom_contype != 0))
    kind = rng.choice(np.unique(model.geom_type[solids]))
    geom = rng.choice(solids[model.geom_type[solids] == kind])
    name = mujoco.mjtGeom(kind).name.removeprefix("mjGEOM_").lower()
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        start_enu_m = np.array(world.scene.start_position_enu_m)
        east_m, north_m = start_enu_m[:2] + rng.uniform(-_GROUND_M, _GROUND_M, size=2)
        return name, np.array([east_m, north_m, 0.0])
    # A place in the box around a shape, turned as the shape is.
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    inside = middle + half * rng.uniform(-1.0, 1.0, size=3)
    return name, model.geom_pos[geom] + turn.reshape(3, 3) @ inside
