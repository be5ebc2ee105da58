"""Shortest path through the cells of a distance field, with a price on closeness to obstacles.

A* on the 26 neighbours of a cell. A diagonal step needs every cell of the block it crosses to be
free, so that it cuts no corner. A step costs its length times the mean price of its two cells; the
price is 1 where the distance is comfortable and rises with the square of what is lacking to `1 +
NARROWNESS_PRICE` where the distance is just enough. The heuristic is the distance on an empty grid,
which is consistent, so the path is optimal. In a large place a path that is longer by a small share
will do: then the search heads for the goal and leaves most of the many equal paths aside.

In a growing map, climbing through cells that were not seen may have a price of its own, because a
camera that looks ahead sees the space to climb into only from far away.
"""

from __future__ import annotations

import functools
import heapq
import math
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Int, UInt8

from autonomy.jit import kernel
from autonomy.pages import untouched_zeros
from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.grid import Cell, Grid, empty_grid_distance, trace_path
from autonomy.planning.widest_path import narrowest_place

NARROWNESS_PRICE = 4.0
_MET, _DONE = 1, 2  # states of a cell: reached, and expanded for good
_LENGTHS = (0.0, 1.0, math.sqrt(2.0), math.sqrt(3.0))
"""Length of a step by the number of axes along which it leads."""


class SeenRoom(NamedTuple):
    """Cells whose room was seen to be free, in a growing map."""

    distance: Grid
    """Distance of each cell to what was not seen free."""
    needed: float
    """Distance from which on it is enough."""
    top: int
    """Highest layer that holds a cell with enough, -1 if none does."""


_ALL_SEEN = SeenRoom(np.zeros((1, 1, 1), dtype=np.float32), 0.0, -1)


def shortest_path(
    field: DistanceField,
    start_cell: Cell,
    goal_cell: Cell,
    *,
    required_m: float,
    comfortable_m: float,
    seen: SeenRoom | None = None,
    climb_price: float = 0.0,
    excess: float = 0.0,
) -> Int[np.ndarray, "n 3"]:
    """Find the cells from start to goal, neighbours in a row, both ends included.

    Args:
        field: Distances to the obstacles.
        start_cell: Index of the first cell.
        goal_cell: Index of the last cell.
        required_m: Least distance of cells that may be entered.
        comfortable_m: Distance from which on closeness has no price.
        seen: Cells in which climbing costs no more than its length; None for all.
        climb_price: Price in cells of a rise by one cell elsewhere.
        excess: Share by which the path may cost more than the cheapest one.

    Raises:
        UnreachableError: If free cells do not join start and goal.
    """
    _require_path(field, start_cell, goal_cell, required_m)
    comfortable_m = max(comfortable_m, required_m + 1e-3)
    # Search from the end that is in the narrow. From the open, a search would look for a cheaper
    # path all about before it pays the price of the narrow. Only climbs through unseen space have a
    # direction.
    start_m, goal_m = (float(field.distance_m[tuple(cell)]) for cell in (start_cell, goal_cell))
    is_forward = seen is None and start_m < min(goal_m, comfortable_m)
    marks = untouched_zeros((field.distance_m.size,), np.uint8)
    path = search_grid(
        field.distance_m,
        start_cell if is_forward else goal_cell,
        goal_cell if is_forward else start_cell,
        required_m,
        comfortable_m,
        _ALL_SEEN if seen is None else seen,
        0.0 if seen is None else climb_price,
        1.0 + excess,
        marks,
    )
    return np.ascontiguousarray(path[::-1]) if is_forward else path


def _require_path(
    field: DistanceField, start_cell: Cell, goal_cell: Cell, required_m: float
) -> None:
    """Refuse a search that would look at every cell in vain, naming the narrowest place."""
    least_m = min(required_m, field.resolution_m / 4)
    find = functools.partial(narrowest_place, field, goal_cell, start_cell, least_m=least_m)
    narrowest = find(enough_m=required_m)
    if narrowest.room_m >= required_m:
        ends_m = [float(field.distance_m[tuple(cell)]) for cell in (start_cell, goal_cell)]
        if min(ends_m) >= required_m or np.array_equal(start_cell, goal_cell):
            return
        narrowest = find(enough_m=math.inf)
    named, where = "", None
    if narrowest.room_m > 0.0:
        x, y, z = where = tuple(field.centres(narrowest.cell).tolist())
        named = (
            f", and the widest way has {narrowest.room_m:.2f} m at ({x:.1f}, {y:.1f}, {z:.1f}) m"
        )
    raise UnreachableError(
        f"goal is cut off from the start for a vehicle that needs {required_m:.2f} m to every "
        f"obstacle{named}; valid: a goal that free space joins to the start",
        where,
    )


