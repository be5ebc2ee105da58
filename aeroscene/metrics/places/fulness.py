"""Fullness of places: objects in rooms, sizes of bedrooms, buildings in towns.

Real layouts give values to compare a corpus with: homes of 3D-FRONT hold 41 objects on 100 m2 of
floor and those of ProcTHOR 62 to 80, and buildings cover 38% of the ground in Cape Town and Delft
and 49% in Helsinki.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import shapely
from jaxtyping import Bool, Float

from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene.catalogue import GROUND, ROOMS, SHELLS

DWELLING_USES = frozenset(("living", "bedroom", "kitchen", "dining", "bathroom"))
"""Uses of the rooms of a home."""
WORK_USES = frozenset(
    ("office", "open_office", "meeting", "kitchen", "store", "aisles", "produce", "checkout")
)
"""Uses of the rooms of offices and shops."""
TOWNS = frozenset(("urban_block", "old_town"))
"""Themes of sites that are built up like a town."""
BEDROOM_M2 = (9.0, 25.0)
"""Least and largest floor of an ordinary bedroom."""


def objects_per_100_m2(view: TopView, uses: Collection[str]) -> Float[np.ndarray, " scenes"]:
    """Number of fine objects on 100 m2 of floor, in all rooms of some uses together.

    Args:
        view: A scene.
        uses: Values of the attribute `use`; rooms without it are not judged.

    Returns:
        One number for a scene with such a room; empty for others.
    """
    rooms = np.array([row for row in view.rows(ROOMS) if view.use[row] in uses], dtype=int)
    if not len(rooms):
        return np.zeros(0)
    # Objects on furniture are in the room, too.
    is_inside = np.any(view.arrays.is_ancestor[rooms], axis=0)
    is_fine = np.array([not obj.is_coarse for obj in view.scene.objects])
    # Rooms are boxes, so their floors are rectangles.
    floor_m2 = float(np.prod(view.arrays.size_m[rooms, :2], axis=1).sum())
    return np.array([100.0 * np.count_nonzero(is_inside & is_fine) / floor_m2])


def dwelling_fill(view: TopView) -> Float[np.ndarray, " scenes"]:
    """Fine objects on 100 m2 of the rooms of homes; see `objects_per_100_m2`."""
    return objects_per_100_m2(view, DWELLING_USES)


def work_fill(view: TopView) -> Float[np.ndarray, " scenes"]:
    """Fine objects on 100 m2 of offices and shops; see `objects_per_100_m2`."""
    return objects_per_100_m2(view, WORK_USES)


def ordinary_bedrooms(view: TopView) -> Bool[np.ndarray, " bedrooms"]:
    """True for each bedroom whose floor lies within `BEDROOM_M2`."""
    rows = [row for row in view.rows(ROOMS) if view.use[row] == "bedroom"]
    floor_m2 = np.prod(view.arrays.size_m[rows, :2], axis=1)
    return (floor_m2 >= BEDROOM_M2[0]) & (floor_m2 <= BEDROOM_M2[1])


def built_shares(view: TopView) -> Float[np.ndarray, " towns"]:
    """Share of the convex hull of a town's ground that buildings cover.

    Returns:
        One number for a scene whose theme is one of `TOWNS`; empty for others.
    """
    ground = view.rows(GROUND)
    ground = ground[view.is_outdoors[ground]]
    if view.scene.theme not in TOWNS or not len(ground):
        return np.zeros(0)
    hull = shapely.convex_hull(shapely.union_all(view.outline[ground]))
    built = shapely.union_all(view.outline[view.rows(SHELLS)])
    return np.array([shapely.intersection(built, hull).area / hull.area])
