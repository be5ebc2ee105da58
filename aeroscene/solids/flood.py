"""Flood of free space, compiled: columns as runs of free cells, from run to neighbouring run.

Most of a scene is sky, so there are a hundred times fewer runs than cells.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.jit import kernel


@kernel
def flooded(
    distance_m: Float[np.ndarray, "nx ny nz"],
    radius_m: np.float32,
    seed_x: int,
    seed_y: int,
    seed_z: int,
) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells with at least a radius of space that hang together, face by face, with a seed cell."""
    nx, ny, nz = distance_m.shape
    # Runs of one column after another; `first[c]` is the first run of column c.
    first = np.empty(nx * ny + 1, dtype=np.int64)
    low = np.empty(2 * nx * ny, dtype=np.int32)
    high = np.empty(2 * nx * ny, dtype=np.int32)
    n_runs, begun = 0, -1
    for i in range(nx):
        for j in range(ny):
            first[i * ny + j] = n_runs
            k = 0
            while k < nz:
                while k < nz and distance_m[i, j, k] < radius_m:
                    k += 1
                begin = k
                while k < nz and distance_m[i, j, k] >= radius_m:
                    k += 1
                if k > begin:
                    if n_runs == len(low):
                        low = np.concatenate((low, np.empty_like(low)))
                        high = np.concatenate((high, np.empty_like(high)))
                    low[n_runs], high[n_runs] = begin, k
                    n_runs += 1
    first[nx * ny] = n_runs
    column = np.empty(n_runs, dtype=np.int64)
    for c in range(nx * ny):
        for run in range(first[c], first[c + 1]):
            column[run] = c
    for run in range(first[seed_x * ny + seed_y], first[seed_x * ny + seed_y + 1]):
        if low[run] <= seed_z < high[run]:
            begun = run
    is_found = np.zeros(n_runs, dtype=np.bool_)
    waiting = np.empty(n_runs, dtype=np.int64)
    n_waiting = 0
    if begun >= 0:
        is_found[begun] = True
        waiting[0] = begun
        n_waiting = 1
    found = np.zeros((nx, ny, nz), dtype=np.bool_)
    while n_waiting:
        n_waiting -= 1
        run = waiting[n_waiting]
        i = column[run] // ny
        j = column[run] - i * ny
        for k in range(low[run], high[run]):
            found[i, j, k] = True
        for side in range(4):
            x = i + (side == 0) - (side == 1)
            y = j + (side == 2) - (side == 3)
            if not (0 <= x < nx and 0 <= y < ny):
                continue
            beside = x * ny + y
            for other in range(first[beside], first[beside + 1]):
                is_met = low[other] < high[run] and low[run] < high[other]
                if is_met and not is_found[other]:
                    is_found[other] = True
                    waiting[n_waiting] = other
                    n_waiting += 1
    return found
