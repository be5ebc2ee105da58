"""What may not stay where the projection left it: traffic lights without a road, boats ashore."""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Int

from aeroscene.feasibility.boxes import Boxes
from aeroscene.feasibility.layout import Layout

AFLOAT = frozenset({"boat"})
TO_ROAD_M = 3.0
"""Farthest that a traffic light stands from the outline of a road."""
LEAST_ON_WATER = 0.95
"""Least share of a boat's outline on water."""


def drop_strays(layout: Layout) -> None:
    """Take out the lights that stand at no road, and the boats that are not on water."""
    lights = _outlines(layout.boxes, _rows(layout, frozenset({"traffic_light"})))
    boats = _outlines(layout.boxes, _rows(layout, AFLOAT))
    roads = _union(layout, "road")
    water = _union(layout, "water")
    for row, light in lights.items():
        # NaN where there is no road at all.
        if not shapely.distance(light, roads) <= TO_ROAD_M:
            layout.drop(row)
    for row, boat in boats.items():
        if shapely.area(shapely.intersection(boat, water)) < LEAST_ON_WATER * boat.area:
            layout.drop(row)


def _rows(layout: Layout, categories: frozenset[str]) -> Int[np.ndarray, " k"]:
    is_one = [obj.category in categories for obj in layout.objects]
    return np.flatnonzero(layout.is_left & np.array(is_one, dtype=bool))


def _union(layout: Layout, category: str) -> shapely.Geometry:
    outlines = _outlines(layout.boxes, _rows(layout, frozenset({category})))
    return shapely.union_all(list(outlines.values()))


def _outlines(boxes: Boxes, rows: Int[np.ndarray, " k"]) -> dict[int, shapely.Polygon]:
    """Boxes from above, by their row."""
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    return {
        row: shapely.Polygon(
            boxes.centre_m[row, :2] + (signs * boxes.half_m[row, :2]) @ boxes.frame(row)
        )
        for row in rows.tolist()
    }
