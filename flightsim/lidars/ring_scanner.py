"""A level ring of range beams about the vehicle, like those of a small spinning lidar.

Flight stacks want the distances to obstacles as a ring (OBSTACLE_DISTANCE), which this makes from
the same solids as the lidars.
"""

from __future__ import annotations

import mujoco
import numpy as np

from autonomy.types import Vector3
from flightsim.plant.rays import cast_rays, new_rays
from flightsim.world import World

N_BEAMS = 72  # 5 degrees apart, as many as OBSTACLE_DISTANCE carries
MIN_RANGE_M, MAX_RANGE_M = 0.2, 30.0


class RingScanner:
    """Scanner of the true world: all that a vehicle can collide with, but not that vehicle."""

    def __init__(self, world: World, data: mujoco.MjData) -> None:
        self._rays = new_rays(world, data, world.wide_rays)
        self._vehicle_body = world.vehicle_body_id
        self._beams_enu_m = np.zeros((N_BEAMS, 6))
        self._ranges_m = np.zeros(N_BEAMS)

    def scan_m(self, position_enu_m: Vector3, yaw_rad: float) -> list[float]:
        """Return the distance along each beam, clockwise from the nose; infinite out of range.

        Args:
            position_enu_m: Place of the scanner.
            yaw_rad: Heading of the nose, counter-clockwise from east.

        Returns:
            Distances of 72 beams, 5 degrees apart.
        """
        bearings_rad = yaw_rad - np.arange(N_BEAMS) * (2.0 * np.pi / N_BEAMS)
        self._beams_enu_m[:, :3] = position_enu_m
        self._beams_enu_m[:, 3], self._beams_enu_m[:, 4] = (
            np.cos(bearings_rad),
            np.sin(bearings_rad),
        )
        cast_rays(self._rays, self._beams_enu_m, self._vehicle_body, self._ranges_m)
        return np.where(self._ranges_m <= MAX_RANGE_M, self._ranges_m, np.inf).tolist()
