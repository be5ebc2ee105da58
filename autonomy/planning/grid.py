"""Cells of a distance field as searches see them: types, distances and paths back through them."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

Cell = Int[np.ndarray, " 3"]
Grid = Float[np.ndarray, "nx ny nz"]

STEPS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
"""Steps through the faces of a cell."""
_SQRT_2, _SQRT_3 = math.sqrt(2.0), math.sqrt(3.0)


@kernel
def empty_grid_distance(i: int, j: int, k: int) -> float:
    """Length in cells of the shortest path by so many cells along each axis, diagonals included.

    On an empty grid of 26 neighbours this is exact, so it never overestimates.
    """
    a, b, c = abs(i), abs(j), abs(k)
    low, high = min(a, b, c), max(a, b, c)
    middle = a + b + c - low - high
    return (high - middle) + _SQRT_2 * (middle - low) + _SQRT_3 * low


@kernel
def trace_path(
    came_from: Int[np.ndarray, " cells"], end: int, ny: int, nz: int
) -> Int[np.ndarray, "n 3"]:
    """Cells from `end` back to the beginning of a search, by their predecessors; none for -1."""
    count, here = 0, end
    while here >= 0:
        count, here = count + 1, came_from[here]
    path = np.empty((count, 3), dtype=np.int64)
    here = end
    for n in range(count):
        path[n, 0], path[n, 1], path[n, 2] = here // (ny * nz), here // nz % ny, here % nz
        here = came_from[here]
    return path
