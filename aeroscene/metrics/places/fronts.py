"""Fronts of buildings, which should face their streets."""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int

from aeroscene.metrics.places.top_view import TopView, union
from aeroscene.scene.catalogue import BUILDINGS, PARKING, WAYS

REACH_M = 25.0
"""Greatest distance of a building's side from its street."""
AS_NEAR_M = 2.0
"""Amount by which a front may be further from its street than another side from its own."""
_MIDDLE = 0.7
"""Share of a side's width, in its middle, that looks at the street."""
_SIDES = ((0, 1), (0, -1), (1, 1), (1, -1))
"""Axis and sign of a building's sides, the front first."""


def averted_fronts(view: TopView) -> Bool[np.ndarray, " buildings"]:
    """True for each building whose front, its +x side, faces away from the nearest street.

    Streets are road, pavement, plaza and parking. The street of a side lies straight before it, up
    to `REACH_M` away. Buildings without any street are not judged, nor are buildings within others.
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
    # A rectangle before the side; its intersection with the streets is the visible part of them.
    before = shapely.intersection(shapely.polygons(np.concatenate([near, far], axis=1)), streets)
    away_m = shapely.distance(shapely.linestrings(near), before)
    return np.where(np.isnan(away_m), np.inf, away_m)
