"""Visual-inertial odometry: position and heading in its own, drifting frame.

Odometry knows how far the vehicle went, not where it is. The filter therefore estimates where the
odometry's frame lies in the world.

    symbol   name                                     unit
    p        position of the vehicle, ENU             m
    o, a     origin and heading of the VIO frame      m, rad
    m, b     position and heading that VIO reports    m, rad

    p = o + Rz(a) m + noise,   heading(q) = a + b + noise

Both o and a drift per metre flown: o by a random walk, a by another about the vehicle's position,
so that a turn of the frame moves its origin and not the vehicle. GNSS and magnetometer tie the
frame to the world; without them its drift becomes uncertainty of position and heading.

Source: Lynen et al. 2013, "A robust and modular multi-sensor fusion approach applied to MAV
navigation", section IV-C (drift states of relative measurements).
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation.error_state import N_STATES, VIO_ORIGIN, VIO_YAW
from autonomy.estimation.past import past_position, past_yaw, write_past_position_row
from autonomy.estimation.update import GROSS_RATIO, gate_ratio, scalar_update, write_heading_row
from autonomy.jit import kernel
from autonomy.rotation import wrap_angle

_VIO_POSITION, _VIO_YAW = 4, 5  # rows of MEASUREMENTS
_MAX_REJECTIONS = 30
"""Consecutive rejected poses after which the odometry counts as restarted elsewhere, so that its
frame is placed anew."""


@kernel
def fuse_vio(f: np.record, position_vio_m: np.ndarray, yaw_vio_rad: float, age_ticks: int) -> None:
    """Fuse a pose, m (3,) and b of the module's table, that was valid `age_ticks` < `N_PAST` ago.

    The first pose places the odometry's frame and corrects nothing.
    """
    variance, yaw_variance = f.vio_variance_m2, f.vio_yaw_variance_rad2
    fuse_odometry(f, position_vio_m, yaw_vio_rad, age_ticks, variance, variance, yaw_variance)


@kernel
def fuse_odometry(
    f: np.record,
    position_vio_m: np.ndarray,
    yaw_vio_rad: float,
    age_ticks: int,
    level_variance_m2: float,
    height_variance_m2: float,
    yaw_variance_rad2: float,
) -> None:
    """Fuse a pose of any odometry, with the variances of its noise.

    Args:
        f: The filter.
        position_vio_m: m (3,).
        yaw_vio_rad: b.
        age_ticks: Time since the pose was valid, below `N_PAST`.
        level_variance_m2: Variance of each horizontal axis; infinite leaves them out.
        height_variance_m2: Variance of the height; infinite leaves it out.
        yaw_variance_rad2: Variance of b; infinite leaves it out.
    """
    if f.has_vio == 0:
        _place_frame(f, position_vio_m, yaw_vio_rad, age_ticks)
        return
    _let_drift(f, position_vio_m)
    h = f.measurement_row
    # Gates of all axes first: if one is grossly wrong, none is fused.
    worst = 0.0
    for i in range(3):
        variance = level_variance_m2 if i < 2 else height_variance_m2
        if variance < math.inf:
            innovation = _innovation(f, position_vio_m, age_ticks, i)
            worst = max(worst, gate_ratio(f, innovation, variance))
    if worst <= GROSS_RATIO:
        worst = 0.0
        for i in range(3):
            variance = level_variance_m2 if i < 2 else height_variance_m2
            if variance < math.inf:
                innovation = _innovation(f, position_vio_m, age_ticks, i)
                worst = max(worst, scalar_update(f, _VIO_POSITION, innovation, variance))
        h[:] = 0.0
        if yaw_variance_rad2 < math.inf and write_heading_row(f.quat_wxyz, h):
            h[VIO_YAW] = -1.0
            innovation = wrap_angle(yaw_vio_rad + f.vio_yaw_rad - past_yaw(f, age_ticks))
            worst = max(worst, scalar_update(f, _VIO_YAW, innovation, yaw_variance_rad2))
    _count(f, worst)


@kernel
def _innovation(f: np.record, position_vio_m: np.ndarray, age_ticks: int, i: int) -> float:
    """Write the row of one axis; return how far the pose lies beyond the estimate along it, m."""
    h = f.measurement_row
    east, north = _turned(f, position_vio_m)
    turned = east if i == 0 else (north if i == 1 else position_vio_m[2])
    write_past_position_row(f, h, age_ticks, i)
    h[VIO_ORIGIN + i] = -1.0
    h[VIO_YAW] = north if i == 0 else (-east if i == 1 else 0.0)
    return f.vio_origin_enu_m[i] + turned - past_position(f, age_ticks, i)


@kernel
def _count(f: np.record, worst: float) -> None:
    if worst <= 1.0:
        f.vio_rejections = 0
        f.last_position_tick = f.tick
        return
    f.vio_rejections += 1
    if f.vio_rejections >= _MAX_REJECTIONS:
        f.vio_rejections = 0
        f.has_vio = 0


@kernel
def _turned(f: np.record, position_vio_m: np.ndarray) -> tuple[float, float]:
    """East and north of Rz(a) m."""
    c, s = math.cos(f.vio_yaw_rad), math.sin(f.vio_yaw_rad)
    x, y = position_vio_m[0], position_vio_m[1]
    return c * x - s * y, s * x + c * y


@kernel
def _let_drift(f: np.record, position_vio_m: np.ndarray) -> None:
    """Add process noise to the frame for the distance flown since the last pose.

    A turn w of the frame about the vehicle moves its origin by -w ez x Rz(a) m.
    """
    v = f.velocity_enu_mps
    speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    way_m = speed * (f.tick - f.last_vio_tick) * f.dt_s
    f.last_vio_tick = f.tick
    P = f.covariance
    for i in range(3):
        P[VIO_ORIGIN + i, VIO_ORIGIN + i] += f.vio_walk_m2pm[i] * way_m
    east, north = _turned(f, position_vio_m)
    g = f.gain  # free until the next update
    g[0], g[1], g[2], g[3] = north, -east, 0.0, 1.0
    for i in range(4):
        for j in range(4):
            P[VIO_ORIGIN + i, VIO_ORIGIN + j] += f.vio_yaw_walk_rad2pm * way_m * g[i] * g[j]


@kernel
def _place_frame(
    f: np.record, position_vio_m: np.ndarray, yaw_vio_rad: float, age_ticks: int
) -> None:
    """Place the frame so that its pose agrees with the estimate, and correlate the two."""
    h = f.measurement_row
    h[:] = 0.0
    # Without a heading, such as with the nose straight up, the frame is placed by a later pose.
    if not write_heading_row(f.quat_wxyz, h):
        return
    f.vio_yaw_rad = wrap_angle(past_yaw(f, age_ticks) - yaw_vio_rad)
    east, north = _turned(f, position_vio_m)
    # The heading first: the rows of the origin refer to it.
    _clone(f, VIO_YAW, f.vio_yaw_variance_rad2)
    for i in range(3):
        turned = east if i == 0 else (north if i == 1 else position_vio_m[2])
        f.vio_origin_enu_m[i] = past_position(f, age_ticks, i) - turned
        write_past_position_row(f, h, age_ticks, i)
        h[VIO_YAW] = north if i == 0 else (-east if i == 1 else 0.0)
        _clone(f, VIO_ORIGIN + i, f.vio_variance_m2)
    f.has_vio = 1
    f.last_vio_tick = f.tick


@kernel
def _clone(f: np.record, k: int, variance: float) -> None:
    """Set state k to the combination of the others in `f.measurement_row`, plus noise."""
    P, h, row = f.covariance, f.measurement_row, f.gain
    for j in range(N_STATES):
        P[k, j] = P[j, k] = 0.0
    for j in range(N_STATES):
        row[j] = 0.0
        for i in range(N_STATES):
            row[j] += h[i] * P[i, j]
    total = variance
    for j in range(N_STATES):
        total += h[j] * row[j]
    for j in range(N_STATES):
        P[k, j] = P[j, k] = row[j]
    P[k, k] = total
