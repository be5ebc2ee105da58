"""An eye that follows the vehicle from behind and above, and never through a wall."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3, vector3
from flightsim.geom_groups import GeomGroup
from flightsim.world import World

FOV_RAD = math.radians(55.0)
"""Vertical angle of view that the distance is made for."""
_BEHIND_M, _ABOVE_M = 2.9, 1.6
_LEAST_M = 0.7
"""The eye comes no nearer, whatever is behind the vehicle."""
_CLEAR_OF_WALLS = 0.85
"""Of the way to what is behind the vehicle, where the eye stays."""
_TURN_S, _APPROACH_S = 0.9, 0.5
"""Time in which the eye follows a turn, or makes room again, by all but a third."""
_MOVING_MPS = 0.4
"""Slower than this, the direction of the motion means nothing."""
_WALLS = (np.arange(mujoco.mjNGROUP) == GeomGroup.SCENE).astype(np.uint8)


class ChaseEye:
    """Where the eye is, step by step; looks along the way that is flown."""

    def __init__(self, world: World, heading_rad: float) -> None:
        """Begin behind a vehicle.

        Args:
            world: What stands about.
            heading_rad: Where the vehicle looks at first, counter-clockwise from east.
        """
        self._model, self._data = world.model, world.new_data()
        self._heading_rad = heading_rad
        self._distance_m = math.hypot(_BEHIND_M, _ABOVE_M)
        self._geom = np.zeros(1, dtype=np.int32)

    def follow(
        self,
        position_enu_m: Float[np.ndarray, " 3"],
        velocity_enu_mps: Float[np.ndarray, " 3"],
        step_s: float,
    ) -> Vector3:
        """Where the eye is after a step; it looks at the vehicle."""
        u, v, _ = velocity_enu_mps.tolist()
        if math.hypot(u, v) > _MOVING_MPS:
            turn_rad = math.remainder(math.atan2(v, u) - self._heading_rad, math.tau)
            self._heading_rad += turn_rad * min(1.0, step_s / _TURN_S)
        cos, sin = math.cos(self._heading_rad), math.sin(self._heading_rad)
        away = np.array([-_BEHIND_M * cos, -_BEHIND_M * sin, _ABOVE_M])
        full_m = float(np.linalg.norm(away))
        away /= full_m
        hit_m = mujoco.mj_ray(
            self._model, self._data, position_enu_m, away, _WALLS, 1, -1, self._geom
        )
        room_m = full_m if hit_m < 0 else min(full_m, max(_LEAST_M, _CLEAR_OF_WALLS * hit_m))
        grown_m = self._distance_m + (full_m - self._distance_m) * min(1.0, step_s / _APPROACH_S)
        self._distance_m = min(room_m, grown_m)
        return vector3(position_enu_m + self._distance_m * away)
