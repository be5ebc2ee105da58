"""The measurements: GNSS position and velocity (late), barometric height, magnetic heading."""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation.error_state import (
    ATTITUDE,
    BARO_OFFSET,
    N_PAST,
    N_STATES,
    POSITION,
    VELOCITY,
)
from autonomy.estimation.update import scalar_update
from autonomy.jit import kernel
from autonomy.rotation import matrix_from_quat, wrap_angle


@kernel
def fuse_gnss(
    f: np.record,
    position_enu_m: np.ndarray,
    velocity_enu_mps: np.ndarray,
    age_ticks: int,
    sigma_m: np.ndarray,
    sigma_mps: np.ndarray,
) -> None:
    """Fuse a fix that was valid `age_ticks` ago, against the estimate of that time.

    Args:
        f: The filter.
        position_enu_m: Measured position (3,).
        velocity_enu_mps: Measured velocity (3,).
        age_ticks: IMU ticks since the time of validity, below `N_PAST`.
        sigma_m: Standard deviation of each position component (3,).
        sigma_mps: Standard deviation of each velocity component (3,).
    """
    slot = (f.tick - age_ticks) % N_PAST
    h = f.measurement_row
    f.ratio_gnss_position = 0.0
    f.ratio_gnss_velocity = 0.0
    for i in range(3):
        h[:] = 0.0
        h[POSITION + i] = 1.0
        h[VELOCITY + i] = -age_ticks * f.dt_s
        innovation = position_enu_m[i] - f.past_position_enu_m[slot, i]
        ratio = scalar_update(f, innovation, sigma_m[i] * sigma_m[i])
        f.ratio_gnss_position = max(f.ratio_gnss_position, ratio)
        h[:] = 0.0
        h[VELOCITY + i] = 1.0
        innovation = velocity_enu_mps[i] - f.past_velocity_enu_mps[slot, i]
        ratio = scalar_update(f, innovation, sigma_mps[i] * sigma_mps[i])
        f.ratio_gnss_velocity = max(f.ratio_gnss_velocity, ratio)
    if f.ratio_gnss_position <= 1.0:
        f.gnss_rejections = 0
        f.last_gnss_tick = f.tick
        return
    f.gnss_rejections += 1
    if f.gnss_rejections >= f.max_gnss_rejections:
        _restart(f, position_enu_m, velocity_enu_mps, age_ticks, sigma_m, sigma_mps)


@kernel
def _restart(
    f: np.record,
    position_enu_m: np.ndarray,
    velocity_enu_mps: np.ndarray,
    age_ticks: int,
    sigma_m: np.ndarray,
    sigma_mps: np.ndarray,
) -> None:
    """Position and velocity start again from a fix; what is left keeps its estimate."""
    age_s = age_ticks * f.dt_s
    P = f.covariance
    for i in range(6):
        for j in range(N_STATES):
            P[i, j] = P[j, i] = 0.0
    for i in range(3):
        f.velocity_enu_mps[i] = velocity_enu_mps[i]
        f.position_enu_m[i] = position_enu_m[i] + age_s * velocity_enu_mps[i]
        P[i, i] = sigma_m[i] * sigma_m[i]
        P[3 + i, 3 + i] = sigma_mps[i] * sigma_mps[i]
        for slot in range(N_PAST):
            age = ((f.tick - slot) % N_PAST) * f.dt_s
            f.past_velocity_enu_mps[slot, i] = velocity_enu_mps[i]
            f.past_position_enu_m[slot, i] = f.position_enu_m[i] - age * velocity_enu_mps[i]
    # the restart may move the height by metres: what the barometer says then is no longer known
    P[BARO_OFFSET, BARO_OFFSET] += sigma_m[2] * sigma_m[2]
    f.gnss_rejections = 0
    f.last_gnss_tick = f.tick


@kernel
def fuse_barometer(f: np.record, altitude_m: float) -> None:
    """Fuse a pressure altitude: ENU height plus the barometer's offset."""
    h = f.measurement_row
    h[:] = 0.0
    h[POSITION + 2] = 1.0
    h[BARO_OFFSET] = 1.0
    innovation = altitude_m - f.position_enu_m[2] - f.baro_offset_m
    f.ratio_baro = scalar_update(f, innovation, f.baro_variance_m2)


@kernel
def heading_innovation(f: np.record, field_flu_ut: np.ndarray) -> float:
    """Heading by the magnetometer minus the estimated one, rad; its Jacobian goes to the row.

    The measured field, turned into the world by the estimate, is compared in azimuth with the
    field that the geomagnetic model gives. A tilt error leaks the vertical field into it.
    """
    R, h = f.work_R, f.measurement_row
    matrix_from_quat(f.quat_wxyz, R)
    mx = R[0, 0] * field_flu_ut[0] + R[0, 1] * field_flu_ut[1] + R[0, 2] * field_flu_ut[2]
    my = R[1, 0] * field_flu_ut[0] + R[1, 1] * field_flu_ut[1] + R[1, 2] * field_flu_ut[2]
    mz = R[2, 0] * field_flu_ut[0] + R[2, 1] * field_flu_ut[1] + R[2, 2] * field_flu_ut[2]
    horizontal = mx * mx + my * my
    h[:] = 0.0
    h[ATTITUDE] = -mz * mx / horizontal
    h[ATTITUDE + 1] = -mz * my / horizontal
    h[ATTITUDE + 2] = 1.0
    expected = math.atan2(f.field_enu_ut[1], f.field_enu_ut[0])
    return wrap_angle(expected - math.atan2(my, mx))


@kernel
def fuse_magnetometer(f: np.record, field_flu_ut: np.ndarray) -> None:
    """Fuse the heading of a measured field; the tilt stays with gravity and GNSS."""
    innovation = heading_innovation(f, field_flu_ut)
    f.ratio_heading = scalar_update(f, innovation, f.heading_variance_rad2)
