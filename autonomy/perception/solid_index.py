"""Index of solids on a grid, for fast signed distances near the surfaces of many.

A scene has hundreds of solids, and a registration asks for thousands of distances. Each cell of the
grid lists the solids that come within `reach_m` of any point of it, so that the distance to the
nearest one, cut off at the reach, is found among a few.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.solids import Plane, Solids, gap_to_sphere, plane_between

_MAX_CELLS = 400_000
_VAST_M = 300.0
"""Length above which a solid, such as the ground, does not count for the grid's extent."""


class Grid(NamedTuple):
    """Solids, with the list of those near each cell of a grid."""

    solids: Solids
    corner: np.ndarray
    """Lowest corner, ENU, m, (3,)."""
    cell: float
    """Width of a cell, m."""
    reach: float
    """Distance at which all distances are cut off, m."""
    counts: np.ndarray
    """Number of cells along each axis, (3,)."""
    ends: np.ndarray
    """Index one past the last entry of each cell."""
    entries: np.ndarray
    """Indices of the solids near the cells, cell by cell."""


def index_solids(obstacles: Obstacles, *, reach_m: float, cell_m: float = 1.0) -> Grid:
    """Index all solids in cells of `cell_m`, or wider ones if there would be too many.

    Args:
        obstacles: Solids.
        reach_m: Distance at which all distances are cut off.
        cell_m: Width of a cell.
    """
    solids = obstacles.solids
    half = np.einsum("nij,nj->ni", np.abs(solids.rotations), solids.halves)
    low, high = solids.centers - half - reach_m, solids.centers + half + reach_m
    bounding = np.flatnonzero((high - low).max(axis=1) < _VAST_M)
    if not bounding.size:
        bounding = np.arange(len(low))
    corner = low[bounding].min(axis=0) if len(low) else np.zeros(3)
    span = (high[bounding].max(axis=0) - corner) if len(low) else np.ones(3)
    while np.prod(np.ceil(span / cell_m)) > _MAX_CELLS:
        cell_m *= 1.25
    counts = np.maximum(np.ceil(span / cell_m), 1).astype(np.int64)
    first = np.clip(np.floor((low - corner) / cell_m), 0, counts).astype(np.int64)
    last = np.clip(np.floor((high - corner) / cell_m) + 1, 0, counts).astype(np.int64)
    ends, entries = fill_cells(corner, cell_m, reach_m, counts, first, last, solids)
    return Grid(solids, corner, cell_m, reach_m, counts, ends, entries)


@kernel
def fill_cells(
    corner: Float[np.ndarray, " 3"],
    cell: float,
    reach: float,
    counts: Int[np.ndarray, " 3"],
    first: Int[np.ndarray, "n 3"],
    last: Int[np.ndarray, "n 3"],
    solids: Solids,
) -> tuple[Int[np.ndarray, " cells"], Int[np.ndarray, " k"]]:
    """List the solids within reach of each cell: index past each cell's last entry, and entries.

    A solid's bounding box, wider by the reach, touches cells from `first` to before `last`.
    """
    n_cells = counts[0] * counts[1] * counts[2]
    found = np.zeros(n_cells + 1, dtype=np.int64)
    # From the cell's middle: half a diagonal more covers every point of the cell.
    near = reach + 0.5 * math.sqrt(3.0) * cell
    entries = np.empty(0, dtype=np.int64)
    # The first pass counts the entries of each cell, the second one writes them.
    for is_second in (False, True):
        if is_second:
            for k in range(n_cells):
                found[k + 1] += found[k]
            entries = np.empty(found[n_cells], dtype=np.int64)
        for i in range(len(solids.centers)):
            for a in range(first[i, 0], last[i, 0]):
                x = corner[0] + (a + 0.5) * cell
                for b in range(first[i, 1], last[i, 1]):
                    y = corner[1] + (b + 0.5) * cell
                    for c in range(first[i, 2], last[i, 2]):
                        z = corner[2] + (c + 0.5) * cell
                        if gap_to_sphere(x, y, z, i, solids) > near:
                            continue
                        if plane_between(x, y, z, i, solids)[0] > near:
                            continue
                        k = (a * counts[1] + b) * counts[2] + c
                        if is_second:
                            entries[found[k]] = i
                            found[k] += 1
                        else:
                            found[k + 1] += 1
    # The second pass has moved each beginning to the end of its cell.
    return found[:n_cells], entries


@kernel
def nearest_plane(x: float, y: float, z: float, grid: Grid) -> Plane:
    """Plane that touches the solid nearest to a point from below the point, see `plane_between`.

    If nothing is nearer than the reach, the distance is the reach and the normal zero. Outside the
    grid every solid is tested.
    """
    solids, corner, cell, reach, counts, ends, entries = grid
    a = math.floor((x - corner[0]) / cell)
    b = math.floor((y - corner[1]) / cell)
    c = math.floor((z - corner[2]) / cell)
    best, n, m, o, touch = reach, 0.0, 0.0, 0.0, 0.0
    if 0 <= a < counts[0] and 0 <= b < counts[1] and 0 <= c < counts[2]:
        k = (a * counts[1] + b) * counts[2] + c
        for j in range(ends[k - 1] if k > 0 else 0, ends[k]):
            plane = plane_between(x, y, z, entries[j], solids)
            if plane[0] < best:
                best, n, m, o, touch = plane
    else:
        for i in range(len(solids.centers)):
            if gap_to_sphere(x, y, z, i, solids) < best:
                plane = plane_between(x, y, z, i, solids)
                if plane[0] < best:
                    best, n, m, o, touch = plane
    return best, n, m, o, touch
