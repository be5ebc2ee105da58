"""The ground: paved pieces should be connected, and the site should be covered."""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene.catalogue import GROUND, PARKING, ROOMS, SHELLS, WAYS

GAP_M = 0.3
"""Widest gap between pieces of one patch."""
TO_WAY_M = 1.5
"""Greatest distance of a parking lot from a road, sidewalk or plaza that leads to it."""


def patches(view: TopView) -> Float[np.ndarray, " sites"]:
    """Number of separate patches of road, sidewalk, plaza and parking lot outdoors.

    Pieces belong to one patch if a chain of pieces joins them with gaps of at most `GAP_M`.

    Returns:
        One number for a scene with any such piece; empty for others.
    """
    rows = view.rows(WAYS | PARKING)
    outlines = view.outline[rows[view.is_outdoors[rows]]]
    if not len(outlines):
        return np.zeros(0)
    first, second = near_pairs(outlines, outlines, GAP_M)
    # Pieces are nodes and gaps are edges: patches are the components of the graph.
    joined = coo_array((np.ones(len(first)), (first, second)), shape=(len(outlines),) * 2)
    return np.array([float(connected_components(joined, directed=False)[0])])


def covered_shares(view: TopView) -> Float[np.ndarray, " sites"]:
    """Share of the convex hull of the site that ground covers.

    The hull is that of all covers and raised land outdoors. They cover it, and so do buildings and
    rooms.

    Returns:
        One number for a scene with any cover outdoors; empty for others.
    """
    ground = view.rows(GROUND)
    ground = ground[view.is_outdoors[ground]]
    if not len(ground):
        return np.zeros(0)
    hull = shapely.convex_hull(shapely.union_all(view.outline[ground]))
    standing = np.concatenate([ground, view.rows(SHELLS | ROOMS)])
    covered = shapely.intersection(shapely.union_all(view.outline[standing]), hull)
    return np.array([covered.area / hull.area])


def remote_parking(view: TopView) -> Bool[np.ndarray, " lots"]:
    """True for each parking lot over `TO_WAY_M` from every road, sidewalk and plaza."""
    lots, ways = view.rows(PARKING), view.rows(WAYS)
    is_remote = np.ones(len(lots), dtype=bool)
    is_remote[near_pairs(view.outline[lots], view.outline[ways], TO_WAY_M)[0]] = False
    return is_remote
