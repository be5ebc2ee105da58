"""Past estimates of the last IMU ticks, for measurements that arrive late.

A late measurement must be compared with the estimate of its own time, as that is known today.
Recomputing the past after each correction would be dear, and comparing with an old, uncorrected
estimate would count errors twice. A correction now (dp of position, dv of velocity, at time t)
means that the estimate of an earlier time s was wrong by dp - (t - s) dv. Summed over all
corrections since s that is

    A(now) - A(s) - (B(now) - B(s)) + s (D(now) - D(s)),   A = sum dp, B = sum t dv, D = sum dv,

so a tick keeps its estimate less these sums, and a correction touches three sums, not the past.
"""

from __future__ import annotations

import numpy as np

from autonomy.estimation.error_state import N_PAST, POSITION, VELOCITY
from autonomy.jit import kernel
from autonomy.rotation import yaw_from_quat


@kernel
def remember(f: np.record) -> None:
    """Store the estimate of the present tick; call it once per tick, after the propagation."""
    slot = f.tick % N_PAST
    now_s = f.tick * f.dt_s
    for i in range(3):
        sums = f.moved_enu_m[i] - f.moved_moment_enu_m[i] + now_s * f.moved_velocity_enu_mps[i]
        f.past_position_enu_m[slot, i] = f.position_enu_m[i] - sums
        f.past_velocity_enu_mps[slot, i] = f.velocity_enu_mps[i] - f.moved_velocity_enu_mps[i]
    f.past_yaw_rad[slot] = yaw_from_quat(f.quat_wxyz) - f.moved_yaw_rad


@kernel
def past_position(f: np.record, age_ticks: int, i: int) -> float:
    """Component i of the position `age_ticks` ago, m, corrected by all measurements since."""
    then_s = (f.tick - age_ticks) * f.dt_s
    sums = f.moved_enu_m[i] - f.moved_moment_enu_m[i] + then_s * f.moved_velocity_enu_mps[i]
    return f.past_position_enu_m[(f.tick - age_ticks) % N_PAST, i] + sums


@kernel
def write_past_position_row(f: np.record, h: np.ndarray, age_ticks: int, i: int) -> None:
    """Write the derivative of `past_position` by the present state to a row."""
    h[:] = 0.0
    h[POSITION + i] = 1.0
    h[VELOCITY + i] = -age_ticks * f.dt_s


@kernel
def past_velocity(f: np.record, age_ticks: int, i: int) -> float:
    """Component i of the velocity `age_ticks` ago, m/s, corrected by all measurements since."""
    slot = (f.tick - age_ticks) % N_PAST
    return f.past_velocity_enu_mps[slot, i] + f.moved_velocity_enu_mps[i]


@kernel
def past_yaw(f: np.record, age_ticks: int) -> float:
    """Heading `age_ticks` ago, rad, corrected by all measurements since; not wrapped."""
    return f.past_yaw_rad[(f.tick - age_ticks) % N_PAST] + f.moved_yaw_rad


@kernel
def restart_past(f: np.record) -> None:
    """Refill the past as if the vehicle had always flown at its present velocity and heading."""
    tick = f.tick
    x, y, z = f.position_enu_m[0], f.position_enu_m[1], f.position_enu_m[2]
    # Oldest first, so that the loop ends with `f.tick` and the position as they were.
    for age in range(N_PAST - 1, -1, -1):
        f.tick = tick - age
        f.position_enu_m[0] = x - age * f.dt_s * f.velocity_enu_mps[0]
        f.position_enu_m[1] = y - age * f.dt_s * f.velocity_enu_mps[1]
        f.position_enu_m[2] = z - age * f.dt_s * f.velocity_enu_mps[2]
        remember(f)
