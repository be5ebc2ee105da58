"""Objects that must not stay where the projection left them: lights off roads, boats ashore."""

from __future__ import annotations

import numpy as np
import shapely

from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import AFLOAT, ROADS, SIGNALS, WATER

TO_ROAD_M = 3.0
"""Greatest distance of a traffic light from the outline of a road."""
LEAST_ON_WATER = 0.95
"""Least share of a boat's outline on water."""


def drop_strays(layout: Layout) -> None:
    """Drop traffic lights that stand at no road, and boats that are not on water."""
    lights = _outlines(layout, SIGNALS)
    boats = _outlines(layout, AFLOAT)
    roads, water = (
        shapely.union_all(list(_outlines(layout, names).values())) for names in (ROADS, WATER)
    )
    for row, light in lights.items():
        # The distance is NaN if there is no road at all.
        if not shapely.distance(light, roads) <= TO_ROAD_M:
            layout.drop(row)
    for row, boat in boats.items():
        if shapely.area(shapely.intersection(boat, water)) < LEAST_ON_WATER * boat.area:
            layout.drop(row)


def _outlines(layout: Layout, categories: frozenset[str]) -> dict[int, shapely.Polygon]:
    """Outlines of objects of some categories from above, by their row."""
    boxes, signs = layout.boxes, np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    return {
        row: shapely.Polygon(
            boxes.centre_m[row, :2] + (signs * boxes.half_m[row, :2]) @ boxes.frame(row)
        )
        for row in layout.rows(categories)
    }
