"""An eye that follows the vehicle from behind and above, and never through a wall.

The eye sits at a fixed distance behind the heading of the motion. A ray from the vehicle towards
the eye finds walls between them; the eye then comes closer at once, and moves away again slowly.
Heading and distance follow by first-order filters, because a camera that jumps is hard to watch.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from autonomy.types import Quaternion, Vector3
from flightsim.looks.geom_groups import GeomGroup
from flightsim.world import World

FOV_RAD = math.radians(55.0)
"""Vertical angle of view that the distance is made for."""
_BEHIND_M, _ABOVE_M = 2.9, 1.6
_FULL_M = math.hypot(_BEHIND_M, _ABOVE_M)
# Right to left: a camera that looks east along the horizon, then pitched down at the vehicle.
_LOOK_WXYZ = (
    (
        Rotation.from_euler("y", math.atan2(_ABOVE_M, _BEHIND_M))
        * Rotation.from_quat((0.5, -0.5, 0.5, -0.5), scalar_first=True)
    )
    .as_quat(scalar_first=True)
    .tolist()
)
"""Attitude of a camera (x right, y down, z ahead) that looks east and down at the vehicle."""
_STEPS_A_LOOK = 3
"""Number of steps from one check for walls to the next."""
_LEAST_M = 0.7
"""Least distance of the eye from the vehicle, whatever is behind it."""
_CLEAR_OF_WALLS = 0.85
"""Share of the distance to the obstacle behind the vehicle at which the eye stays."""
_TURN_S, _APPROACH_S = 0.9, 0.5
"""Time in which the eye follows a turn, or makes room again, by all but a third."""
_MOVING_MPS = 0.4
"""Speed below which the direction of the motion is ignored, because a hover drifts anywhere."""
# Rays test the scene alone: neither the vehicle itself nor movers count as walls.
_WALLS = (np.arange(mujoco.mjNGROUP) == GeomGroup.SCENE).astype(np.uint8)


class ChaseEye:
    """Position and attitude of the eye, step by step; it looks along the flown path."""

    def __init__(self, world: World, heading_rad: float) -> None:
        """Start behind a vehicle.

        Args:
            world: World of static obstacles.
            heading_rad: First heading of the vehicle, counter-clockwise from east.
        """
        self._model, self._data = world.model, world.new_data()
        self._heading_rad = heading_rad
        self._distance_m = self._room_m = _FULL_M
        self._n_steps = 0
        self._geom = np.zeros(1, dtype=np.int32)

    def follow(
        self,
        position_enu_m: Float[np.ndarray, " 3"],
        velocity_enu_mps: Float[np.ndarray, " 3"],
        step_s: float,
    ) -> Vector3:
        """Move the eye by a step, and return its position.

        Args:
            position_enu_m: Position of the vehicle after the step.
            velocity_enu_mps: Velocity of the vehicle; its horizontal part turns the eye.
            step_s: Duration of the step, greater than 0.

        Returns:
            Position of the eye, ENU in m. `quat_wxyz` is its attitude there.
        """
        u, v, _ = velocity_enu_mps.tolist()
        if math.hypot(u, v) > _MOVING_MPS:
            # The remainder is the shorter turn, in -pi to pi.
            turn_rad = math.remainder(math.atan2(v, u) - self._heading_rad, math.tau)
            self._heading_rad += turn_rad * min(1.0, step_s / _TURN_S)
        level = -_BEHIND_M / _FULL_M
        a, b = level * math.cos(self._heading_rad), level * math.sin(self._heading_rad)
        c = _ABOVE_M / _FULL_M
        if self._n_steps % _STEPS_A_LOOK == 0:
            away = np.array([a, b, c])
            hit_m = mujoco.mj_ray(
                self._model, self._data, position_enu_m, away, _WALLS, 1, -1, self._geom
            )
            clear_m = max(_LEAST_M, _CLEAR_OF_WALLS * hit_m)
            # MuJoCo returns -1 if the ray meets nothing.
            self._room_m = _FULL_M if hit_m < 0 else min(_FULL_M, clear_m)
        self._n_steps += 1
        grown_m = self._distance_m + (_FULL_M - self._distance_m) * min(1.0, step_s / _APPROACH_S)
        # Walls limit the distance at once, and only the way back is slow.
        d = self._distance_m = min(self._room_m, grown_m)
        x, y, z = position_enu_m.tolist()
        return (x + d * a, y + d * b, z + d * c)

    @property
    def quat_wxyz(self) -> Quaternion:
        """Attitude of a camera there (x right, y down, z ahead) that looks at the vehicle."""
        w, x, y, z = _LOOK_WXYZ
        # The quaternion product of a turn by the heading about z and `_LOOK_WXYZ`, written out.
        cos, sin = math.cos(self._heading_rad / 2), math.sin(self._heading_rad / 2)
        return (cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w)
