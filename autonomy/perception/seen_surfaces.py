"""Surfaces that depth images showed, as a mean and a spread of points in each cell of a volume.

    symbol   name                                              unit
    m, S     mean and covariance of the points in a cell       m, m^2
    n        direction in which they spread least: the normal

If the points of a cell hardly spread in one direction, the cell holds a piece of a plane. So a few
numbers per cell are enough to lay the next image onto everything that was seen before, and no
points need to be kept.

Source: Biber and Strasser 2003, "The normal distributions transform: a new approach to laser scan
matching", in three dimensions as in Magnusson 2009.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.pages import untouched_zeros
from autonomy.types import Vector3

CELL_M = 0.5
_BEYOND_M = 2.0
"""Distance beyond the volume within which surfaces count."""
_LEAST_COUNT, _FULL_COUNT = 12, 300
"""Numbers of points from which a cell is used, and from which it changes no more: the first points
were seen with the least drift."""
_THIN_M, _FLAT = 0.08, 0.25
"""Greatest deviation of points from a plane; greatest share of it in the next wider direction."""
_LEAST_WIDTH_M = 0.06
"""Least deviation of points along a plane, in the narrower direction. About a line of points, as at
the edge of a roof, a plane may be turned anyhow."""
_LEAST_SIGMA_M = 0.02  # no plane is believed to be thinner


class Surfaces(NamedTuple):
    """Points in the cells of a volume, as arrays for kernels."""

    corner: np.ndarray
    """Lower corner of cell (0, 0, 0), ENU, m, (3,)."""
    cell: float
    """Edge of a cell, m."""
    counts: np.ndarray
    """Number of points in each cell."""
    sums: np.ndarray
    """Sum of their positions from the cell's middle, m, (nx, ny, nz, 3)."""
    squares: np.ndarray
    """Sums of the products xx, xy, xz, yy, yz, zz of these, m^2, (nx, ny, nz, 6)."""
    planes: np.ndarray
    """Unit normal, its product with the mean, and deviation of the points from the plane in m;
    the deviation is 0 where there is no plane, (nx, ny, nz, 5)."""


def no_surfaces(low_enu_m: Vector3, high_enu_m: Vector3) -> Surfaces:
    """Return the surfaces of a volume in which nothing was seen yet.

    Args:
        low_enu_m: Lower corner of the volume.
        high_enu_m: Upper corner; surfaces count up to 2 m beyond both.
    """
    corner = np.array(low_enu_m, dtype=float) - _BEYOND_M
    counts = np.ceil((np.array(high_enu_m) + _BEYOND_M - corner) / CELL_M).astype(np.int64)
    shape = tuple(np.maximum(counts, 1).tolist())
    return Surfaces(
        corner=corner,
        cell=CELL_M,
        counts=untouched_zeros(shape, np.int32),
        sums=untouched_zeros((*shape, 3), np.float32),
        squares=untouched_zeros((*shape, 6), np.float32),
        planes=untouched_zeros((*shape, 5), np.float32),
    )


@kernel
def add_points(points: Float[np.ndarray, "n 3"], surfaces: Surfaces) -> None:
    """Add points (ENU, m) to their cells, and fit the planes of those anew."""
    corner, cell, counts, sums, squares, _ = surfaces
    touched = np.empty((len(points), 3), dtype=np.int64)
    n_touched = 0
    is_touched = set()
    for n in range(len(points)):
        i = math.floor((points[n, 0] - corner[0]) / cell)
        j = math.floor((points[n, 1] - corner[1]) / cell)
        k = math.floor((points[n, 2] - corner[2]) / cell)
        if not (0 <= i < counts.shape[0] and 0 <= j < counts.shape[1] and 0 <= k < counts.shape[2]):
            continue
        if counts[i, j, k] >= _FULL_COUNT:
            continue
        # From the cell's middle: sums in single precision then keep their digits.
        x = points[n, 0] - corner[0] - (i + 0.5) * cell
        y = points[n, 1] - corner[1] - (j + 0.5) * cell
        z = points[n, 2] - corner[2] - (k + 0.5) * cell
        counts[i, j, k] += 1
        sums[i, j, k, 0] += x
        sums[i, j, k, 1] += y
        sums[i, j, k, 2] += z
        squares[i, j, k, 0] += x * x
        squares[i, j, k, 1] += x * y
        squares[i, j, k, 2] += x * z
        squares[i, j, k, 3] += y * y
        squares[i, j, k, 4] += y * z
        squares[i, j, k, 5] += z * z
        here = (i * counts.shape[1] + j) * counts.shape[2] + k
        if here not in is_touched:
            is_touched.add(here)
            touched[n_touched, 0], touched[n_touched, 1], touched[n_touched, 2] = i, j, k
            n_touched += 1
    for n in range(n_touched):
        _fit_plane(touched[n, 0], touched[n, 1], touched[n, 2], surfaces)


@kernel
def _fit_plane(i: int, j: int, k: int, surfaces: Surfaces) -> None:
    """Find the plane of the points in a cell, if they lie on one."""
    corner, cell, counts, sums, squares, planes = surfaces
    count = counts[i, j, k]
    if count < _LEAST_COUNT:
        return
    mean = np.empty(3)
    spread = np.empty((3, 3))
    for a in range(3):
        mean[a] = sums[i, j, k, a] / count
    n = 0
    for a in range(3):
        for b in range(a, 3):
            spread[a, b] = spread[b, a] = squares[i, j, k, n] / count - mean[a] * mean[b]
            n += 1
    variances, axes = np.linalg.eigh(spread)
    sigma = math.sqrt(max(variances[0], 0.0))
    is_line = variances[1] < _LEAST_WIDTH_M**2
    if is_line or sigma > _THIN_M or variances[0] > _FLAT * variances[1]:
        planes[i, j, k, 4] = 0.0
        return
    offset = 0.0
    for a, at in ((0, i), (1, j), (2, k)):
        offset += axes[a, 0] * (corner[a] + (at + 0.5) * cell + mean[a])
        planes[i, j, k, a] = axes[a, 0]
    planes[i, j, k, 3] = offset
    planes[i, j, k, 4] = max(sigma, _LEAST_SIGMA_M)


@kernel
def plane_at(
    x: float, y: float, z: float, surfaces: Surfaces
) -> tuple[float, float, float, float, float]:
    """Signed distance of a point from its cell's plane, the normal, and the plane's deviation.

    The deviation is 0 if there is no plane.
    """
    corner, cell, counts, _, _, planes = surfaces
    i = math.floor((x - corner[0]) / cell)
    j = math.floor((y - corner[1]) / cell)
    k = math.floor((z - corner[2]) / cell)
    if not (0 <= i < counts.shape[0] and 0 <= j < counts.shape[1] and 0 <= k < counts.shape[2]):
        return 0.0, 0.0, 0.0, 0.0, 0.0
    plane = planes[i, j, k]
    distance = plane[0] * x + plane[1] * y + plane[2] * z - plane[3]
    return distance, plane[0], plane[1], plane[2], plane[4]
