"""Initial alignment of the filter at rest: tilt by gravity, heading by the magnetic field.

A Kalman filter needs a first estimate near the truth, because it linearises about it. At rest the
mean specific force shows which way is up and the mean field where north is, so no motion is needed.
The covariance starts with the correlations that this method implies; without them the filter would
trust its tilt too much.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation.error_state import ACCEL_BIAS, ATTITUDE, BARO_OFFSET, GNSS_WANDER, N_STATES
from autonomy.estimation.fusion import correlate_with_wander, relative_field_excess
from autonomy.estimation.past import restart_past
from autonomy.jit import kernel
from autonomy.rotation import matrix_from_quat, quat_from_rotation_vector, quat_multiply

_MIN_FIXES = 3
_MIN_SAMPLES = 10


@kernel
def collect_imu(f: np.record, accel_flu_mps2: np.ndarray, gyro_flu_radps: np.ndarray) -> None:
    """Add a sample of the IMU to the means; restart if the vehicle is not at rest.

    Every 50 samples the mean square of the angular rate is compared with its limit.
    """
    f.tick += 1
    f.n_imu += 1
    for i in range(3):
        f.accel_sum[i] += accel_flu_mps2[i]
        f.gyro_sum[i] += gyro_flu_radps[i]
        f.gyro_square_sum += gyro_flu_radps[i] * gyro_flu_radps[i]
    limit = f.max_align_rate_radps * f.max_align_rate_radps
    if f.n_imu % 50 == 0 and f.gyro_square_sum > 3.0 * limit * f.n_imu:
        restart_alignment(f)


@kernel
def restart_alignment(f: np.record) -> None:
    """Discard the collected samples, so that alignment begins anew."""
    f.n_imu = f.n_gnss = f.n_mag = f.n_baro = 0
    f.gyro_square_sum = 0.0
    f.baro_sum = 0.0
    for i in range(3):
        f.accel_sum[i] = f.gyro_sum[i] = f.mag_sum[i] = f.gnss_sum[i] = 0.0


@kernel
def collect_vector(total: np.ndarray, sample: np.ndarray) -> None:
    """Add a sample (3,) to a sum in place."""
    for i in range(3):
        total[i] += sample[i]


@kernel
def collect_fix(f: np.record, position_enu_m: np.ndarray, sigma_m: np.ndarray) -> None:
    """Add a fix of the receiver to the mean.

    Args:
        f: The filter.
        position_enu_m: Position (3,).
        sigma_m: Standard deviation of its noise (3,), without the slow wander.
    """
    collect_vector(f.gnss_sum, position_enu_m)
    for i in range(3):
        f.gnss_sigma_m[i] = sigma_m[i]
    f.n_gnss += 1


@kernel
def align_when_ready(f: np.record) -> None:
    """Start the filter when every sensor has delivered enough samples.

    Without satellites it starts at the given position, if there is one.
    """
    has_fixes = f.n_gnss >= _MIN_FIXES
    if f.n_imu < f.n_align or not (has_fixes or f.has_start == 1):
        return
    if f.n_mag < _MIN_SAMPLES or f.n_baro < _MIN_SAMPLES:
        return
    _align_attitude(f)
    for i in range(3):
        f.gyro_bias_flu_radps[i] = f.gyro_sum[i] / f.n_imu
        f.position_enu_m[i] = f.gnss_sum[i] / f.n_gnss if has_fixes else f.start_enu_m[i]
        f.velocity_enu_mps[i] = 0.0
    restart_past(f)
    # After `position_enu_m`: the barometer's offset is relative to that height.
    f.baro_offset_m = f.baro_sum / f.n_baro - f.position_enu_m[2]
    _start_covariance(f)
    _start_position_covariance(f, has_fixes)
    f.last_gnss_tick = f.last_wander_tick = f.last_position_tick = f.tick
    f.is_aligned = 1


@kernel
def _start_position_covariance(f: np.record, has_fixes: bool) -> None:
    """Set the covariance of position, from the mean of fixes or as given, and of the barometer."""
    P = f.covariance
    for i in range(3):
        if has_fixes:
            correlate_with_wander(f, i, f.gnss_sigma_m[i] * f.gnss_sigma_m[i] / f.n_gnss)
        else:
            P[i, i] = f.start_sigma_m * f.start_sigma_m
            P[GNSS_WANDER + i, GNSS_WANDER + i] = f.wander_variance_m2[i]
    # The offset is the pressure altitude minus the height: it errs by as much as the height,
    # reversed.
    for j in range(N_STATES):
        P[BARO_OFFSET, j] = P[j, BARO_OFFSET] = -P[2, j]
    P[BARO_OFFSET, BARO_OFFSET] = P[2, 2] + f.baro_variance_m2 / f.n_baro


@kernel
def _start_covariance(f: np.record) -> None:
    """Set the covariance, diagonal except for the attitude.

    Levelling mistakes an accelerometer bias b for a tilt b/g. The tilt error theta hides the bias:
    g [e3]x theta = -R b, as long as the vehicle rests. The heading comes from the levelled field,
    so that a tilt error leaks the field's vertical part into it.
    """
    P, R, g = f.covariance, f.work_R, f.gravity_mps2
    P[:] = 0.0
    for i in range(N_STATES):
        P[i, i] = f.aligned_sigma[i] * f.aligned_sigma[i]
    matrix_from_quat(f.quat_wxyz, R)
    for j in range(3):
        k = ACCEL_BIAS + j
        tilt_x, tilt_y = -R[1, j] / g, R[0, j] / g  # per unit of this bias
        P[ATTITUDE, k] = P[k, ATTITUDE] = tilt_x * P[k, k]
        P[ATTITUDE + 1, k] = P[k, ATTITUDE + 1] = tilt_y * P[k, k]
        P[ATTITUDE, ATTITUDE] += tilt_x * tilt_x * P[k, k]
        P[ATTITUDE + 1, ATTITUDE + 1] += tilt_y * tilt_y * P[k, k]
        cross = tilt_x * tilt_y * P[k, k]
        P[ATTITUDE, ATTITUDE + 1] += cross
        P[ATTITUDE + 1, ATTITUDE] += cross
    field = f.field_enu_ut
    leak = field[2] / (field[0] * field[0] + field[1] * field[1])
    yaw = ATTITUDE + 2
    for j in range(N_STATES):
        if j != yaw:
            P[yaw, j] = leak * (field[0] * P[ATTITUDE, j] + field[1] * P[ATTITUDE + 1, j])
            P[j, yaw] = P[yaw, j]
    P[yaw, yaw] += leak * (field[0] * P[yaw, ATTITUDE] + field[1] * P[yaw, ATTITUDE + 1])
    for i in range(3):
        f.mag_sum[i] /= f.n_mag
    f.field_excess = relative_field_excess(f, f.mag_sum)
    P[yaw, yaw] += f.field_excess * f.field_excess


@kernel
def _align_attitude(f: np.record) -> None:
    ax, ay, az = f.accel_sum[0], f.accel_sum[1], f.accel_sum[2]
    mx, my, mz = f.mag_sum[0], f.mag_sum[1], f.mag_sum[2]
    roll = math.atan2(ay, az)
    pitch = math.atan2(-ax, math.sqrt(ay * ay + az * az))
    # Roll and pitch from gravity first: the field must be levelled before its azimuth is read.
    sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
    level_x = cp * mx + sp * sr * my + sp * cr * mz
    level_y = cr * my - sr * mz
    azimuth = math.atan2(f.field_enu_ut[1], f.field_enu_ut[0])
    yaw = azimuth - math.atan2(level_y, level_x)
    q = f.quat_wxyz
    quat_from_rotation_vector(0.0, 0.0, yaw, q)
    quat_from_rotation_vector(0.0, pitch, 0.0, f.work_quat)
    quat_multiply(q, f.work_quat, q)
    quat_from_rotation_vector(roll, 0.0, 0.0, f.work_quat)
    quat_multiply(q, f.work_quat, q)
