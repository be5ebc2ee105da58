"""Distances to the nearest cells with evidence, and boxes that hold all that is not free.

The certificate of a plan measures distances to solids, not to cells. So the cells that are not
free become boxes, far fewer than there are cells.
A single position needs no boxes: the cells about it tell its distance sooner.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.planning.obstacles import Obstacles

_WALL_M = 10.0
"""Thickness of the walls about a block; no plan reaches as far beyond the block."""


def boxes_about(
    is_free: Bool[np.ndarray, "nx ny nz"],
    corner_enu_m: Float[np.ndarray, " 3"],
    resolution_m: float,
) -> Obstacles:
    """Return upright boxes, as few as possible, over all that is not free in and around a block.

    Seen from free cells only the skin of the rest matters: each box holds some of it and whatever
    else is not free behind it. So distances are exact from free cells, and too large within the
    rest. The last six boxes are all that lies outside the block.

    Args:
        is_free: State of each cell of the block.
        corner_enu_m: Lower corner of the block's first cell, ENU, m.
        resolution_m: Edge of a cell, m.
    """
    first, beyond = cover_skin(is_free)
    low = corner_enu_m + first * resolution_m
    high = corner_enu_m + beyond * resolution_m
    walls_low, walls_high = _walls(corner_enu_m, np.array(is_free.shape) * resolution_m)
    low, high = np.concatenate([low, walls_low]), np.concatenate([high, walls_high])
    # The rotation of each box is a quaternion, w first; this one turns nothing.
    upright = np.tile((1.0, 0.0, 0.0, 0.0), (len(low), 1))
    return Obstacles.boxes((low + high) / 2, upright, high - low)


def _walls(corner: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of six slabs about a block, one beyond each of its faces."""
    low = np.tile(corner - _WALL_M, (6, 1))
    high = np.tile(corner + size + _WALL_M, (6, 1))
    for axis in range(3):
        high[2 * axis, axis] = corner[axis]
        low[2 * axis + 1, axis] = corner[axis] + size[axis]
    return low, high


@kernel
def cover_skin(
    is_free: Bool[np.ndarray, "nx ny nz"],
) -> tuple[Int[np.ndarray, "n 3"], Int[np.ndarray, "n 3"]]:
    """Find blocks of cells that are not free and hold each such cell that touches a free one.

    Each grows from the first such cell that is not held yet, downwards and upwards along z, then
    along y and x, as far as nothing in it is free.

    Returns:
        First cells of the blocks, and the cells beyond their last ones.
    """
    nx, ny, nz = is_free.shape
    sums = _free_sums(is_free)
    is_held = np.zeros((nx, ny, nz), dtype=np.bool_)
    first = np.empty((1024, 3), dtype=np.int64)
    beyond = np.empty((1024, 3), dtype=np.int64)
    count = 0
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if is_free[i, j, k] or is_held[i, j, k] or not _touches(sums, i, j, k):
                    continue
                low[0], low[1], low[2] = i, j, k
                high[:] = low + 1
                # The order shapes the boxes: columns first, then slabs of columns, then blocks.
                for axis in (2, 1, 0):
                    _grow(sums, low, high, axis)
                is_held[low[0] : high[0], low[1] : high[1], low[2] : high[2]] = True
                if count == len(first):
                    first = np.concatenate((first, np.empty_like(first)))
                    beyond = np.concatenate((beyond, np.empty_like(beyond)))
                first[count], beyond[count] = low, high
                count += 1
    return first[:count], beyond[:count]


@kernel
def _free_sums(is_free: np.ndarray) -> np.ndarray:
    """Sum the free cells before each index along all axes.

    From these sums the number of free cells of any block follows by eight look-ups.
    """
    nx, ny, nz = is_free.shape
    sums = np.zeros((nx + 1, ny + 1, nz + 1), dtype=np.int32)
    for i in range(nx):
        for j in range(ny):
            column = 0
            for k in range(nz):
                column += is_free[i, j, k]
                before = sums[i, j + 1, k + 1] + sums[i + 1, j, k + 1] - sums[i, j, k + 1]
                sums[i + 1, j + 1, k + 1] = before + column
    return sums


