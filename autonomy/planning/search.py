"""Shortest path through the cells of a distance field, with a price on closeness to obstacles.

A* on the 26 neighbours of a cell. A diagonal step needs every cell of the block it crosses to be
free, so that it cuts no corner. A step costs its length times the mean price of its two cells;
the price is 1 where the distance is comfortable and rises with the square of what is lacking to
`1 + NARROWNESS_PRICE` where the distance is just enough. The heuristic is the distance on an empty
grid, which is consistent, so the path is optimal.

Where a map grows, climbing through cells that were not seen may have a price of its own: a camera
that looks ahead sees the space to climb into only from far away.
"""

from __future__ import annotations

import heapq
import math
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField

NARROWNESS_PRICE = 4.0
Cell = Int[np.ndarray, " 3"]
Grid = Float[np.ndarray, "nx ny nz"]
Marks = Bool[np.ndarray, "nx ny nz"]
_MOST_SEARCHED = 400_000
"""Number of cells searched for the narrowest place, before the message is written without it."""
_ALL_SEEN = np.ones((1, 1, 1), dtype=np.bool_)
_SQRT_2, _SQRT_3 = math.sqrt(2.0), math.sqrt(3.0)


def shortest_path(
    field: DistanceField,
    start_cell: Cell,
    goal_cell: Cell,
    *,
    required_m: float,
    comfortable_m: float,
    is_seen: Marks | None = None,
    climb_price: float = 0.0,
) -> Int[np.ndarray, "n 3"]:
    """Find the cells from start to goal, neighbours in a row, both ends included.

    Args:
        field: Distances to the obstacles.
        start_cell: Index of the first cell.
        goal_cell: Index of the last cell.
        required_m: Least distance of cells that may be entered.
        comfortable_m: Distance from which on closeness has no price.
        is_seen: Whether climbing in a cell costs no more than its length; None for all.
        climb_price: Price in cells of a rise by one cell elsewhere.

    Raises:
        UnreachableError: If free cells do not join start and goal.
    """
    # Search backwards: a goal in a closed room fails fast, and a start is rarely closed in.
    path = search_grid(
        field.distance_m,
        goal_cell,
        start_cell,
        required_m,
        max(comfortable_m, required_m + 1e-3),
        _ALL_SEEN if is_seen is None else is_seen,
        0.0 if is_seen is None else climb_price,
    )
    if len(path) == 0:
        raise _cut_off(field, goal_cell, start_cell, required_m)
    return path


def _cut_off(
    field: DistanceField, start_cell: Cell, goal_cell: Cell, required_m: float
) -> UnreachableError:
    """Error that names the narrowest place of the widest way, if there is one."""
    room_m, cell = widest_way(
        field.distance_m, start_cell, goal_cell, field.resolution_m / 4, _MOST_SEARCHED
    )
    narrowest, where = "", None
    if room_m > 0.0:
        x, y, z = where = tuple(field.centres(cell).tolist())
        narrowest = f", and the widest way has {room_m:.2f} m at ({x:.1f}, {y:.1f}, {z:.1f}) m"
    return UnreachableError(
        f"goal is cut off from the start for a vehicle that needs {required_m:.2f} m to every "
        f"obstacle{narrowest}; valid: a goal that free space joins to the start",
        where,
    )


@kernel
def _price(distance: Grid, i: int, j: int, k: int, required: float, comfortable: float) -> float:
    lack = max(0.0, min(1.0, (comfortable - distance[i, j, k]) / (comfortable - required)))
    return 1.0 + NARROWNESS_PRICE * lack * lack


@kernel
def _empty_grid_distance(i: int, j: int, k: int) -> float:
    a, b, c = abs(i), abs(j), abs(k)
    low, high = min(a, b, c), max(a, b, c)
    middle = a + b + c - low - high
    return (high - middle) + _SQRT_2 * (middle - low) + _SQRT_3 * low


@kernel
def _is_block_free(
    distance: Grid, i0: int, j0: int, k0: int, i1: int, j1: int, k1: int, required: float
) -> bool:
    for i in range(min(i0, i1), max(i0, i1) + 1):
        for j in range(min(j0, j1), max(j0, j1) + 1):
            for k in range(min(k0, k1), max(k0, k1) + 1):
                if distance[i, j, k] < required:
                    return False
    return True


@kernel
def _highest(marks: Marks) -> int:
    for k in range(marks.shape[2] - 1, -1, -1):
        if marks[:, :, k].any():
            return k
    return -1


