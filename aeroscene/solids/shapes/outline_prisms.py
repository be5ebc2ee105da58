"""Shapes of objects whose attribute `outline` is a polygon: prisms over its convex pieces.

A prism takes any outline exactly, courtyards included, so that collisions, landing areas, pictures
and exports all follow the same walls. Boxes would need a staircase along every slanted wall.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from math import atan2, cos, hypot, sin
from typing import TYPE_CHECKING

from aeroscene.scene.catalogue import by_name
from aeroscene.scene.outline import outline_in_box
from aeroscene.solids.shapes.convex import Point2, Ring, convex_pieces
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import FACADE_BAY_M, WALL_COLOURS
from aeroscene.solids.shapes.outline_roofs import outlined_roof
from aeroscene.solids.shapes.primitive import Interval, Part, block, hull

if TYPE_CHECKING:
    import shapely

GROUND_FINISHES = (
    "asphalt",
    "cobbles",
    "concrete",
    "grass",
    "gravel",
    "paving",
    "red_paving",
    "rubber",
    "sand",
    "soil",
    "water",
)
"""Materials of a cover with an outline: values of its attribute `finish`."""
_FINISH = {
    "road": "asphalt",
    "parking_lot": "asphalt",
    "sidewalk": "paving",
    "plaza": "paving",
    "lawn": "grass",
    "water": "water",
}
_BLOCK_MATERIAL = {"warehouse": "cladding_grey", "garage": "concrete", "kiosk": "timber"}
_PANEL_M, _DOOR_M = 0.012, 0.018
"""Thickness of panes and of doors. Half of it lies before the wall, within the slack by which parts
may exceed their box.
"""
_LEAST_WALL_M = 2.0
"""Length from which a wall has windows."""
# Bounds the parts of an outline with hundreds of corners; the longest walls come first.
_MOST_PANELS = 200
_RIGHT = 1e-3
"""Cosine up to which a corner counts as a right angle."""
_POST_M = 0.25
_CANOPY_M = 0.25
_MOST_POSTS = 12


def outlined_parts(category: str, look: Look) -> list[Part] | None:
    """Parts of an object that has an outline; None for one without.

    Args:
        category: Name of the object's category; its roles choose the shape.
        look: Size and attributes of the object.

    Raises:
        SceneError: If the attribute `outline` is no valid polygon.
    """
    polygon = outline_in_box(look.attributes, look.size_m)
    if polygon is None:
        return None
    roles = by_name()[category].roles
    shape = next((s for role, s in _SHAPES.items() if role in roles), _prisms_of)
    return shape(category, look, polygon)


def prisms(polygon: shapely.Polygon, z: Interval, material: str) -> list[Part]:
    """Upright prisms over a polygon; prisms over rectangles are boxes, which collide faster.

    Args:
        polygon: Outline, in m.
        z: Lower and upper end, m.
        material: Name of the material.
    """
    return [_prism(ring, z, material) for ring in convex_pieces(polygon)]


def _prism(ring: Ring, z: Interval, material: str) -> Part:
    if len(ring) == 4 and (box := _upright_box(ring, z, material)) is not None:
        return box
    return hull([(x, y, height) for x, y in ring for height in z], material)


def _upright_box(ring: Ring, z: Interval, material: str) -> Part | None:
    """The box over a rectangle; None for any other quadrilateral."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = ring
    length, width = hypot(bx - ax, by - ay), hypot(cx - bx, cy - by)
    dot = (bx - ax) * (cx - bx) + (by - ay) * (cy - by)
    # One right angle and equal opposite sides make a rectangle.
    if abs(dot) > _RIGHT * length * width or hypot(ax - bx + cx - dx, ay - by + cy - dy) > 1e-3:
        return None
    heading = atan2(by - ay, bx - ax)
    return Part(
        kind="box",
        position_m=((ax + cx) / 2, (ay + cy) / 2, (z[0] + z[1]) / 2),
        quat_wxyz=(cos(heading / 2), 0.0, 0.0, sin(heading / 2)),
        size_m=(length, width, z[1] - z[0]),
        material=material,
    )


