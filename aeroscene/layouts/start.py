"""Start of a flight in a layout: the middle of the widest free disc of its ground."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from aeroscene.scene import SceneObject, Vector3

LEAST_RADIUS_M = 0.5
"""A Hummingbird stands in this disc, without a hand's breadth to spare."""
FREE_HEIGHT_M = 2.5
"""Nothing may hang lower than this over the disc."""
MAX_PLACES = 3
_FLAT_M = 0.06
"""Height above the ground up to which an object is part of it."""
_TOLERANCE_M = 0.05
_GROUNDS = frozenset({"lawn", "room"})


def start_places(
    objects: Sequence[SceneObject], regions: Sequence[shapely.Geometry], ground_m: float
) -> Iterator[tuple[Vector3, float]]:
    """Places to start from with the heading there, the widest disc first.

    Args:
        objects: Everything in the scene.
        regions: Ground, as outlines.
        ground_m: Height of its upper face.
    """
    obstacles = shapely.union_all(_outlines(objects, ground_m))
    free = [shapely.difference(region, obstacles) for region in regions]
    middle = shapely.union_all(list(regions)).centroid
    for _ in range(MAX_PLACES):
        circle = _widest(free)
        if circle is None or circle.length < LEAST_RADIUS_M:
            return
        (x, y), _ = shapely.get_coordinates(circle).tolist()
        yaw_rad = math.atan2(middle.y - y, middle.x - x)
        yield (round(x, 3), round(y, 3), ground_m), round(yaw_rad, 4)
        disc = shapely.Point(x, y).buffer(circle.length)
        free = [shapely.difference(region, disc) for region in free]


def _outlines(objects: Sequence[SceneObject], ground_m: float) -> list[shapely.Geometry]:
    """Outlines of the boxes that are in the way of a drone that stands on the ground."""
    outlines: list[shapely.Geometry] = []
    for obj in objects:
        corners = obj.bbox.corners()
        low, high = float(corners[:, 2].min()), float(corners[:, 2].max())
        is_low = high > ground_m + _FLAT_M and low < ground_m + FREE_HEIGHT_M
        if is_low and obj.category not in _GROUNDS:
            outlines.append(shapely.convex_hull(shapely.MultiPoint(corners[:, :2])))
    return outlines


def _widest(regions: Sequence[shapely.Geometry]) -> shapely.LineString | None:
    """Radius of the largest inscribed circle of any part, as a line from its middle."""
    parts = [part for region in regions for part in shapely.get_parts(region)]
    parts = [part for part in parts if part.area > LEAST_RADIUS_M**2]
    if not parts:
        return None
    circles = [shapely.maximum_inscribed_circle(part, _TOLERANCE_M) for part in parts]
    return circles[int(np.argmax([circle.length for circle in circles]))]