@kernel
def _price(distance: Grid, i: int, j: int, k: int, required: float, comfortable: float) -> float:
    if distance[i, j, k] >= comfortable:
        return 1.0
    lack = max(0.0, min(1.0, (comfortable - distance[i, j, k]) / (comfortable - required)))
    return 1.0 + NARROWNESS_PRICE * lack * lack


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
def search_grid(
    distance: Grid,
    start: Cell,
    goal: Cell,
    required: float,
    comfortable: float,
    seen: SeenRoom,
    climb_price: float,
    weight: float,
    marks: UInt8[np.ndarray, " cells"],
) -> Int[np.ndarray, "n 3"]:
    """Search from `start` to `goal`; return the cells from goal back to start, none without a path.

    The path will be flown from `goal` to `start`, so the search descends where the flight climbs.
    The search leaves marks in `marks`, zeros before, of the cells that it met. The estimate of the
    rest counts `weight` times.
    """
    nx, ny, nz = distance.shape
    # Unseen cells above seen ones have to be climbed unseen.
    top = max(seen.top, goal[2]) if climb_price > 0.0 else nz
    # Only cells that were met are ever read: untouched pages cost nothing.
    cost = np.empty(distance.size, dtype=np.float32)
    came_from = np.empty(distance.size, dtype=np.int32)
    first = (start[0] * ny + start[1]) * nz + start[2]
    last = (goal[0] * ny + goal[1]) * nz + goal[2]
    cost[first], came_from[first], marks[first] = 0.0, -1, _MET
    # Equal estimates are ordered by the rest of the path, so that the search heads for the goal.
    queue: list[Any] = [(0.0, 0.0, first)]
    while len(queue) > 0:
        _, _, here = heapq.heappop(queue)
        if marks[here] == _DONE:
            continue
        marks[here] = _DONE
        if here == last:
            break
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        price_here = _price(distance, i, j, k, required, comfortable)
        is_seen_here = climb_price > 0.0 and seen.distance[i, j, k] >= seen.needed
        is_open = _is_open(distance, i, j, k, required)
        for di in range(-1, 2):
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    u, v, w = i + di, j + dj, k + dk
                    if not (0 <= u < nx and 0 <= v < ny and 0 <= w < nz):
                        continue
                    there = here + (di * ny + dj) * nz + dk
                    if marks[there] == _DONE or distance[u, v, w] < required:
                        continue
                    length = _LENGTHS[abs(di) + abs(dj) + abs(dk)]
                    price = _price(distance, u, v, w, required, comfortable)
                    total = cost[here] + length * 0.5 * (price_here + price)
                    if dk < 0 and climb_price > 0.0:
                        is_seen = is_seen_here and seen.distance[u, v, w] >= seen.needed
                        total += 0.0 if is_seen else climb_price
                    if marks[there] == _MET and total >= cost[there]:
                        continue
                    # The dearest test last.
                    if not (is_open or _is_block_free(distance, i, j, k, u, v, w, required)):
                        continue
                    cost[there], came_from[there], marks[there] = total, here, _MET
                    ahead = empty_grid_distance(goal[0] - u, goal[1] - v, goal[2] - w)
                    ahead += climb_price * max(w - top, 0)
                    heapq.heappush(queue, (total + weight * ahead, ahead, there))
    return trace_path(came_from, last if marks[last] == _DONE else -1, ny, nz)


@kernel
def _is_open(distance: Grid, i: int, j: int, k: int, required: float) -> bool:
    """Return whether a cell and all that touch it have the required distance."""
    nx, ny, nz = distance.shape
    if not (0 < i < nx - 1 and 0 < j < ny - 1 and 0 < k < nz - 1):
        return False
    least = distance[i, j, k]
    for a in range(i - 1, i + 2):
        for b in range(j - 1, j + 2):
            for c in range(k - 1, k + 2):
                least = min(least, distance[a, b, c])
    return least >= required