def _building(category: str, look: Look, polygon: shapely.Polygon) -> list[Part]:
    """A mass with windows on its walls and a door in the longest of them.

    Reads the attribute `colour`.
    """
    z = look.size_m[2]
    if category in _BLOCK_MATERIAL:
        return prisms(polygon, (0.0, z), _BLOCK_MATERIAL[category])
    colour = look.choice("colour", (*WALL_COLOURS, "brick"))
    wall = "brick" if colour == "brick" else f"plaster_{colour}"
    walls = sorted(_walls(polygon), key=lambda pair: -hypot(*_along(pair)))
    skins = [
        _skin(pair, (0.0, _whole_storeys(z)), f"facade_{colour}")
        for pair in walls[:_MOST_PANELS]
        if hypot(*_along(pair)) >= _LEAST_WALL_M
    ]
    doors = [_skin(walls[0], (0.0, min(2.3, 0.8 * z)), "dark_wood", 1.4)] if skins else []
    return [*prisms(polygon, (0.0, z), wall), *skins, *doors]


def _walls(polygon: shapely.Polygon) -> list[tuple[Point2, Point2]]:
    # Shapely's default turns the exterior counter-clockwise and holes clockwise.
    """Edges of a polygon, each with the inside to its left."""
    import shapely

    oriented = shapely.orient_polygons(polygon)
    rings = [oriented.exterior, *oriented.interiors]
    return [((ax, ay), (bx, by)) for ring in rings for (ax, ay), (bx, by) in pairwise(ring.coords)]


def _along(pair: tuple[Point2, Point2]) -> Point2:
    (ax, ay), (bx, by) = pair
    return (bx - ax, by - ay)


def _whole_storeys(height_m: float) -> float:
    storey_m = FACADE_BAY_M[1]
    return min(height_m, max(1, int(height_m / storey_m + 1e-6)) * storey_m)


def _skin(
    wall: tuple[Point2, Point2], z: Interval, material: str, width_m: float | None = None
) -> Part:
    """A pane of colour in the middle of a wall, local z outwards; whole bays wide by default."""
    (ax, ay), (bx, by) = wall
    length = hypot(bx - ax, by - ay)
    bay_m = FACADE_BAY_M[0]
    wide = min(length, max(1, int(length / bay_m + 1e-6)) * bay_m if width_m is None else width_m)
    thick = _PANEL_M if width_m is None else _DOOR_M
    # The inside is to the left of the wall, hence outwards is to its right.
    out = atan2(ax - bx, by - ay)
    # The product of a turn about z by `out` and the turn that takes local z to x, local y up.
    c, s = cos(out / 2) / 2, sin(out / 2) / 2
    return Part(
        kind="box",
        position_m=((ax + bx) / 2, (ay + by) / 2, (z[0] + z[1]) / 2),
        quat_wxyz=(c - s, c - s, c + s, c + s),
        size_m=(wide, z[1] - z[0], thick),
        material=material,
        collides=False,
    )


def _canopy(_category: str, look: Look, polygon: shapely.Polygon) -> list[Part]:
    """A roof on posts, which stand within its corners."""
    import shapely

    z = look.size_m[2]
    thick = min(_CANOPY_M, 0.3 * z)
    # An outline too narrow for posts leaves nothing, and the roof has none.
    inner = shapely.buffer(polygon, -_POST_M, join_style="mitre")
    ring = shapely.get_coordinates(shapely.simplify(inner, 1.0))[:-1].tolist()
    step = max(1, len(ring) // _MOST_POSTS)
    posts = [
        block((x - 0.1, x + 0.1), (y - 0.1, y + 0.1), (0.0, z - thick), "dark_metal")
        for x, y in ring[::step]
    ]
    return [*prisms(polygon, (z - thick, z), "metal"), *posts]


def _cover(category: str, look: Look, polygon: shapely.Polygon) -> list[Part]:
    finish = look.choice("finish", GROUND_FINISHES, (_FINISH.get(category, "paving"),))
    return prisms(polygon, (0.0, look.size_m[2]), finish)


def _prisms_of(category: str, look: Look, polygon: shapely.Polygon) -> list[Part]:
    return prisms(polygon, (0.0, look.size_m[2]), _BLOCK_MATERIAL.get(category, "concrete"))


def _roof(_category: str, look: Look, polygon: shapely.Polygon) -> list[Part]:
    return outlined_roof(look, polygon) or prisms(
        polygon, (0.0, look.size_m[2]), look.choice("cover", ("roofing", "gravel", "concrete"))
    )


_OutlinedShape = Callable[[str, Look, "shapely.Polygon"], list[Part]]
_SHAPES: Mapping[str, _OutlinedShape] = {
    "building": _building,
    "roof": _roof,
    "canopy": _canopy,
    "cover": _cover,
}
"""Shape of each role; all other categories are a plain prism."""
