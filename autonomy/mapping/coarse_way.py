"""Rough way through a large place, by the shortest path through large cells."""

from __future__ import annotations

import itertools

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.search import shortest_path

_COMFORTABLE_M = 1.5
"""Distance beyond the vehicle's sphere from which on closeness has no price, as for fine cells."""
SEARCH_EXCESS = 0.1
"""Share by which a path through a large place may cost more than the cheapest one."""
_NEARBY_CELLS = 24
"""Cells about an end within which a free one is sought."""


def coarse_way(
    field: DistanceField, ends_enu_m: Float[np.ndarray, "2 3"], radius_m: float
) -> Float[np.ndarray, "n 3"]:
    """Find points of a way from one place to another, a cell apart.

    Large cells close doors. So where they do not join the ends, the way leads from each end
    straight to the nearest free air below the sky, and where that fails too, straight to the other
    end.

    Args:
        field: Distances of large cells, all of them computed.
        ends_enu_m: Start and goal.
        radius_m: Distance that the way keeps from obstacles, as far as the cells tell.
    """
    is_free = field.distance_m >= radius_m
    nearby = [_nearest(is_free, cell) for cell in field.cells(ends_enu_m)]
    under_sky = np.logical_and.accumulate(is_free[:, :, ::-1], axis=2)[:, :, ::-1]
    in_the_open = [_nearest(under_sky, cell) for cell in field.cells(ends_enu_m)]
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


def _nearest(
    is_wanted: Bool[np.ndarray, "nx ny nz"], cell: Int[np.ndarray, " 3"]
) -> Int[np.ndarray, " 3"] | None:
    """The wanted cell that is nearest to one; None if there is none nearby."""
    low = np.maximum(cell - _NEARBY_CELLS, 0)
    high = np.minimum(cell + _NEARBY_CELLS + 1, is_wanted.shape)
    block = tuple(slice(a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True))
    found = np.argwhere(is_wanted[block]) + low
    if not len(found):
        return None
    return found[np.argmin(np.linalg.norm(found - cell, axis=1))]


def _joined(points: list[np.ndarray], step_m: float) -> Float[np.ndarray, "n 3"]:
    """Points with others between them wherever they are farther than a step apart."""
    parts = [np.array(points[:1])]
    for a, b in itertools.pairwise(points):
        n = max(1, int(np.ceil(np.linalg.norm(b - a) / step_m)))
        parts.append(a + (b - a) * np.arange(1, n + 1)[:, None] / n)
    return np.concatenate(parts)
