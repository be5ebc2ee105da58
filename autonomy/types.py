"""Types of guidance, navigation and control: states, references and setpoints.

World frame ENU, body frame FLU, SI units, radians, quaternions `wxyz` body to world. Vectors are
tuples of floats and not arrays, because the code that fills and reads them runs at 50 Hz or more in
plain Python, where small arrays are slow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

NAN3: Vector3 = (math.nan, math.nan, math.nan)  # "not given", axis by axis
ZERO3: Vector3 = (0.0, 0.0, 0.0)
LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)
"""Attitude without rotation: level, heading east."""


def vector3(values: np.ndarray) -> Vector3:
    """Return the components of an array (3,) as a tuple of Python floats."""
    x, y, z = values.tolist()
    return (x, y, z)


def quat_about_up(yaw_rad: float) -> Quaternion:
    """Return the upright attitude whose heading is `yaw_rad`, counter-clockwise from east."""
    return (math.cos(0.5 * yaw_rad), 0.0, 0.0, math.sin(0.5 * yaw_rad))


def yaw_of(quat_wxyz: Quaternion) -> float:
    """Return the heading of an attitude, counter-clockwise from east to body x, rad."""
    w, x, y, z = quat_wxyz
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@dataclass(frozen=True, kw_only=True, slots=True)
class State:
    """Rigid-body state, true or estimated."""

    time_us: int
    position_enu_m: Vector3
    velocity_enu_mps: Vector3
    quat_wxyz: Quaternion
    angular_rate_flu_radps: Vector3


@dataclass(frozen=True, kw_only=True, slots=True)
class FlatReference:
    """A point of a trajectory in the quadrotor's flat outputs, position and yaw.

    Position and yaw with their derivatives determine attitude, rates and thrust; see
    `autonomy.model.flatness`.
    """

    position_enu_m: Vector3
    velocity_enu_mps: Vector3 = ZERO3
    acceleration_enu_mps2: Vector3 = ZERO3
    jerk_enu_mps3: Vector3 = ZERO3
    yaw_rad: float = 0.0
    yaw_rate_radps: float = 0.0


class ControlLevel(IntEnum):
    """Level at which a setpoint enters the cascade of controllers.

    Levels above `IDLE` fly; the inner loops below a level always run.
    """

    OFF = 0
    """Rotors stopped."""
    IDLE = 1
    """Armed on the ground, rotors at idle speed."""
    TRAJECTORY = 2
    """Position, velocity and acceleration; NaN leaves an axis of that quantity free."""
    ATTITUDE = 3
    """Attitude quaternion and normalised collective thrust."""
    RATE = 4
    """Body rates and normalised collective thrust."""
    ROTORS = 5
    """Speeds of the rotors, which a flight stack outside of ours commands."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Setpoint:
    """Demand of the outer loops on the inner ones until the next setpoint.

    At `TRAJECTORY` each axis follows position where it is finite, else velocity where it is finite,
    else the acceleration alone; finite lower derivatives are feed-forward. A NaN yaw leaves the
    heading to `yaw_rate_radps` (0 holds it). A jerk of zero means that it is unknown: the
    controller then derives it from successive accelerations.
    """

    level: ControlLevel
    position_enu_m: Vector3 = NAN3
    velocity_enu_mps: Vector3 = NAN3
    acceleration_enu_mps2: Vector3 = NAN3
    jerk_enu_mps3: Vector3 = ZERO3
    yaw_rad: float = math.nan
    yaw_rate_radps: float = 0.0
    quat_wxyz: Quaternion = LEVEL
    angular_rate_flu_radps: Vector3 = ZERO3
    thrust: float = 0.0
    """Collective thrust as a fraction of the maximum, 0 to 1; for `ATTITUDE` and `RATE`."""


OFF = Setpoint(level=ControlLevel.OFF)
IDLE = Setpoint(level=ControlLevel.IDLE)
