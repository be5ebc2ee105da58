"""Buildings and the streets that they face."""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int

from aeroscene.metrics.places.top_view import TopView, union
from aeroscene.scene.catalogue import BUILDINGS, PARKING, WAYS

REACH_M = 25.0
"""Farthest that a street before a building is its street."""
AS_NEAR_M = 2.0
"""A front may be so much farther from its street than another side from that or the next one."""
_MIDDLE = 0.7
"""Share of a side's width that looks at the street."""
_SIDES = ((0, 1), (0, -1), (1, 1), (1, -1))
"""Axis and sign of a building's sides, the front first."""


def averted_fronts(view: TopView) -> Bool[np.ndarray, " buildings"]:
    """Whether the front of each building, its +x side, looks away from the nearest street.

    Streets are road, pavement, plaza and parking. A side's is what lies straight before it, up to
    `REACH_M` away; buildings without any are not judged, nor is what stands in another.
    """
    buildings = view.rows(BUILDINGS)
    buildings = buildings[view.is_outdoors[buildings]]
    streets = union(view.outline[view.rows(WAYS | PARKING)])
    away_m = np.stack([_away_m(view, buildings, streets, *side) for side in _SIDES], axis=1)
    nearest_m = away_m.min(axis=1, initial=np.inf)
    return (away_m[:, 0] > nearest_m + AS_NEAR_M)[np.isfinite(nearest_m)]


def _away_m(
    view: TopView, rows: Int[np.ndarray, " k"], streets: shapely.Geometry, axis: int, sign: int
) -> Float[np.ndarray, " k"]:
    """Distance from one side of boxes to the street before it; infinite without one."""
    ends = view.face(rows, axis, sign)
    middle = ends.mean(axis=1, keepdims=True)
    near = middle + _MIDDLE * (ends - middle)
    outwards = sign * (view.forward, view.leftward)[axis][rows]
    far = near[:, ::-1] + REACH_M * outwards[:, None]
    before = shapely.intersection(shapely.polygons(np.concatenate([near, far], axis=1)), streets)
    away_m = shapely.distance(shapely.linestrings(near), before)
    return np.where(np.isnan(away_m), np.inf, away_m)
