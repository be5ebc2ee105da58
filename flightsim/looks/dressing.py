"""Dressing of solids for pictures: more than their one material.

Facades get a style and a ground floor, ceilings panels and lamps, room walls skirtings, tree crowns
a tint each. The choice depends on the object's category and id, so that a scene always looks the
same. Dressing moves no surface, so that depth and contacts stay as they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from aeroscene.scene.catalogue import FLOORS, ROOFS, WALLS
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.shapes.materials import FACADE_BAY_M
from flightsim.looks.paint import Colour, Paint, material_paint

FaceSet = tuple[int, ...]
ALL_FACES: FaceSet = ()
"""All faces; other sets list them in the order of `tessellation.unit_box`."""
TOP, BOTTOM = 4, 5
SIDES: FaceSet = (0, 1, 2, 3)

_TWO_BAYS_M = (2 * FACADE_BAY_M[0], 2 * FACADE_BAY_M[1])
_HOUSE_STYLES = ("punched", "shuttered", "brickwork")
_TOWN_STYLES = ("punched", "balconies", "shuttered", "stonework")
_MODERN_STYLES = ("ribbon", "balconies", "curtain_wall")
_MODERN_COLOURS = ("facade_slate", "facade_white", "facade_sky")
_LEAF_TINTS: tuple[Colour, ...] = (
    (1.0, 1.0, 1.0),
    (1.22, 1.08, 0.80),
    (0.82, 0.92, 0.92),
    (1.10, 0.98, 1.10),
)
_GRASS_TINTS: tuple[Colour, ...] = ((1.0, 1.0, 1.0), (1.10, 1.02, 0.88), (0.90, 0.97, 0.95))
_ROOM_FINISHES = ("dado", "skirting", "papered")
_LEAST_ROOM_WALL_M = 1.9  # lower walls are parapets, not those of a room
_CEILING_ABOVE_M = 2.0
"""Height above the ground of an underside beyond which a slab is a ceiling."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Part of a primitive's surface with its paint."""

    primitive: Primitive
    paint: Paint
    faces: FaceSet = ALL_FACES


def dress(primitive: Primitive, category: str | None) -> Iterator[Piece]:
    """Yield pieces that together cover a primitive's surface.

    Args:
        primitive: Solid of the world.
        category: Category of its object; None for solids without an object of the scene.
    """
    paint = material_paint(primitive.material)
    if primitive.material.startswith("facade_"):
        yield from _facade(primitive, paint, category)
    elif paint.texture == "leaves":
        tint = _LEAF_TINTS[primitive.object_id % len(_LEAF_TINTS)]
        yield Piece(primitive, paint.tinted(tint))
    elif paint.texture == "grass":
        tint = _GRASS_TINTS[primitive.object_id % len(_GRASS_TINTS)]
        yield Piece(primitive, paint.tinted(tint))
    elif paint.texture == "paint" and category == "container":
        yield Piece(primitive, paint.with_texture("container", (2.0, 2.6)))
    elif primitive.kind == "box" and category in FLOORS | ROOFS:
        yield from _slab(primitive, paint)
    elif primitive.kind == "box" and category in WALLS:
        yield from _room_wall(primitive, paint)
    else:
        yield Piece(primitive, paint)


def _facade(primitive: Primitive, paint: Paint, category: str | None) -> Iterator[Piece]:
    """Yield a facade in the style of the house; tall ones get a ground floor of their own."""
    number = primitive.object_id
    if primitive.material == "facade_brick":
        style = "brickwork"
    elif category == "house":
        style = _HOUSE_STYLES[number % len(_HOUSE_STYLES)]
    elif category == "tower" or primitive.material in _MODERN_COLOURS:
        style = _MODERN_STYLES[number % len(_MODERN_STYLES)]
    else:
        style = _TOWN_STYLES[number % len(_TOWN_STYLES)]
    upper = paint.with_texture(style, _TWO_BAYS_M)
    width, rise, thick = primitive.size_m
    storey = FACADE_BAY_M[1]
    if category == "house" or rise < 1.9 * storey:
        yield Piece(primitive, upper)
        return
    # Two of three houses have shops.
    ground = "shop_front" if number % 3 else "entrance"
    if category == "tower":
        ground = "entrance"
    low, high = (width, storey, thick), (width, rise - storey, thick)
    lower = paint.with_texture(ground, _TWO_BAYS_M)
    yield Piece(_shifted(primitive, low, (storey - rise) / 2), lower)
    yield Piece(_shifted(primitive, high, storey / 2), upper)


def _shifted(primitive: Primitive, size_m: tuple[float, float, float], up_m: float) -> Primitive:
    """Return a panel of another size, further up or down the wall (its local y)."""
    w, x, y, z = primitive.quat_wxyz
    # Second column of the rotation: the panel's y axis in the world.
    up = (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x))
    east, north, height = (p + up_m * d for p, d in zip(primitive.position_enu_m, up, strict=True))
    return replace(primitive, size_m=size_m, position_enu_m=(east, north, height))


def _slab(primitive: Primitive, paint: Paint) -> Iterator[Piece]:
    """Yield floors and roofs, with a ceiling below if there is room for people."""
    underside_m = primitive.position_enu_m[2] - primitive.size_m[2] / 2
    if underside_m < _CEILING_ABOVE_M or min(primitive.size_m[:2]) < 1.0:
        yield Piece(primitive, paint)
        return
    yield Piece(primitive, paint, (*SIDES, TOP))
    yield Piece(primitive, material_paint("ceiling"), (BOTTOM,))


def _room_wall(primitive: Primitive, paint: Paint) -> Iterator[Piece]:
    """Yield inner walls from the floor up: skirting and cornice, in one of three finishes."""
    if paint.texture != "plaster" or primitive.size_m[2] < _LEAST_ROOM_WALL_M:
        yield Piece(primitive, paint)
        return
    finish = _ROOM_FINISHES[primitive.object_id % len(_ROOM_FINISHES)]
    # One tile from floor to ceiling.
    fitted = paint.with_texture(finish, (1.8, primitive.size_m[2]))
    yield Piece(primitive, fitted)
