"""Tables: do chairs face them, is a chair there for every plate?"""

from __future__ import annotations

import math

import numpy as np
import shapely
from jaxtyping import Bool

from aeroscene.metrics.places.top_view import TopView, near_pairs

TABLES = ("table", "desk")
AT_TABLE_M = 0.5
"""Widest gap between a table and a chair at it."""
OFF_RAD = math.radians(45.0)
"""Largest angle between where a chair at a table looks and where the table is."""
TO_CHAIR_M = 0.9
"""Farthest that the middle of a plate is from the middle of a chair."""
_ABOVE_M = 0.3
"""Farthest that a plate lies above the back of a chair before it."""


def averted_chairs(view: TopView) -> Bool[np.ndarray, " chairs"]:
    """Whether each chair at a table is turned off it.

    A chair is at the nearest table or desk that shares height with it, if the gap between their
    outlines is at most `AT_TABLE_M`; other chairs are not judged. It is turned off where its x axis
    and the way from its middle to the nearest point of the table make an angle over `OFF_RAD`.
    """
    chairs, tables = view.rows("chair"), view.rows(*TABLES)
    chair, table = near_pairs(view.outline[chairs], view.outline[tables], AT_TABLE_M)
    level = view.shared_height_m(chairs[chair], tables[table]) > 0
    chair, table = chairs[chair[level]], tables[table[level]]
    apart_m = shapely.distance(view.outline[chair], view.outline[table])
    best = np.lexsort((apart_m, chair))
    best = best[np.unique(chair[best], return_index=True)[1]]
    chair, table = chair[best], table[best]
    middle = shapely.points(view.centre_m[chair])
    nearest_m = shapely.get_coordinates(
        shapely.get_point(shapely.shortest_line(middle, view.outline[table]), 1)
    )
    is_inside = shapely.intersects(middle, view.outline[table])
    target_m = np.where(is_inside[:, None], view.centre_m[table], nearest_m)
    way_m = target_m - view.centre_m[chair]
    ahead_m = (way_m * view.forward[chair]).sum(axis=1)
    return ahead_m < math.cos(OFF_RAD) * np.linalg.norm(way_m, axis=1)


def lone_plates(view: TopView) -> Bool[np.ndarray, " plates"]:
    """Whether each plate on a table or desk has no chair within `TO_CHAIR_M`, middle to middle.

    Chairs of other storeys do not count: a plate lies at most `_ABOVE_M` above a chair's back.
    """
    plates, chairs = view.rows("plate"), view.rows("chair")
    plates = plates[view.is_on(*TABLES)[plates]]
    is_lone = np.ones(len(plates), dtype=bool)
    plate, chair = near_pairs(
        shapely.points(view.centre_m[plates]), shapely.points(view.centre_m[chairs]), TO_CHAIR_M
    )
    is_lone[plate[view.shared_height_m(plates[plate], chairs[chair]) > -_ABOVE_M]] = False
    return is_lone
