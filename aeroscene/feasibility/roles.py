"""Roles of objects in a projection: their hosts, and which may be cut or must stay in a building.

Facts about the categories, read off the corpus: which surfaces abut, what reaches where.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aeroscene.scene import SceneObject
from aeroscene.scene.catalogue import CATALOGUE
from aeroscene.solids.shapes.facade import WALL_M

COVERS = frozenset({"lawn", "plaza", "parking_lot", "sidewalk", "road", "water"})
"""Thin surfaces that tile the ground."""
GROUND = COVERS | {"terrain"}
"""Covers and raised land."""
TILING = frozenset({"lawn", "plaza", "parking_lot"})
"""Covers that are laid as wide as what stands on them."""
BUILDINGS = frozenset({"building", "house", "tower", "warehouse"})
"""Categories of which rooms, walls, floors and roofs are parts."""
SHELLS = BUILDINGS | {"garage"}
"""What has outer walls of its own, within the rim of its box."""
FITTINGS = frozenset({"room", "wall", "floor"})
"""Parts that lie within a building."""
BEARING = COVERS - {"water", "road"} | {"terrain"}
"""Ground on which something may stand that is no child of it."""
CHAINS = frozenset({("road", "road"), ("sidewalk", "sidewalk")})
"""Child and parent of which one continues the other, end to end."""

_BOTH = (True, True)
_NEITHER = (False, False)
_ALONG_Y = (False, True)
_CUTTABLE: Mapping[str, tuple[bool, bool]] = MappingProxyType(
    {
        **dict.fromkeys(COVERS, _BOTH),
        **dict.fromkeys(("terrain", "room", "floor", "deck"), _BOTH),
        "roof": _BOTH,
        "wall": _ALONG_Y,
        "fence": _ALONG_Y,
    }
)
_RIM_M: Mapping[str, float] = MappingProxyType({"roof": 0.25, "water": 0.0})
"""Rim along a parent's borders that its children leave free: the parapet of a roof."""
_BEARING_M = 0.1
"""Distance that a slab may reach into the walls that carry it."""
POSTS = frozenset({"street_lamp"})
"""Categories that reach beyond their parent's outline except at the foot, as the arm of a lamp."""


def cuttable(obj: SceneObject) -> tuple[bool, bool]:
    """Whether an object may become shorter along its own x and y."""
    return _CUTTABLE.get(obj.category, _NEITHER)


def least_m(obj: SceneObject) -> tuple[float, float]:
    """Shortest length and width that a cut leaves an object."""
    category = CATALOGUE[obj.category_id]
    return category.length_m[0], category.width_m[0]


def is_chained(obj: SceneObject, parent: SceneObject) -> bool:
    """Whether an object continues its parent instead of lying on it."""
    return (obj.category, parent.category) in CHAINS


def is_fitting(obj: SceneObject, parent: SceneObject) -> bool:
    """Whether an object is a room, wall or slab of its parent, a building."""
    return obj.category in FITTINGS and parent.category in BUILDINGS


def margin_m(obj: SceneObject, parent: SceneObject) -> float | None:
    """Distance that an object keeps from its parent's border; None where it may reach over it."""
    if is_chained(obj, parent) or obj.category == "roof":
        return None
    if is_fitting(obj, parent):
        return WALL_M - (_BEARING_M if obj.category == "floor" else 0.0)
    return _RIM_M.get(parent.category, 0.0)
