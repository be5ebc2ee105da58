"""Scalar measurement update of the filter: gate, gain, covariance and injection of the error.

Vectors with independent components are fused component by component, each against the state
corrected by the one before. This is exact and needs no matrix inverse.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation.error_state import (
    ACCEL_BIAS,
    ATTITUDE,
    BARO_OFFSET,
    GNSS_WANDER,
    GYRO_BIAS,
    N_STATES,
    VELOCITY,
    VIO_ORIGIN,
    VIO_YAW,
    WIND,
)
from autonomy.jit import kernel
from autonomy.rotation import quat_from_rotation_vector, quat_multiply, quat_normalise

_LEAST_LEVEL = 0.01
"""Squared horizontal part of body x below which it has no heading."""

GROSS_RATIO = 100.0
"""Squared innovation over its squared gate from which a place is grossly wrong: ten times the gate.
A measurement that is so wrong along one axis is right along another only by chance."""


@kernel
def scalar_update(f: np.record, kind: int, innovation: float, variance: float) -> float:
    """Fuse a scalar whose Jacobian is in `f.measurement_row`.

    Args:
        f: The filter.
        kind: Row of `MEASUREMENTS`, for the statistics.
        innovation: Measurement minus prediction.
        variance: Variance of the measurement's noise.

    Returns:
        Squared innovation over its squared gate. A value above 1, or NaN, means that the
        measurement was rejected.
    """
    P, h, gain = f.covariance, f.measurement_row, f.gain
    gain[:] = 0.0
    for i in range(N_STATES):
        if h[i] != 0.0:
            for j in range(N_STATES):
                gain[j] += h[i] * P[i, j]
    s = variance
    for i in range(N_STATES):
        s += h[i] * gain[i]
    square = innovation * innovation / s
    ratio = square / (f.gate_sigma * f.gate_sigma)
    if not ratio <= 1.0:  # rejects NaN too
        return ratio
    f.innovation_square_sum[kind] += square
    f.n_innovations[kind] += 1
    root = math.sqrt(s)
    for i in range(N_STATES):
        gain[i] /= root
    for i in range(N_STATES):  # the same product for both triangles keeps P symmetric to the bit
        for j in range(N_STATES):
            P[i, j] -= gain[i] * gain[j]
    for i in range(N_STATES):
        gain[i] *= innovation / root
    inject(f, gain)
    return ratio


@kernel
def gate_ratio(f: np.record, innovation: float, variance: float) -> float:
    """Squared innovation over its squared gate, as of `scalar_update`, without fusing anything."""
    P, h = f.covariance, f.measurement_row
    for j in range(N_STATES):
        if h[j] != 0.0:
            for k in range(N_STATES):
                variance += h[j] * P[j, k] * h[k]
    return innovation * innovation / (variance * f.gate_sigma * f.gate_sigma)


@kernel
def inject(f: np.record, error: np.ndarray) -> None:
    """Add an estimated error (N_STATES,) to the nominal state and to the remembered estimates."""
    now_s = f.tick * f.dt_s
    for i in range(3):
        f.position_enu_m[i] += error[i]
        f.velocity_enu_mps[i] += error[VELOCITY + i]
        f.gyro_bias_flu_radps[i] += error[GYRO_BIAS + i]
        f.accel_bias_flu_mps2[i] += error[ACCEL_BIAS + i]
        f.angular_rate_flu_radps[i] -= error[GYRO_BIAS + i]
        f.gnss_wander_enu_m[i] += error[GNSS_WANDER + i]
        f.vio_origin_enu_m[i] += error[VIO_ORIGIN + i]
        f.moved_enu_m[i] += error[i]
        f.moved_velocity_enu_mps[i] += error[VELOCITY + i]
        f.moved_moment_enu_m[i] += now_s * error[VELOCITY + i]
    f.baro_offset_m += error[BARO_OFFSET]
    f.vio_yaw_rad += error[VIO_YAW]
    f.wind_enu_mps[0] += error[WIND]
    f.wind_enu_mps[1] += error[WIND + 1]
    # Before the attitude changes: the heading's derivative belongs to the old attitude.
    f.moved_yaw_rad += _turn_of_heading(f.quat_wxyz, error)
    quat_from_rotation_vector(
        error[ATTITUDE], error[ATTITUDE + 1], error[ATTITUDE + 2], f.work_quat
    )
    # From the left, because the attitude error is a rotation in the world frame.
    quat_multiply(f.work_quat, f.quat_wxyz, f.quat_wxyz)
    quat_normalise(f.quat_wxyz)


@kernel
def write_heading_row(q: np.ndarray, h: np.ndarray) -> bool:
    """Add the derivative of the heading by the attitude error to a row; False without a heading.

    Body x turns by theta x e; its azimuth by theta_z - e_z (e_x theta_x + e_y theta_y) / (e_x^2 +
    e_y^2).
    """
    x, y, z = _nose(q)
    level = x * x + y * y
    if level < _LEAST_LEVEL:
        return False
    h[ATTITUDE] -= z * x / level
    h[ATTITUDE + 1] -= z * y / level
    h[ATTITUDE + 2] += 1.0
    return True


@kernel
def _turn_of_heading(q: np.ndarray, error: np.ndarray) -> float:
    x, y, z = _nose(q)
    level = max(x * x + y * y, _LEAST_LEVEL)
    return error[ATTITUDE + 2] - z * (x * error[ATTITUDE] + y * error[ATTITUDE + 1]) / level


@kernel
def _nose(q: np.ndarray) -> tuple[float, float, float]:
    """Components of body x in the world."""
    x = 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3])
    y = 2.0 * (q[1] * q[2] + q[0] * q[3])
    z = 2.0 * (q[1] * q[3] - q[0] * q[2])
    return x, y, z
