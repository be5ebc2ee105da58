"""Distance sensors and lidars of settings.json: rays that are cast when a client asks.

A vehicle that nobody asks casts none. A lidar measures a whole turn from one pose, without noise,
as AirSim's does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3
from flightsim.plant import Plant
from flightsim.plant.rays import cast_rays, new_rays
from scenarios.airsim.cameras import FRD_FROM_FLU, rotation
from scenarios.airsim.messages import Pose, Quaternionr
from scenarios.airsim.methods import RpcError

SENSOR_FRAME = "SensorLocalFrame"
FRAMES = ("VehicleInertialFrame", SENSOR_FRAME)
"""Frames of a lidar's points: the vehicle's local frame (north-east-down), or the sensor's own."""
_Sensor = TypeVar("_Sensor")
NED_FROM_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True, kw_only=True)
class DistanceCfg:
    """A sensor that measures along its forward axis."""

    least_m: float
    most_m: float
    pose: Pose
    """Place of the sensor on the vehicle, forward-right-down."""


@dataclass(frozen=True, kw_only=True)
class LidarCfg:
    """A lidar with channels one above the other that turns about its vertical."""

    n_channels: int
    n_columns: int
    """Shots of each channel in a whole turn."""
    range_m: float
    upper_deg: float
    lower_deg: float
    first_deg: float
    last_deg: float
    pose: Pose
    frame: str

    @property
    def directions(self) -> Float[np.ndarray, "n 3"]:
        """Unit directions of a turn, forward-right-down in its own frame."""
        azimuth_deg = np.arange(self.n_columns) * (360.0 / self.n_columns)
        first, last = self.first_deg % 360.0, self.last_deg % 360.0
        is_after, is_before = azimuth_deg >= first, azimuth_deg <= last
        azimuth_deg = azimuth_deg[is_after & is_before if first < last else is_after | is_before]
        # AirSim: from the upper end down, both ends included; one channel is the upper end.
        elevation = np.radians(np.linspace(self.upper_deg, self.lower_deg, self.n_channels))
        azimuth = np.radians(azimuth_deg)[:, None]
        level = np.cos(elevation)[None, :]
        directions = [level * np.cos(azimuth), level * np.sin(azimuth)]
        down = np.broadcast_to(-np.sin(elevation)[None, :], directions[0].shape)
        return np.stack([*directions, down], axis=2).reshape(-1, 3)


class Rangers:
    """Casts rays from one vehicle."""

    def __init__(
        self, plant: Plant, distances: Mapping[str, DistanceCfg], lidars: Mapping[str, LidarCfg]
    ) -> None:
        """Carry sensors by their names."""
        self._plant, self.distances, self.lidars = plant, distances, lidars
        self._rays: np.ndarray | None = None

    def distance_m(self, cfg: DistanceCfg) -> float:
        """Distance that a sensor measures now, within its bounds."""
        origin, turn = self.mount(cfg.pose)
        hit_m = self.cast(origin, turn[:, :1].T)[0]
        return float(np.clip(hit_m, cfg.least_m, cfg.most_m))

    def scan(self, cfg: LidarCfg) -> tuple[Float[np.ndarray, "n 3"], Vector3, np.ndarray]:
        """Points of a turn now.

        Returns:
            Points in the lidar's own frame, forward-right-down; its position and its axes in the
            scene, ENU.
        """
        origin, turn = self.mount(cfg.pose)
        directions = cfg.directions
        hit_m = self.cast(origin, directions @ turn.T)
        is_met = hit_m <= cfg.range_m
        x, y, z = origin.tolist()
        return directions[is_met] * hit_m[is_met, None], (x, y, z), turn

    def mount(self, pose: Pose) -> tuple[Float[np.ndarray, 3], Float[np.ndarray, "3 3"]]:
        """Position of a part in the scene, and its axes forward, right and down as columns."""
        truth = self._plant.truth
        enu_from_frd = rotation(truth.quat_wxyz) @ FRD_FROM_FLU
        p, q = pose.position, pose.orientation
        offset = np.array([p.x_val, p.y_val, p.z_val])
        turn = enu_from_frd @ rotation((q.w_val, q.x_val, q.y_val, q.z_val))
        return np.array(truth.position_enu_m) + enu_from_frd @ offset, turn

    def cast(
        self, origin_enu_m: Float[np.ndarray, 3], directions_enu: Float[np.ndarray, "n 3"]
    ) -> Float[np.ndarray, " n"]:
        """Distance to what each ray meets first, without the vehicle itself; infinite for none."""
        plant = self._plant
        if self._rays is None:
            self._rays = new_rays(plant.world, plant.data, plant.world.wide_rays)
        rays = np.empty((len(directions_enu), 6))
        rays[:, :3], rays[:, 3:] = origin_enu_m, directions_enu
        distance_m = np.empty(len(rays))
        cast_rays(self._rays, rays, plant.world.vehicle_body_id, distance_m)
        return distance_m


def named(sensors: Mapping[str, _Sensor], name: str, kind: str) -> _Sensor:
    """A sensor by its name; without a name the first.

    Raises:
        RpcError: If there is none.
    """
    if not sensors:
        raise RpcError(f"the vehicle has no {kind}; valid: --airsim-settings with one")
    if name and name not in sensors:
        raise RpcError(f"{kind} {name[:80]!r} is unknown; valid: {', '.join(sensors)}")
    return sensors[name] if name else next(iter(sensors.values()))


def quaternion_ned(turn_enu_from_frd: Float[np.ndarray, "3 3"]) -> Quaternionr:
    """Attitude from forward-right-down to north-east-down of axes in the scene."""
    from scipy.spatial.transform import Rotation

    rotation_ned = Rotation.from_matrix(NED_FROM_ENU @ turn_enu_from_frd)
    return Quaternionr(*rotation_ned.as_quat(scalar_first=True, canonical=True).tolist())
