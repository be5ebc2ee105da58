"""Tables: chairs should face them, and every plate should have a chair."""

from __future__ import annotations

import math

import numpy as np
import shapely
from jaxtyping import Bool, Int

from aeroscene.feasibility.seats import AT_TABLE_M, OFF_RAD, TO_CHAIR_M
from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene.catalogue import SEATS, SETTINGS, TABLES, WALLS

_ABOVE_M = 0.3
"""Greatest height of a plate above the back of a chair before it."""


def averted_chairs(view: TopView) -> Bool[np.ndarray, " chairs"]:
    """True for each chair at a table that does not face it.

    A chair is at the nearest table or desk that shares height with it and that no wall separates
    from it, if the gap between their outlines is at most `AT_TABLE_M`. Other chairs are not judged.
    A chair does not face its table if the angle between its x axis and the direction from its
    middle to the nearest point of the table is over `OFF_RAD`.
    """
    chairs, tables = view.rows(SEATS), view.rows(TABLES)
    chair, table = near_pairs(view.outline[chairs], view.outline[tables], AT_TABLE_M)
    chair, table = chairs[chair], tables[table]
    is_near = (view.shared_height_m(chair, table) > 0) & ~_are_parted(view, chair, table)
    chair, table = chair[is_near], table[is_near]
    apart_m = shapely.distance(view.outline[chair], view.outline[table])
    # Sorted by chair, then by distance: the first row of each chair is its nearest table.
    best = np.lexsort((apart_m, chair))
    best = best[np.unique(chair[best], return_index=True)[1]]
    chair, table = chair[best], table[best]
    middle = shapely.points(view.centre_m[chair])
    nearest_m = shapely.get_coordinates(
        shapely.get_point(shapely.shortest_line(middle, view.outline[table]), 1)
    )
    # From a chair that is pushed under the table, the direction to its middle counts.
    is_inside = shapely.intersects(middle, view.outline[table])
    target_m = np.where(is_inside[:, None], view.centre_m[table], nearest_m)
    way_m = target_m - view.centre_m[chair]
    ahead_m = (way_m * view.forward[chair]).sum(axis=1)
    return ahead_m < math.cos(OFF_RAD) * np.linalg.norm(way_m, axis=1)


def lone_plates(view: TopView) -> Bool[np.ndarray, " plates"]:
    """True for each plate on a table or desk without a chair within `TO_CHAIR_M` of its middle.

    Chairs behind walls and on other storeys do not count: a plate lies at most `_ABOVE_M` above a
    chair's back.
    """
    plates, chairs = view.rows(SETTINGS), view.rows(SEATS)
    plates = plates[view.is_on(TABLES)[plates]]
    is_lone = np.ones(len(plates), dtype=bool)
    plate, chair = near_pairs(
        shapely.points(view.centre_m[plates]), shapely.points(view.centre_m[chairs]), TO_CHAIR_M
    )
    first, second = plates[plate], chairs[chair]
    is_near = view.shared_height_m(first, second) > -_ABOVE_M
    is_lone[plate[is_near & ~_are_parted(view, first, second)]] = False
    return is_lone


def _are_parted(
    view: TopView, first: Int[np.ndarray, " k"], second: Int[np.ndarray, " k"]
) -> Bool[np.ndarray, " k"]:
    """True if a wall stands between the two of each pair, on the shortest line seen from above."""
    walls = view.rows(WALLS)
    ways = shapely.shortest_line(view.outline[first], view.outline[second])
    pair, wall = near_pairs(ways, view.outline[walls], 0.0)
    are_parted = np.zeros(len(first), dtype=bool)
    are_parted[pair[view.shared_height_m(second[pair], walls[wall]) > 0]] = True
    return are_parted
