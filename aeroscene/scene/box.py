"""Oriented boxes: centre, attitude, extents, and the corners that follow from them.

| symbol | name | unit |
|---|---|---|
| p | centre, ENU | m |
| q | unit quaternion wxyz, box to world | - |
| s | full local extents | m |

Batched functions accept any number of leading axes; a single box has none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from aeroscene.scene.errors import require, require_finite

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UNIT_TOLERANCE = 1e-4
"""Allowed deviation of a quaternion's norm from one: layouts rounded to 4 decimals still pass."""
UPRIGHT_TOLERANCE = 1e-6
"""Size of x and y of a quaternion below which a box turns about the vertical only."""
MIN_SIZE_M = 0.001
MAX_EXTENT_M = 1000.0
"""Longest side of a flight volume and of a box, and farthest that an object lies outside it, m."""
CORNER_SIGNS = np.array([[1 if i >> axis & 1 else -1 for axis in range(3)] for i in range(8)])
"""Sign of each corner along x, y, z: bit 0, 1, 2 of the corner's number."""


@dataclass(frozen=True, slots=True)
class OrientedBox:
    """A box given by centre, attitude and full extents: the paper's (p, q, s).

    Raises:
        SceneError: If a number is not finite, `q` is no unit quaternion within `UNIT_TOLERANCE`, or
            an extent is outside `MIN_SIZE_M` to `MAX_EXTENT_M`.
    """

    p: Vector3
    """Centre, ENU, m."""
    q: Quaternion
    """Unit quaternion wxyz, box to world."""
    s: Vector3
    """Full local extents, m, each positive."""

    def __post_init__(self) -> None:
        require_finite(self.p, 3, "bbox.p")
        require_finite(self.q, 4, "bbox.q")
        require_finite(self.s, 3, "bbox.s")
        norm = math.hypot(*self.q)
        require(
            ok=abs(norm - 1.0) <= UNIT_TOLERANCE,
            field_name="bbox.q",
            value=self.q,
            valid=f"a quaternion wxyz of norm 1 (this one has {norm:.6g})",
        )
        require(
            ok=min(self.s) >= MIN_SIZE_M and max(self.s) <= MAX_EXTENT_M,
            field_name="bbox.s",
            value=self.s,
            valid=f"three extents from {MIN_SIZE_M} to {MAX_EXTENT_M:g} m",
        )

    @property
    def yaw_rad(self) -> float:
        """Heading of the box's x axis in rad, counter-clockwise from east, -pi to pi."""
        w, x, y, z = self.q
        return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

    @property
    def is_upright(self) -> bool:
        """True if the box turns about the vertical only."""
        return math.hypot(self.q[1], self.q[2]) < UPRIGHT_TOLERANCE

    def corners(self) -> Float[np.ndarray, "8 3"]:
        """The eight corners, ENU, m; bit 0, 1, 2 of the row is the sign along x, y, z."""
        return box_corners(self.p, self.q, self.s)


def rotation_matrix(quat_wxyz: ArrayLike) -> Float[np.ndarray, "*batch 3 3"]:
    """Rotation matrices, box to world, of quaternions.

    Args:
        quat_wxyz: Quaternions wxyz, shape (*batch, 4), of any norm above zero: they are normalised
            here, because those of files are rounded to 4 decimals.
    """
    q = np.asarray(quat_wxyz, dtype=float)
    unit = q / np.sqrt((q * q).sum(axis=-1, keepdims=True))
    # Single ones are many: plain numbers take a fifth of the time of arrays.
    w, x, y, z = unit.tolist() if unit.ndim == 1 else np.moveaxis(unit, -1, 0)
    rotation = np.empty((*unit.shape[:-1], 3, 3))
    rotation[..., 0, 0], rotation[..., 0, 1] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z)
    rotation[..., 0, 2], rotation[..., 1, 0] = 2 * (x * z + w * y), 2 * (x * y + w * z)
    rotation[..., 1, 1], rotation[..., 1, 2] = 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    rotation[..., 2, 0], rotation[..., 2, 1] = 2 * (x * z - w * y), 2 * (y * z + w * x)
    rotation[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return rotation


def quat_from_yaw(yaw_rad: float) -> tuple[float, float, float, float]:
    """Quaternion wxyz, w >= 0, of a turn about the vertical.

    A quaternion and its negative mean the same rotation. The choice w >= 0 and 9 decimals give
    equal files for equal headings.
    """
    half = 0.5 * math.remainder(yaw_rad, 2.0 * math.pi)
    return (round(math.cos(half), 9), 0.0, 0.0, round(math.sin(half), 9))


def quat_product(first: tuple[float, ...], second: tuple[float, ...]) -> tuple[float, ...]:
    """Quaternion of turning by `second`, then by `first`; both wxyz."""
    a, b, c, d = first
    w, x, y, z = second
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def box_corners(p: ArrayLike, q: ArrayLike, s: ArrayLike) -> Float[np.ndarray, "*batch 8 3"]:
    """Corners in the order of `CORNER_SIGNS`, ENU, m."""
    half = 0.5 * np.asarray(s, dtype=float)[..., None, :] * CORNER_SIGNS
    rotated = half @ np.swapaxes(rotation_matrix(q), -1, -2)
    return np.asarray(p, dtype=float)[..., None, :] + rotated
