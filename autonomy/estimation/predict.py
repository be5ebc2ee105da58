"""Propagation of the nominal state and its error covariance by one IMU sample.

Source: Sola 2017, section 7.2 (global angular error), with the rotation taken at mid-interval.
"""

from __future__ import annotations

import numpy as np

from autonomy.estimation.error_state import N_PAST, N_STATES
from autonomy.jit import kernel
from autonomy.rotation import (
    matrix_from_quat,
    quat_from_rotation_vector,
    quat_multiply,
    quat_normalise,
)


@kernel
def predict(f: np.record, accel_flu_mps2: np.ndarray, gyro_flu_radps: np.ndarray) -> None:
    """Advance the filter by one IMU sample: means over `f.dt_s` of specific force and rate."""
    dt = f.dt_s
    rate = f.angular_rate_flu_radps
    R = f.work_R
    for i in range(3):
        rate[i] = gyro_flu_radps[i] - f.gyro_bias_flu_radps[i]
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
    _remember(f)


@kernel
def _rotate_half(f: np.record, rate: np.ndarray, dt: float) -> None:
    half = 0.5 * dt
    quat_from_rotation_vector(rate[0] * half, rate[1] * half, rate[2] * half, f.work_quat)
    quat_multiply(f.quat_wxyz, f.work_quat, f.quat_wxyz)


@kernel
def propagate_covariance(P: np.ndarray, R: np.ndarray, force: np.ndarray, dt: float) -> None:
    """P <- F P F^T in place, for the F of the module's source, which is nearly the identity.

    F adds dt velocity to position; -dt ([force]x attitude + R accel bias) to velocity; and
    -dt R gyro bias to attitude. Each row needs only rows below it, so the order p, v, theta works
    in place; columns likewise.
    """
    fx, fy, fz = force[0], force[1], force[2]
    for j in range(N_STATES):
        for i in range(3):
            P[i, j] += dt * P[3 + i, j]
        x, y, z = P[6, j], P[7, j], P[8, j]
        P[3, j] += dt * (fz * y - fy * z)
        P[4, j] += dt * (fx * z - fz * x)
        P[5, j] += dt * (fy * x - fx * y)
        for i in range(3):
            P[3 + i, j] -= dt * (R[i, 0] * P[12, j] + R[i, 1] * P[13, j] + R[i, 2] * P[14, j])
            P[6 + i, j] -= dt * (R[i, 0] * P[9, j] + R[i, 1] * P[10, j] + R[i, 2] * P[11, j])
    for j in range(N_STATES):
        row = P[j]
        for i in range(3):
            row[i] += dt * row[3 + i]
        x, y, z = row[6], row[7], row[8]
        row[3] += dt * (fz * y - fy * z)
        row[4] += dt * (fx * z - fz * x)
        row[5] += dt * (fy * x - fx * y)
        for i in range(3):
            row[3 + i] -= dt * (R[i, 0] * row[12] + R[i, 1] * row[13] + R[i, 2] * row[14])
            row[6 + i] -= dt * (R[i, 0] * row[9] + R[i, 1] * row[10] + R[i, 2] * row[11])


@kernel
def add_process_noise(f: np.record) -> None:
    """P <- P + Q dt, and rounding errors of the two triangles evened out."""
    P = f.covariance
    for i in range(N_STATES):
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])
    for i in range(3):
        P[3 + i, 3 + i] += f.accel_variance_rate * f.dt_s
        P[6 + i, 6 + i] += f.gyro_variance_rate * f.dt_s
        P[9 + i, 9 + i] += f.gyro_bias_variance_rate * f.dt_s
        P[12 + i, 12 + i] += f.accel_bias_variance_rate * f.dt_s
    P[15, 15] += f.baro_offset_variance_rate * f.dt_s


@kernel
def _remember(f: np.record) -> None:
    f.tick += 1
    slot = f.tick % N_PAST
    for i in range(3):
        f.past_position_enu_m[slot, i] = f.position_enu_m[i]
        f.past_velocity_enu_mps[slot, i] = f.velocity_enu_mps[i]
