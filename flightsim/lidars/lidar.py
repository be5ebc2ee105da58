"""A lidar on a vehicle: fires along its pattern while the vehicle moves, at the physics' solids.

A scan takes some time, such as a tenth of a second, in which a vehicle moves and turns, so a scan
is bent as a real one's is. Each shot is therefore cast from the true pose of its control tick, and
nothing is corrected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3
from flightsim.draws import generator
from flightsim.lidars.definition import LidarCfg
from flightsim.plant import Plant
from flightsim.plant.rays import cast_rays, new_rays


@dataclass(frozen=True, kw_only=True, eq=False)
class LidarScan:
    """One scan, in the order of its n shots."""

    time_us: int
    """Time at which its last shot was fired."""
    offset_us: Float[np.ndarray, " n"]
    """Time of each shot from the last one, zero or negative."""
    direction_flu: Float[np.ndarray, "n 3"]
    """Unit direction of each shot in the lidar's frame."""
    range_m: Float[np.ndarray, " n"]
    """Measured distance along each; infinite where nothing is within range."""
    position_flu_m: Vector3
    """Place of the lidar on the vehicle, from the centre of mass."""
    rotation_flu_from_lidar: Float[np.ndarray, "3 3"]

    @property
    def points_lidar_m(self) -> Float[np.ndarray, "k 3"]:
        """Points that were met, in the lidar's frame at each shot, as a driver gives them.

        The motion of the vehicle within the scan is in them, and for the reader to take out.
        """
        is_met = np.isfinite(self.range_m)
        return self.direction_flu[is_met] * self.range_m[is_met, None]

    @property
    def points_flu_m(self) -> Float[np.ndarray, "k 3"]:
        """The same points in the body frame."""
        # Points are rows, so the rotation is transposed.
        return self.points_lidar_m @ self.rotation_flu_from_lidar.T + self.position_flu_m


class Lidar:
    """Lidar that scans all solids around the vehicle, movers too, but not the vehicle itself.

    Each shot starts from the true pose of the control tick in which it is fired, 250 a second.

    Attributes:
        listeners: Functions called with each scan.
        latest: Last complete scan; None before the first.
    """

    def __init__(self, plant: Plant, cfg: LidarCfg) -> None:
        """Switch a lidar on.

        Args:
            plant: Vehicle that carries it.
            cfg: Settings, such as `lidar_by_name("vlp16")`.
        """
        self._plant, self._cfg = plant, cfg
        self._rays = new_rays(plant.world, plant.data, plant.world.wide_rays)
        self._shot_us = 1e6 / (cfg.scan_hz * cfg.pattern.shots_per_scan)
        self._since_us = plant.time_us
        self._n_fired = 0
        self._parts: list[tuple[np.ndarray, ...]] = []
        self.listeners: list[Callable[[LidarScan], None]] = []
        self.latest: LidarScan | None = None

    def update(self) -> LidarScan | None:
        """Fire the shots that are due until now; call it after each advance of the plant.

        Returns:
            The scan that has become complete, which `latest` then is; None while none has.
        """
        # Counted from the start, so rounding does not add up.
        n_due = int((self._plant.time_us - self._since_us) / self._shot_us) - self._n_fired
        complete = None
        # A scan may end in the middle of an advance.
        while n_due > 0:
            per_scan = self._cfg.pattern.shots_per_scan
            n = min(n_due, per_scan - self._n_fired % per_scan)
            self._fire(np.arange(self._n_fired, self._n_fired + n))
            self._n_fired += n
            n_due -= n
            if self._n_fired % per_scan == 0:
                complete = self._finish()
        return complete

    def _fire(self, shots: np.ndarray) -> None:
        """Measure along shots by their numbers, all within the last advance."""
        cfg, history = self._cfg, self._plant.history
        time_us = self._since_us + (shots + 1) * self._shot_us
        # The tick that ends at or after the shot; 1 us allows for rounding.
        row = np.searchsorted(history["time_us"], time_us - 1.0)
        row = np.minimum(row, len(history) - 1)
        rotations = _rotations(history["quat_true_wxyz"])
        origins_m = history["position_true_enu_m"] + rotations @ np.array(cfg.position_flu_m)
        directions = cfg.pattern.directions_flu(shots)
        turns = rotations @ cfg.rotation_flu_from_lidar
        rays = np.empty((len(shots), 6))
        rays[:, :3] = origins_m[row]
        rays[:, 3:] = np.einsum("nij,nj->ni", turns[row], directions)
        distance_m = np.empty(len(shots))
        cast_rays(self._rays, rays, self._plant.world.vehicle_body_id, distance_m)
        self._parts.append((time_us, directions, distance_m))

    def _finish(self) -> LidarScan:
        """Make the scan that is complete, and call the listeners."""
        cfg = self._cfg
        time_us, directions, distance_m = (
            np.concatenate(columns) for columns in zip(*self._parts, strict=True)
        )
        self._parts.clear()
        number = self._n_fired // cfg.pattern.shots_per_scan
        plant = self._plant
        # A stream of its own for each scan, so its noise does not depend on what else is drawn.
        # So has each vehicle after the first, whose stream has no number of its own.
        who = [f"vehicle {vehicle}"] if (vehicle := plant.world.number) else []
        rng = generator(plant.cfg.seed, plant.world.scene.scene_id, "lidar", *who, number)
        measured_m = distance_m + cfg.noise_m * rng.standard_normal(len(distance_m))
        near_m, far_m = cfg.range_m
        # The true distance decides, so that noise lets no wall behind the range appear.
        is_met = (distance_m >= near_m) & (distance_m <= far_m)
        scan = LidarScan(
            time_us=round(time_us[-1]),
            offset_us=time_us - time_us[-1],
            direction_flu=directions,
            range_m=np.where(is_met, np.maximum(measured_m, 0.0), np.inf),
            position_flu_m=cfg.position_flu_m,
            rotation_flu_from_lidar=cfg.rotation_flu_from_lidar,
        )
        self.latest = scan
        for listener in self.listeners:
            listener(scan)
        return scan


def _rotations(quat_wxyz: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 3 3"]:
    """Return the rotation matrices of unit quaternions."""
    # Here, since scipy takes long to import and few flights have a lidar.
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()
