"""Position and heading in the world by motion capture, or by another source that knows them.

Such a source measures in the world's own frame. Its poses are therefore fused directly, without the
drifting frame that odometry needs (`odometry`).
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation.error_state import BARO_OFFSET, N_STATES, VELOCITY
from autonomy.estimation.past import (
    past_position,
    past_velocity,
    past_yaw,
    restart_past,
    write_past_position_row,
)
from autonomy.estimation.update import scalar_update, write_heading_row
from autonomy.jit import kernel
from autonomy.rotation import wrap_angle

_MOCAP_POSITION, _MOCAP_YAW, _VELOCITY = 6, 7, 9  # rows of MEASUREMENTS


@kernel
def fuse_mocap(f: np.record, position_enu_m: np.ndarray, yaw_rad: float, age_ticks: int) -> None:
    """Fuse a pose (position (3,), heading) that was valid `age_ticks` < `N_PAST` ago.

    Variances are those of the configuration; `fuse_pose` takes others.
    """
    variance, yaw_variance = f.mocap_variance_m2, f.mocap_yaw_variance_rad2
    fuse_pose(f, position_enu_m, yaw_rad, age_ticks, variance, variance, yaw_variance)


@kernel
def fuse_pose(
    f: np.record,
    position_enu_m: np.ndarray,
    yaw_rad: float,
    age_ticks: int,
    level_variance_m2: float,
    height_variance_m2: float,
    yaw_variance_rad2: float,
) -> tuple[float, float]:
    """Fuse a pose with the variances of its noise; an infinite one leaves its axis out.

    Args:
        f: The filter.
        position_enu_m: Position (3,).
        yaw_rad: Heading.
        age_ticks: Time since the pose was valid, below `N_PAST`.
        level_variance_m2: Variance of each horizontal axis.
        height_variance_m2: Variance of the height.
        yaw_variance_rad2: Variance of the heading.

    Returns:
        Squared innovation over its squared gate, of the worst axis and of the heading; what is
        above 1 was rejected.
    """
    h = f.measurement_row
    worst = yaw_ratio = 0.0
    for i in range(3):
        variance = level_variance_m2 if i < 2 else height_variance_m2
        # An infinite variance would give a gain of NaN, so the axis is skipped.
        if variance < math.inf:
            write_past_position_row(f, h, age_ticks, i)
            innovation = position_enu_m[i] - past_position(f, age_ticks, i)
            worst = max(worst, scalar_update(f, _MOCAP_POSITION, innovation, variance))
    h[:] = 0.0
    if yaw_variance_rad2 < math.inf and write_heading_row(f.quat_wxyz, h):
        innovation = wrap_angle(yaw_rad - past_yaw(f, age_ticks))
        yaw_ratio = scalar_update(f, _MOCAP_YAW, innovation, yaw_variance_rad2)
    if worst <= 1.0:
        f.last_position_tick = f.tick
    return worst, yaw_ratio


@kernel
def fuse_velocity(
    f: np.record, velocity_enu_mps: np.ndarray, age_ticks: int, variance_m2ps2: float
) -> None:
    """Fuse a velocity (3,) that was valid `age_ticks` ago, each axis with the same variance."""
    h = f.measurement_row
    for i in range(3):
        h[:] = 0.0
        h[VELOCITY + i] = 1.0
        innovation = velocity_enu_mps[i] - past_velocity(f, age_ticks, i)
        scalar_update(f, _VELOCITY, innovation, variance_m2ps2)


@kernel
def restart_position(
    f: np.record,
    position_enu_m: np.ndarray,
    age_ticks: int,
    level_variance_m2: float,
    height_variance_m2: float,
) -> None:
    """Restart the position from one (3,) that was valid `age_ticks` ago.

    An axis of infinite variance stays as it is. The barometer goes on from the new height, and the
    frame of odometry must be placed anew.
    """
    age_s = age_ticks * f.dt_s
    P = f.covariance
    for i in range(3):
        variance = level_variance_m2 if i < 2 else height_variance_m2
        if not variance < math.inf:
            continue
        # Correlations with other states belong to the old position.
        for j in range(N_STATES):
            P[i, j] = P[j, i] = 0.0
        P[i, i] = variance
        before = f.position_enu_m[i]
        f.position_enu_m[i] = position_enu_m[i] + age_s * f.velocity_enu_mps[i]
        if i == 2:
            f.baro_offset_m -= f.position_enu_m[i] - before
            P[BARO_OFFSET, BARO_OFFSET] += variance
    restart_past(f)
    f.has_vio = 0
    f.last_position_tick = f.tick
