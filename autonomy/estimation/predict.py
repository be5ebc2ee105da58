"""Propagation of the nominal state and its error covariance by one IMU sample.

The covariance is propagated by hand-written sums instead of F P F^T, because F is nearly the
identity and the full product of 25 x 25 matrices would dominate the tick.

Source: Sola 2017, section 7.2 (global angular error), with the rotation taken at mid-interval.
"""

from __future__ import annotations

import numpy as np

from autonomy.estimation.error_state import BARO_OFFSET, N_STATES
from autonomy.estimation.past import remember
from autonomy.jit import kernel
from autonomy.rotation import (
    matrix_from_quat,
    quat_from_rotation_vector,
    quat_multiply,
    quat_normalise,
)


@kernel
def predict(f: np.record, accel_flu_mps2: np.ndarray, gyro_flu_radps: np.ndarray) -> None:
    """Advance the filter by one IMU sample: means over `f.dt_s` of specific force and rate.

    Args:
        f: The filter, aligned.
        accel_flu_mps2: Specific force (3,), bias included.
        gyro_flu_radps: Angular rate (3,), bias included.
    """
    dt = f.dt_s
    rate = f.angular_rate_flu_radps
    R = f.work_R
    for i in range(3):
        rate[i] = gyro_flu_radps[i] - f.gyro_bias_flu_radps[i]
    # The force acts at the attitude of mid-interval: turn by half, use it, turn by the other half.
    _rotate_half(f, rate, dt)
    matrix_from_quat(f.quat_wxyz, R)
    a0 = accel_flu_mps2[0] - f.accel_bias_flu_mps2[0]
    a1 = accel_flu_mps2[1] - f.accel_bias_flu_mps2[1]
    a2 = accel_flu_mps2[2] - f.accel_bias_flu_mps2[2]
    force = f.gain  # specific force in the world; the gain is free until the next update
    for i in range(3):
        force[i] = R[i, 0] * a0 + R[i, 1] * a1 + R[i, 2] * a2
        gravity = f.gravity_mps2 if i == 2 else 0.0
        f.acceleration_enu_mps2[i] = force[i] - gravity
        step = f.acceleration_enu_mps2[i] * dt
        f.position_enu_m[i] += (f.velocity_enu_mps[i] + 0.5 * step) * dt
        f.velocity_enu_mps[i] += step
    _rotate_half(f, rate, dt)
    quat_normalise(f.quat_wxyz)
    propagate_covariance(f.covariance, R, force, dt)
    add_process_noise(f)
    f.tick += 1
    remember(f)


@kernel
def _rotate_half(f: np.record, rate: np.ndarray, dt: float) -> None:
    half = 0.5 * dt
    quat_from_rotation_vector(rate[0] * half, rate[1] * half, rate[2] * half, f.work_quat)
    quat_multiply(f.quat_wxyz, f.work_quat, f.quat_wxyz)


@kernel
def propagate_covariance(P: np.ndarray, R: np.ndarray, force: np.ndarray, dt: float) -> None:
    """P <- F P F^T in place, for the F of the module's source, which is nearly the identity.

    F adds dt velocity to position; -dt ([force]x attitude + R accel bias) to velocity; and -dt R
    gyro bias to attitude. Each row needs only rows below it, so the order p, v, theta works in
    place; columns likewise. All other states are unchanged.
    """
    fx, fy, fz = dt * force[0], dt * force[1], dt * force[2]
    r00, r01, r02 = dt * R[0, 0], dt * R[0, 1], dt * R[0, 2]
    r10, r11, r12 = dt * R[1, 0], dt * R[1, 1], dt * R[1, 2]
    r20, r21, r22 = dt * R[2, 0], dt * R[2, 1], dt * R[2, 2]
    for j in range(N_STATES):
        P[0, j] += dt * P[3, j]
        P[1, j] += dt * P[4, j]
        P[2, j] += dt * P[5, j]
        x, y, z = P[6, j], P[7, j], P[8, j]
        a, b, c = P[12, j], P[13, j], P[14, j]
        P[3, j] += fz * y - fy * z - (r00 * a + r01 * b + r02 * c)
        P[4, j] += fx * z - fz * x - (r10 * a + r11 * b + r12 * c)
        P[5, j] += fy * x - fx * y - (r20 * a + r21 * b + r22 * c)
        a, b, c = P[9, j], P[10, j], P[11, j]
        P[6, j] -= r00 * a + r01 * b + r02 * c
        P[7, j] -= r10 * a + r11 * b + r12 * c
        P[8, j] -= r20 * a + r21 * b + r22 * c
    for j in range(N_STATES):
        P[j, 0] += dt * P[j, 3]
        P[j, 1] += dt * P[j, 4]
        P[j, 2] += dt * P[j, 5]
        x, y, z = P[j, 6], P[j, 7], P[j, 8]
        a, b, c = P[j, 12], P[j, 13], P[j, 14]
        P[j, 3] += fz * y - fy * z - (r00 * a + r01 * b + r02 * c)
        P[j, 4] += fx * z - fz * x - (r10 * a + r11 * b + r12 * c)
        P[j, 5] += fy * x - fx * y - (r20 * a + r21 * b + r22 * c)
        a, b, c = P[j, 9], P[j, 10], P[j, 11]
        P[j, 6] -= r00 * a + r01 * b + r02 * c
        P[j, 7] -= r10 * a + r11 * b + r12 * c
        P[j, 8] -= r20 * a + r21 * b + r22 * c


@kernel
def add_process_noise(f: np.record) -> None:
    """P <- P + Q dt, with rounding errors of the two triangles averaged."""
    P = f.covariance
    for i in range(9):  # all that the propagation changes
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])
        for j in range(9, N_STATES):
            P[j, i] = P[i, j]
    for i in range(3):
        P[3 + i, 3 + i] += f.accel_variance_rate * f.dt_s
        P[6 + i, 6 + i] += f.gyro_variance_rate * f.dt_s
        P[9 + i, 9 + i] += f.gyro_bias_variance_rate * f.dt_s
        P[12 + i, 12 + i] += f.accel_bias_variance_rate * f.dt_s
    P[BARO_OFFSET, BARO_OFFSET] += f.baro_offset_variance_rate * f.dt_s
