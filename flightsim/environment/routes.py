"""Routes through free columns: shortest paths between two places, then rounded.

A route is pulled straight like a rope, point by point, wherever enough room remains. A path of
cells alone would turn by 45 degrees at a time, as nobody walks.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from flightsim.environment.floor import CELL_M, Columns, Floor

_SPACING_M = 0.25
_PULLS = 200  # sweeps of the pulling, which spread a straight line along the whole route
_WALL_COST_M = 0.5
"""Clearance at which a cell costs twice its length, so that routes avoid walls."""


def find_route(
    floor: Floor,
    free: Bool[np.ndarray, "nx ny"],
    length_m: tuple[float, float],
    generator: np.random.Generator,
) -> Float[np.ndarray, "n 2"] | None:
    """Return a random route through free columns.

    Args:
        floor: Floor with the clearance that routes prefer.
        free: Columns that the route may use.
        length_m: Least and greatest cost of the route.
        generator: Random stream of the choice.

    Returns:
        Points a quarter of a metre apart, or None if the random start leads nowhere.
    """
    # Imported here for start-up time: only runs with traffic search routes.
    from scipy.sparse.csgraph import dijkstra

    cells = np.argwhere(free)
    if not len(cells):
        return None
    start = int(generator.integers(len(cells)))
    cost, before = dijkstra(
        _graph(floor, free, cells), indices=start, limit=length_m[1], return_predecessors=True
    )
    goals = np.flatnonzero((cost >= length_m[0]) & np.isfinite(cost))
    if not len(goals):
        return None
    node = int(goals[generator.integers(len(goals))])
    chain = []
    # -9999, a negative number, ends the chain of predecessors at the start.
    while node >= 0:
        chain.append(node)
        node = int(before[node])
    origin = np.array(floor.columns.grid.origin_enu_m[:2])
    return _resampled(origin + CELL_M * cells[chain[::-1]])


def pull_straight(
    route_enu_m: Float[np.ndarray, "n 2"], floor: Floor, free: Bool[np.ndarray, "nx ny"]
) -> Float[np.ndarray, "n 2"]:
    """Repeatedly move every inner point between its neighbours, if that is free.

    Args:
        route_enu_m: Points of the route.
        floor: Floor that finds the columns of points.
        free: Columns that the route may use.
    """
    points = route_enu_m.copy()
    for pull in range(_PULLS):
        # Alternate odd and even points: neighbours must not move at once.
        inner = np.arange(1 + pull % 2, len(points) - 1, 2)
        left, right = points[inner - 1], points[inner + 1]
        moved = (left + right) / 2
        is_free = free[floor.cells(moved)]
        # Also halfway to either neighbour: a point alone would let the line cut a corner.
        is_free &= free[floor.cells((left + moved) / 2)] & free[floor.cells((moved + right) / 2)]
        points[inner[is_free]] = moved[is_free]
    return _resampled(points)


def _resampled(points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "m 2"]:
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], max(2, round(along[-1] / _SPACING_M) + 1))
    return np.column_stack([np.interp(at, along, points[:, axis]) for axis in (0, 1)])


def _graph(floor: Floor, free: np.ndarray, cells: Int[np.ndarray, "n 2"]) -> object:
    """Graph of free columns and their eight neighbours, with greater lengths near obstacles."""
    from scipy.sparse import coo_array

    # A rim of -1 spares checks at the border.
    number = np.full((free.shape[0] + 2, free.shape[1] + 2), -1)
    number[1:-1, 1:-1][free] = np.arange(len(cells))
    near = 1.0 + _WALL_COST_M / np.maximum(floor.clearance_m[free], 0.1)
    rows, columns, lengths = [], [], []
    # Half of the directions: the transposed graph adds the others.
    for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
        other = number[cells[:, 0] + 1 + di, cells[:, 1] + 1 + dj]
        here = np.flatnonzero(other >= 0)
        there = other[here]
        if di and dj:
            # Do not cut corners.
            beside = number[cells[here, 0] + 1 + di, cells[here, 1] + 1] >= 0
            beside &= number[cells[here, 0] + 1, cells[here, 1] + 1 + dj] >= 0
            here, there = here[beside], there[beside]
        rows.append(here)
        columns.append(there)
        lengths.append(CELL_M * np.hypot(di, dj) * (near[here] + near[there]) / 2)
    pairs = (np.concatenate(rows), np.concatenate(columns))
    graph = coo_array((np.concatenate(lengths), pairs), shape=(len(cells),) * 2).tocsr()
    return graph + graph.T


def distance_to_points(
    columns: Columns, points_enu_m: Float[np.ndarray, "n 2"]
) -> Float[np.ndarray, "nx ny"]:
    """Return the level distance from each column's centre to the nearest of some points, m.

    Args:
        columns: Columns of free space.
        points_enu_m: Points by east and north, (n, 2).
    """
    x, y = columns.centres_enu_m
    squared = np.full(columns.grid.shape[:2], np.inf)
    for px, py in points_enu_m:
        np.minimum(squared, (x - px) ** 2 + (y - py) ** 2, out=squared)
    return np.sqrt(squared)
