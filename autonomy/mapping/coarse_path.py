"""Rough path through a large place: the shortest one through large cells.

A district has hundreds of millions of fine cells, too many to compute all of them before a
flight. A search through cells of 1 m finds out where a path leads, so that fine cells are computed
only about it. Such cells close doors, so that this path is a guess; no vehicle flies it.
"""

from __future__ import annotations

import itertools

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.search import shortest_path

_COMFORTABLE_M = 1.5
"""Distance beyond the vehicle's sphere above which closeness has no price, as for fine cells."""
SEARCH_EXCESS = 0.1
"""Share by which a path through a large place may cost more than the cheapest one."""
_NEARBY_CELLS = 24
"""Number of cells to each side of an end within which a free one is sought."""


def coarse_path(
    field: DistanceField, ends_enu_m: Float[np.ndarray, "2 3"], radius_m: float
) -> Float[np.ndarray, "n 3"]:
    """Find points of a path from one place to another, a cell apart.

    Large cells close doors. If they do not join the ends, the path leads from each end straight to
    the nearest free air below the sky. If that fails too, it is the straight line between the ends.

    Args:
        field: Distances of large cells, all of them computed.
        ends_enu_m: Start and goal, ENU, m.
        radius_m: Distance that the path keeps from obstacles, as far as the cells show.

    Returns:
        Points from start to goal, ENU, m; both ends are among them.
    """
    is_free = field.distance_m >= radius_m
    nearby = [nearest_cell(is_free, cell) for cell in field.cells(ends_enu_m)]
    # A cell is under the sky if it and all cells above it are free: a path up there meets no roof.
    under_sky = np.logical_and.accumulate(is_free[:, :, ::-1], axis=2)[:, :, ::-1]
    in_the_open = [nearest_cell(under_sky, cell) for cell in field.cells(ends_enu_m)]
    for start, goal in (nearby, in_the_open):
        if start is None or goal is None:
            continue
        try:
            path = shortest_path(
                field,
                start,
                goal,
                required_m=radius_m,
                comfortable_m=radius_m + _COMFORTABLE_M,
                excess=SEARCH_EXCESS,
            )
        except UnreachableError:
            continue
        return _joined([ends_enu_m[0], *field.centres(path), ends_enu_m[1]], field.resolution_m)
    return _joined([*ends_enu_m], field.resolution_m)


def nearest_cell(
    is_wanted: Bool[np.ndarray, "nx ny nz"], cell: Int[np.ndarray, " 3"]
) -> Int[np.ndarray, " 3"] | None:
    """Return the wanted cell that is nearest to a given one.

    Args:
        is_wanted: True for the cells to choose from.
        cell: Index of the cell to be near to; it may lie outside the array.

    Returns:
        Index of the cell; None if no cell within 24 cells along each axis is wanted.
    """
    low = np.maximum(cell - _NEARBY_CELLS, 0)
    high = np.minimum(cell + _NEARBY_CELLS + 1, is_wanted.shape)
    block = tuple(slice(a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True))
    found = np.argwhere(is_wanted[block]) + low
    if not len(found):
        return None
    return found[np.argmin(np.linalg.norm(found - cell, axis=1))]


def _joined(points: list[np.ndarray], step_m: float) -> Float[np.ndarray, "n 3"]:
    """Add points between given ones wherever two are farther apart than a step.

    Cells are computed around these points, so that a gap in them would be a gap in the field.
    """
    parts = [np.array(points[:1])]
    for a, b in itertools.pairwise(points):
        n = max(1, int(np.ceil(np.linalg.norm(b - a) / step_m)))
        parts.append(a + (b - a) * np.arange(1, n + 1)[:, None] / n)
    return np.concatenate(parts)
