"""Widest path between two cells: how much room its narrowest place has, and where that is.

A failed search should say which door is too narrow, and should fail before it has looked at every
cell. Two trees grow in turn from both ends, each where it has most room. When one cannot grow
without entering a cell of less room, no path is wider than that cell. From then on all cells with
more room are alike to both trees, and of those they enter the one nearest to the other end first.
So the cost follows the path, or the smaller of the two spaces that a narrow place parts, but not
the scene.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from jaxtyping import Int, UInt8

from autonomy.jit import kernel
from autonomy.pages import untouched_zeros
from autonomy.planning.field import DistanceField
from autonomy.planning.grid import STEPS, Cell, Grid, empty_grid_distance, trace_path

Cells = Int[np.ndarray, "n 3"]
_MET, _ENTERED = 1, 4
"""Marks of the tree from the first end; those of the second tree are twice as large."""


class Narrowest(NamedTuple):
    """Narrowest place of the widest path; `room_m` is 0 if there is no path."""

    room_m: float
    cell: Cell


def narrowest_place(
    field: DistanceField, start_cell: Cell, goal_cell: Cell, *, least_m: float, enough_m: float
) -> Narrowest:
    """Find the narrowest place of the widest path between two cells, the ends left out.

    Args:
        field: Distances to the obstacles.
        start_cell: Index of the first cell.
        goal_cell: Index of the last cell; of places that are equally narrow the first one counts.
        least_m: Least distance of cells that a path may lead through.
        enough_m: Distance above which no path is any wider.
    """
    marks = untouched_zeros((field.distance_m.size,), np.uint8)
    room_m, cell = widest_path(field.distance_m, start_cell, goal_cell, least_m, enough_m, marks)
    return Narrowest(room_m, cell)


@kernel
def widest_path(
    distance: Grid,
    start: Cell,
    goal: Cell,
    least: float,
    enough: float,
    marks: UInt8[np.ndarray, " cells"],
) -> tuple[float, Cell]:
    """Grow both trees until they meet; see `narrowest_place`. `marks` must be zeros."""
    nx, ny, nz = distance.shape
    came_from = np.empty((2, distance.size), dtype=np.int32)
    ends = (
        (start[0] * ny + start[1]) * nz + start[2],
        (goal[0] * ny + goal[1]) * nz + goal[2],
    )
    trees = ([(-enough, 0.0, ends[0])], [(-enough, 0.0, ends[1])])
    for n in range(2):
        came_from[n, ends[n]] = -1
        marks[ends[n]] |= _MET << n
    width, turn = enough, 1
    while len(trees[0]) > 0 and len(trees[1]) > 0:
        turn = 1 - turn
        less, _, here = heapq.heappop(trees[turn])
        width = min(width, -less)
        marks[here] |= _ENTERED << turn
        if marks[here] & (_ENTERED << (1 - turn)):
            way = trace_path(came_from[0], here, ny, nz)[::-1]
            return _narrowest(distance, way, trace_path(came_from[1], here, ny, nz)[1:])
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        other = ends[1 - turn]
        for di, dj, dk in STEPS:
            u, v, w = i + di, j + dj, k + dk
            if not (0 <= u < nx and 0 <= v < ny and 0 <= w < nz):
                continue
            there = (u * ny + v) * nz + w
            # The other end may itself lack room; a path still has to reach it.
            room = enough if there == other else float(distance[u, v, w])
            if marks[there] & (_MET << turn) or room < least:
                continue
            marks[there] |= _MET << turn
            came_from[turn, there] = here
            x, y, z = other // (ny * nz), other // nz % ny, other % nz
            ahead = empty_grid_distance(x - u, y - v, z - w)
            heapq.heappush(trees[turn], (-min(room, width), ahead, there))
    return 0.0, start


@kernel
def _narrowest(distance: Grid, first_part: Cells, second_part: Cells) -> tuple[float, Cell]:
    """First of the narrowest cells of a path, without its ends."""
    way = np.concatenate((first_part, second_part))
    room, cell = np.inf, way[0]
    for n in range(1, len(way) - 1):
        own = float(distance[way[n, 0], way[n, 1], way[n, 2]])
        if own < room:
            room, cell = own, way[n]
    return room, cell
