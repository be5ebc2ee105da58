"""Flood of free space, compiled: from each run of free cells in a column to its neighbours.

A flood cell by cell would visit tens of millions of cells. Most of a scene is sky, so a column
consists of one or two runs of free cells, and there are a hundred times fewer runs than cells.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel


@kernel
def flooded(
    distance_m: Float[np.ndarray, "nx ny nz"],
    radius_m: np.float32,
    seed_x: int,
    seed_y: int,
    seed_z: int,
) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells with at least a radius of free space that are connected, face by face, to a seed cell.

    Args:
        distance_m: Distance of each cell to the nearest obstacle.
        radius_m: Least distance of a cell that counts as free, of the array's type, so that
            compiled comparisons do not widen every cell.
        seed_x: Index of the seed cell along x.
        seed_y: Index along y.
        seed_z: Index along z.

    Returns:
        True in connected cells; false everywhere if the seed cell is not free.
    """
    first, low, high = _free_runs(distance_m, radius_m)
    nx, ny, nz = distance_m.shape
    begun = -1
    for run in range(first[seed_x * ny + seed_y], first[seed_x * ny + seed_y + 1]):
        if low[run] <= seed_z < high[run]:
            begun = run
    is_found = _connected(first, low, high, begun, nx, ny)
    found = np.zeros((nx, ny, nz), dtype=np.bool_)
    for column in range(nx * ny):
        i = column // ny
        for run in range(first[column], first[column + 1]):
            if is_found[run]:
                found[i, column - i * ny, low[run] : high[run]] = True
    return found


@kernel
def _free_runs(
    distance_m: Float[np.ndarray, "nx ny nz"], radius_m: np.float32
) -> tuple[Int[np.ndarray, " c"], Int[np.ndarray, " r"], Int[np.ndarray, " r"]]:
    """Free runs by column: number of each column's first run, lower and upper ends of runs."""
    nx, ny, nz = distance_m.shape
    first = np.empty(nx * ny + 1, dtype=np.int64)
    # Two runs a column are enough for most scenes; the arrays double otherwise.
    low = np.empty(2 * nx * ny, dtype=np.int32)
    high = np.empty(2 * nx * ny, dtype=np.int32)
    n_runs = 0
    for i in range(nx):
        for j in range(ny):
            first[i * ny + j] = n_runs
            is_free = False
            # One step beyond the top closes a run that reaches it.
            for k in range(nz + 1):
                was_free, is_free = is_free, k < nz and distance_m[i, j, k] >= radius_m
                if is_free and not was_free:
                    if n_runs == len(low):
                        low = np.concatenate((low, np.empty_like(low)))
                        high = np.concatenate((high, np.empty_like(high)))
                    low[n_runs] = k
                    n_runs += 1
                elif was_free and not is_free:
                    high[n_runs - 1] = k
    first[nx * ny] = n_runs
    return first, low[:n_runs], high[:n_runs]


@kernel
def _connected(
    first: Int[np.ndarray, " c"],
    low: Int[np.ndarray, " r"],
    high: Int[np.ndarray, " r"],
    begun: int,
    nx: int,
    ny: int,
) -> Bool[np.ndarray, " r"]:
    """Mark the runs that are connected to a first one; none if `begun` is -1."""
    n_runs, n_waiting = len(low), 0
    column = np.empty(n_runs, dtype=np.int64)
    for c in range(nx * ny):
        column[first[c] : first[c + 1]] = c
    is_found = np.zeros(n_runs, dtype=np.bool_)
    waiting = np.empty(n_runs, dtype=np.int64)
    if begun >= 0:
        is_found[begun] = True
        waiting[0] = begun
        n_waiting = 1
    while n_waiting:
        n_waiting -= 1
        # The stack never overflows: every run enters it once at most.
        run = waiting[n_waiting]
        i = column[run] // ny
        j = column[run] - i * ny
        for x, y in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if not (0 <= x < nx and 0 <= y < ny):
                continue
            for other in range(first[x * ny + y], first[x * ny + y + 1]):
                # Two neighbouring runs are connected if they share a height; ends are exclusive.
                is_met = low[other] < high[run] and low[run] < high[other]
                if is_met and not is_found[other]:
                    is_found[other] = True
                    waiting[n_waiting] = other
                    n_waiting += 1
    return is_found
