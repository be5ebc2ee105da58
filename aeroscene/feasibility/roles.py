"""Roles of objects in a projection: their hosts, and whether they may be cut or leave a building.

These are facts about categories that the corpus shows: which surfaces abut, and which objects
extend over borders.
"""

from __future__ import annotations

from aeroscene.scene import SceneObject
from aeroscene.scene.catalogue import (
    BUILDINGS,
    CATALOGUE,
    DECKS,
    FENCES,
    FLOORS,
    GROUND,
    ROADS,
    ROOFS,
    ROOMS,
    STRIPS,
    WALLS,
    WATER,
)
from aeroscene.solids.shapes.facade import WALL_M

BEARING = GROUND - WATER - ROADS
"""Ground on which an object may stand without being its child."""

_BEARING_M = 0.1
"""Depth by which a slab may extend into the walls that carry it."""
_PARAPET_M = 0.25
"""Rim along the borders of a roof that objects on it leave free."""


def cuttable(obj: SceneObject) -> tuple[bool, bool]:
    """True if an object may become shorter along its own x, and along its own y.

    Args:
        obj: Object; its category decides.
    """
    is_area = obj.category in GROUND | ROOMS | FLOORS | DECKS | ROOFS
    # Walls and fences are thin along x; only their length may be cut.
    return is_area, is_area or obj.category in WALLS | FENCES


def least_m(obj: SceneObject) -> tuple[float, float]:
    """Shortest length and width that a cut leaves of an object, m."""
    category = CATALOGUE[obj.category_id]
    return category.length_m[0], category.width_m[0]


def is_chained(obj: SceneObject, parent: SceneObject) -> bool:
    """Return true if an object continues its parent instead of lying on it.

    Pieces of a bent street do so: each is the child of the piece before it.
    """
    return obj.category in STRIPS and obj.category_id == parent.category_id


def is_fitting(obj: SceneObject, parent: SceneObject) -> bool:
    """Return true if an object is a room, wall or slab of its parent, a building."""
    return obj.category in ROOMS | WALLS | FLOORS and parent.category in BUILDINGS


def margin_m(obj: SceneObject, parent: SceneObject) -> float | None:
    """Distance that an object keeps from its parent's border, m; None if it may extend over it."""
    if is_chained(obj, parent) or obj.category in ROOFS:
        return None
    if is_fitting(obj, parent):
        return WALL_M - (_BEARING_M if obj.category in FLOORS else 0.0)
    return _PARAPET_M if parent.category in ROOFS else 0.0