@kernel
def search_grid(
    distance: Grid,
    start: Cell,
    goal: Cell,
    required: float,
    comfortable: float,
    is_seen: Marks,
    climb_price: float,
) -> Int[np.ndarray, "n 3"]:
    """Search from `start` to `goal`; return the cells from goal back to start.

    The way will be flown from `goal` to `start`, so the search descends where the flight climbs.
    """
    nx, ny, nz = distance.shape
    # Unseen cells above seen ones have to be climbed unseen.
    top = max(_highest(is_seen), goal[2]) if climb_price > 0.0 else nz
    cost = np.full(distance.size, np.inf, dtype=np.float32)
    came_from = np.full(distance.size, -1, dtype=np.int32)
    is_done = np.zeros(distance.size, dtype=np.bool_)
    first = (start[0] * ny + start[1]) * nz + start[2]
    last = (goal[0] * ny + goal[1]) * nz + goal[2]
    cost[first] = 0.0
    queue: list[Any] = [(0.0, 0.0, first)]
    while len(queue) > 0:
        _, _, here = heapq.heappop(queue)
        if is_done[here]:
            continue
        is_done[here] = True
        if here == last:
            break
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        price_here = _price(distance, i, j, k, required, comfortable)
        for di in range(-1, 2):
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    u, v, w = i + di, j + dj, k + dk
                    if not (0 <= u < nx and 0 <= v < ny and 0 <= w < nz):
                        continue
                    there = (u * ny + v) * nz + w
                    if is_done[there] or distance[u, v, w] < required:
                        continue
                    length = math.sqrt(di * di + dj * dj + dk * dk)
                    price = _price(distance, u, v, w, required, comfortable)
                    total = cost[here] + length * 0.5 * (price_here + price)
                    if dk < 0 and climb_price > 0.0:
                        total += 0.0 if is_seen[u, v, w] and is_seen[i, j, k] else climb_price
                    if total >= cost[there]:
                        continue
                    if not _is_block_free(distance, i, j, k, u, v, w, required):
                        continue
                    cost[there] = total
                    came_from[there] = here
                    ahead = _empty_grid_distance(goal[0] - u, goal[1] - v, goal[2] - w)
                    ahead += climb_price * max(w - top, 0)
                    heapq.heappush(queue, (total + ahead, ahead, there))
    return way_back(came_from, last if is_done[last] else -1, ny, nz)


@kernel
def widest_way(
    distance: Grid, start: Cell, goal: Cell, least: float, most_searched: int
) -> tuple[float, Cell]:
    """Find the narrowest place of the way whose narrowest place is widest.

    A way may begin and end closer to an obstacle than that. Among equal cells the search continues
    from the one nearer to the goal.

    Returns:
        Least distance on that way and the cell, or 0 and any cell if there is no way with at least
        `least`, or none was found among the first `most_searched` cells.
    """
    nx, ny, nz = distance.shape
    is_met = np.zeros(distance.size, dtype=np.bool_)
    first = (start[0] * ny + start[1]) * nz + start[2]
    last = (goal[0] * ny + goal[1]) * nz + goal[2]
    queue: list[Any] = [(-np.inf, 0.0, first)]
    is_met[first] = True
    narrowest, at = np.inf, first
    for _ in range(most_searched):
        if len(queue) == 0:
            break
        room, _, here = heapq.heappop(queue)
        if -room < narrowest:
            narrowest, at = -room, here
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        if here == last:
            return narrowest, np.array([at // (ny * nz), at // nz % ny, at % nz])
        for di, dj, dk in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
            u, v, w = i + di, j + dj, k + dk
            if not (0 <= u < nx and 0 <= v < ny and 0 <= w < nz):
                continue
            there = (u * ny + v) * nz + w
            own = np.inf if there == last else float(distance[u, v, w])
            if is_met[there] or own < least:
                continue
            is_met[there] = True
            ahead = _empty_grid_distance(goal[0] - u, goal[1] - v, goal[2] - w)
            heapq.heappush(queue, (-own, ahead, there))
    return 0.0, start


@kernel
def way_back(
    came_from: Int[np.ndarray, " cells"], end: int, ny: int, nz: int
) -> Int[np.ndarray, "n 3"]:
    """Cells from one back to the beginning of a search, by their predecessors; none for -1."""
    count, here = 0, end
    while here >= 0:
        count, here = count + 1, came_from[here]
    path = np.empty((count, 3), dtype=np.int64)
    here = end
    for n in range(count):
        path[n, 0], path[n, 1], path[n, 2] = here // (ny * nz), here // nz % ny, here % nz
        here = came_from[here]
    return path