@kernel
def _has_free(sums: np.ndarray, i: int, j: int, k: int, u: int, v: int, w: int) -> bool:
    """Return whether a cell of a block is free, from (i, j, k) to before (u, v, w)."""
    # Inclusion and exclusion in the plane, once for each end along z.
    upper = sums[u, v, w] - sums[i, v, w] - sums[u, j, w] + sums[i, j, w]
    lower = sums[u, v, k] - sums[i, v, k] - sums[u, j, k] + sums[i, j, k]
    return upper != lower


@kernel
def _touches(sums: np.ndarray, i: int, j: int, k: int) -> bool:
    """Return whether one of the 26 neighbours of a cell is free, so that it is part of the skin."""
    nx, ny, nz = sums.shape
    ends = (min(i + 2, nx - 1), min(j + 2, ny - 1), min(k + 2, nz - 1))
    return _has_free(sums, max(i - 1, 0), max(j - 1, 0), max(k - 1, 0), ends[0], ends[1], ends[2])


@kernel
def _grow(sums: np.ndarray, low: np.ndarray, high: np.ndarray, axis: int) -> None:
    """Widen a block along an axis in both directions while nothing in it is free."""
    a, b = low.copy(), high.copy()
    while high[axis] < sums.shape[axis] - 1:
        a[axis], b[axis] = high[axis], high[axis] + 1
        if _has_free(sums, a[0], a[1], a[2], b[0], b[1], b[2]):
            break
        high[axis] += 1
    while low[axis] > 0:
        a[axis], b[axis] = low[axis] - 1, low[axis]
        if _has_free(sums, a[0], a[1], a[2], b[0], b[1], b[2]):
            break
        low[axis] -= 1


@kernel
def distance_to_cells(
    points: Float[np.ndarray, "k 3"],
    evidence: Int[np.ndarray, "nx ny nz"],
    at_least: int,
    corner: Float[np.ndarray, " 3"],
    resolution: float,
    reach: int,
    is_walled: bool,
) -> Float[np.ndarray, " k"]:
    """Distance from points to the nearest cell with enough evidence, in the cells about each.

    Only the cells about a point are looked at. So a few points cost microseconds even where much
    of the map has changed since its distance field was computed.

    Args:
        points: Positions, ENU, m.
        evidence: Evidence of each cell of the map.
        at_least: Evidence from which on a cell counts.
        corner: Lower corner of cell (0, 0, 0), ENU, m.
        resolution: Edge of a cell, m.
        reach: Number of cells up to which a cell counts; so many edges are the greatest distance.
        is_walled: Whether everything outside the map counts as well.

    Returns:
        Distances to the surfaces of the cells, m; 0 within such a cell.
    """
    nx, ny, nz = evidence.shape
    distance = np.full(len(points), reach * resolution)
    for n in range(len(points)):
        x, y, z = (points[n] - corner) / resolution
        a, b, c = math.floor(x), math.floor(y), math.floor(z)
        # Squares of cells, so that the loops take no roots.
        best = (distance[n] / resolution) ** 2
        if is_walled:
            inside = max(min(x, nx - x, y, ny - y, z, nz - z), 0.0)
            best = min(best, inside * inside)
        for i in range(max(a - reach, 0), min(a + reach + 1, nx)):
            dx = max(i - x, x - i - 1, 0.0)
            for j in range(max(b - reach, 0), min(b + reach + 1, ny)):
                dy = max(j - y, y - j - 1, 0.0)
                # No cell of this column can be nearer than the nearest so far.
                if dx * dx + dy * dy >= best:
                    continue
                for k in range(max(c - reach, 0), min(c + reach + 1, nz)):
                    if evidence[i, j, k] >= at_least:
                        dz = max(k - z, z - k - 1, 0.0)
                        best = min(best, dx * dx + dy * dy + dz * dz)
        distance[n] = math.sqrt(best) * resolution
    return distance


def slices(block: Int[np.ndarray, "2 3"]) -> tuple[slice, slice, slice]:
    """Return the slices of an array for a block: its first cell, and the one beyond its last."""
    (i, j, k), (u, v, w) = block.tolist()
    return slice(i, u), slice(j, v), slice(k, w)
