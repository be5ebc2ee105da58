"""Recovery from any attitude and rate: first the tilt, then the fall, then the yaw.

A vehicle tilted beyond 90 degrees cannot track anything, because its thrust points down. One that
rotates faster than any trajectory demands cannot aim its thrust. Until it is level and its fall is
braked, the commanded attitude is level at the heading of the shortest rotation, so that no torque
goes into yaw, and the thrust only brakes the fall. The torques have the allocation's first
priority. The collective is the demanded force along the thrust axis, so it is zero while that axis
points down.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.control.reference import start_reference
from autonomy.jit import kernel

_TUMBLING_RATE_RADPS = 8.0
"""Rate of roll and pitch together; at 1 g of acceleration it takes a jerk of 110 m/s^3."""
# A recovery ends only when the vehicle is within these limits, so that tracking can take over.
_LEVEL_COSINE = math.cos(math.radians(25.0))
_LEVEL_RATE_RADPS = 3.0
_BRAKED_MPS = 1.5


@kernel
def watch_recovery(c: np.record, x: np.record) -> None:
    """Begin a recovery when the vehicle tumbles; end it when it is level, calm and stops falling.

    At the end the reference restarts at the vehicle. `c.R` must be the vehicle's attitude.
    """
    rate = math.hypot(x.angular_rate_flu_radps[0], x.angular_rate_flu_radps[1])
    if c.is_recovering == 0:
        c.is_recovering = 1 if c.R[2, 2] < 0.0 or rate > _TUMBLING_RATE_RADPS else 0
        return
    is_level = c.R[2, 2] > _LEVEL_COSINE and rate < _LEVEL_RATE_RADPS
    if is_level and x.velocity_enu_mps[2] > -_BRAKED_MPS:
        c.is_recovering = 0
        start_reference(c, x)


@kernel
def demand_recovery(c: np.record, x: np.record) -> None:
    """Demand a level attitude at the nearest heading, and the force that brakes the fall."""
    c.force_enu_mps2[0] = c.force_enu_mps2[1] = 0.0
    force = c.gravity_mps2 - c.velocity_gain * x.velocity_enu_mps[2]
    c.force_enu_mps2[2] = min(max(force, 0.0), c.max_thrust_mps2)
    # Heading of the shortest rotation to level: the twist part of the quaternion about the
    # vertical. Euler yaw would jump when the vehicle is upside down.
    yaw = 2.0 * math.atan2(x.quat_wxyz[3], x.quat_wxyz[0])
    c.reference_yaw_rad = yaw
    c.R_cmd[:] = 0.0
    c.R_cmd[0, 0] = c.R_cmd[1, 1] = math.cos(yaw)
    c.R_cmd[1, 0] = math.sin(yaw)
    c.R_cmd[0, 1] = -c.R_cmd[1, 0]
    c.R_cmd[2, 2] = 1.0
    c.rate_cmd_flu_radps[:] = 0.0
    c.setpoint_age_s += c.dt_s
