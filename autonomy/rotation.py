"""Unit quaternions and rotation matrices as kernels over caller-owned arrays.

Quaternions are `wxyz`; R rotates body vectors into the world, so that R = R(q) and
q_world_from_body = q_world_from_a * q_a_from_body.

Source: Sola 2017, "Quaternion kinematics for the error-state Kalman filter", chapters 1 and 2.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel


@kernel
def quat_multiply(a: np.ndarray, b: np.ndarray, product: np.ndarray) -> None:
    """Write the product a * b of two quaternions to `product`, which may be one of the factors."""
    aw, ax, ay, az = a[0], a[1], a[2], a[3]
    bw, bx, by, bz = b[0], b[1], b[2], b[3]
    product[0] = aw * bw - ax * bx - ay * by - az * bz
    product[1] = aw * bx + ax * bw + ay * bz - az * by
    product[2] = aw * by - ax * bz + ay * bw + az * bx
    product[3] = aw * bz + ax * by - ay * bx + az * bw


@kernel
def quat_normalise(q: np.ndarray) -> None:
    """Scale a quaternion to unit length in place; a zero quaternion has none and gives NaN."""
    scale = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        q[i] *= scale


@kernel
def quat_from_rotation_vector(x: float, y: float, z: float, q: np.ndarray) -> None:
    """Write the exponential map to `q`: the rotation by |(x, y, z)| rad about (x, y, z)."""
    angle = math.sqrt(x * x + y * y + z * z)
    # sin(a/2)/a to second order near zero
    scale = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    q[0] = math.cos(0.5 * angle)
    q[1] = scale * x
    q[2] = scale * y
    q[3] = scale * z


@kernel
def rotation_vector_from_quat(q: np.ndarray, vector: np.ndarray) -> None:
    """Write the logarithm map to `vector`: the shortest rotation vector, |vector| <= pi.

    q and -q are the same rotation; the sign of q[0] selects the shorter turn.
    """
    sign = 1.0 if q[0] >= 0.0 else -1.0
    norm = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    half = math.atan2(norm, sign * q[0])
    # Near the identity half / norm tends to 1, so the factor is 2 within rounding.
    scale = sign * (2.0 if norm < 1e-12 else 2.0 * half / norm)
    for i in range(3):
        vector[i] = scale * q[i + 1]


@kernel
def matrix_from_quat(q: np.ndarray, R: np.ndarray) -> None:
    """Write the rotation matrix (3, 3) of a unit quaternion to `R`, body to world."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    R[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    R[0, 1] = 2.0 * (x * y - w * z)
    R[0, 2] = 2.0 * (x * z + w * y)
    R[1, 0] = 2.0 * (x * y + w * z)
    R[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    R[1, 2] = 2.0 * (y * z - w * x)
    R[2, 0] = 2.0 * (x * z - w * y)
    R[2, 1] = 2.0 * (y * z + w * x)
    R[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@kernel
def yaw_from_quat(q: np.ndarray) -> float:
    """Return the heading of body x in the horizontal plane, counter-clockwise from world x, rad.

    It is in [-pi, pi] and meaningless if body x is vertical.
    """
    return math.atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]))


@kernel
def wrap_angle(angle: float) -> float:
    """Wrap an angle to [-pi, pi]."""
    return angle - 2.0 * math.pi * np.floor((angle + math.pi) / (2.0 * math.pi))
