"""Viewpoints: lines of sight from a place through cells that are not occupied.

A vehicle that must look at hidden cells can fly to many places. The search here spreads through the
free cells from the vehicle and rates the view from each by the worth of the cells in it over the
time to get there. It ends as soon as no place farther away could be rated higher.
"""

from __future__ import annotations

import heapq
import math
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.mapping.rays import OCCUPIED_AT
from autonomy.planning.grid import trace_path

_STEP = 0.5
"""Distance between samples of a line of sight, in cells."""


class Sight(NamedTuple):
    """Limits of the lines of sight of a camera that turns about the vertical; lengths in cells."""

    least_rise: float
    """Least rise of a line of sight over its horizontal length."""
    most_rise: float
    """Greatest rise, likewise."""
    least_length: float
    most_length: float


@kernel
def visible(
    eye: Float[np.ndarray, " 3"],
    targets: Int[np.ndarray, "n 3"],
    evidence: Int[np.ndarray, "nx ny nz"],
    sight: Sight,
) -> Bool[np.ndarray, " n"]:
    """Return whether a camera that turns about the vertical at a place sees each cell.

    Args:
        eye: Position of the camera, as an index of cells.
        targets: Cells to see.
        evidence: Evidence of each cell; occupied ones block the view.
        sight: Limits of steepness and length of lines of sight.
    """
    is_seen = np.zeros(len(targets), dtype=np.bool_)
    for n in range(len(targets)):
        is_seen[n] = _sees(eye, targets[n], evidence, sight)
    return is_seen


@kernel
def _sees(eye: np.ndarray, target: np.ndarray, evidence: np.ndarray, sight: Sight) -> bool:
    """Return whether a camera sees a cell; see `visible`."""
    x, y, z = target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]
    across = math.sqrt(x * x + y * y)
    length = math.sqrt(across * across + z * z)
    if not sight.least_length <= length <= sight.most_length:
        return False
    if not sight.least_rise * across <= z <= sight.most_rise * across:
        return False
    n_steps = int(length / _STEP)
    for n in range(1, n_steps):
        s = n / n_steps
        i, j, k = round(eye[0] + s * x), round(eye[1] + s * y), round(eye[2] + s * z)
        # The cell itself is unknown, or may be occupied: it does not hide itself.
        if i == target[0] and j == target[1] and k == target[2]:
            return True
        if evidence[i, j, k] >= OCCUPIED_AT:
            return False
    return True


@kernel
def best_viewpoint(
    distance: Float[np.ndarray, "nx ny nz"],
    start: Int[np.ndarray, " 3"],
    required: float,
    targets: Int[np.ndarray, "n 3"],
    weights: Float[np.ndarray, " n"],
    n_needed: int,
    evidence: Int[np.ndarray, "nx ny nz"],
    sight: Sight,
    pause: float,
) -> Int[np.ndarray, "k 3"]:
    """Find the cell from which most is seen for the time to get there.

    Free cells join it to the start.

    Args:
        distance: Distance of each cell to the nearest that is not free.
        start: Cell of the vehicle.
        required: Least distance of cells to fly through.
        targets: Cells to see.
        weights: Worth of each target.
        n_needed: Number of targets at the beginning of which at least one must be seen.
        evidence: Evidence of each cell, which says whether it blocks sight.
        sight: Limits of steepness and length of lines of sight.
        pause: Number of cells that could be flown during a look.

    Returns:
        The cells from there back to the start, or none.
    """
    nx, ny, nz = distance.shape
    # Dijkstra's search over steps along the axes; the queue may hold a cell several times.
    cost = np.full((nx, ny, nz), np.inf, dtype=np.float32)
    came_from = np.full(distance.size, -1, dtype=np.int32)
    first = (start[0] * ny + start[1]) * nz + start[2]
    cost[start[0], start[1], start[2]] = 0.0
    queue: list[Any] = [(0.0, first)]
    eye = np.empty(3)
    found, best, most = -1, 0.0, weights.sum()
    while len(queue) > 0:
        so_far, here = heapq.heappop(queue)
        # Cells come out of the queue by distance, and no view is worth more than all targets.
        if most / (pause + so_far) <= best:
            break
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        if so_far > cost[i, j, k]:
            continue
        # Every fourth cell is enough: a view changes little from cell to cell, and takes long.
        if here == first or ((i + j) % 2 == 0 and k % 2 == 0):
            eye[0], eye[1], eye[2] = i, j, k
            worth = _worth(eye, targets, weights, n_needed, evidence, sight) / (pause + so_far)
            if worth > best:
                found, best = here, worth
        for di, dj, dk in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
            u, v, w = i + di, j + dj, k + dk
            if not (0 <= u < nx and 0 <= v < ny and 0 <= w < nz):
                continue
            if distance[u, v, w] >= required and so_far + 1.0 < cost[u, v, w]:
                there = (u * ny + v) * nz + w
                cost[u, v, w] = so_far + 1.0
                came_from[there] = here
                heapq.heappush(queue, (so_far + 1.0, there))
    return trace_path(came_from, found, ny, nz)


@kernel
def _worth(
    eye: np.ndarray,
    targets: np.ndarray,
    weights: np.ndarray,
    n_needed: int,
    evidence: np.ndarray,
    sight: Sight,
) -> float:
    """Return the sum of the weights of the visible targets.

    It is 0 if none of the first `n_needed` is visible: a view of what comes later alone would not
    lead any further.
    """
    worth = 0.0
    for n in range(len(targets)):
        if n == n_needed and worth == 0.0:
            return 0.0
        if _sees(eye, targets[n], evidence, sight):
            worth += weights[n]
    return worth
