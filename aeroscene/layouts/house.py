"""Ground outdoors; indoors floors, walls, a roof and a yard."""

from __future__ import annotations

import math

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.assembly import slab, upright_box
from aeroscene.layouts.document import LayoutRoom
from aeroscene.layouts.ground import cover
from aeroscene.layouts.site import FINISH_M, GROUND_M, MOST_CLEAR_M, Grounds, Site
from aeroscene.layouts.walls import DOOR_HEIGHT_M, MAX_GAP_M, OUTER_M, WallPlan, plan_walls
from aeroscene.scene import AttributeValue

LEAST_CLEAR_M = 3.0
"""Least height of rooms; higher if the tallest object in them asks for it."""
ROOF_M = 0.25
"""Thickness of a roof."""
YARD_M = 6.0
"""Width of the lawn around a house."""
_LAWN_TILE_M = 60.0
_ROOM_TILE_M = 16.0
_ROOF_TILE_M = 40.0
_PLAIN: dict[str, AttributeValue] = {"form": "plain"}


def lay_ground(site: Site) -> Grounds:
    """Lay lawn over the floor's outline, or over the bounds if there is none."""
    area = shapely.box(*site.bounds)
    if site.layout.floor:
        area = shapely.intersection(area, shapely.Polygon(site.layout.floor))
    _lay_lawn(site, area, GROUND_M)
    return [[area]]


def build_house(site: Site) -> tuple[Grounds, float]:
    """Build all rooms of a layout under one roof.

    Args:
        site: Layout on its way to a scene; changed.

    Returns:
        Grounds on which a drone may start, and the height of the roof's top, m.
    """
    rooms = _rooms(site)
    # A tenth of a metre above the tallest object.
    clear_m = min(max(LEAST_CLEAR_M, round(site.top_m - FINISH_M + 0.1, 2)), MOST_CLEAR_M)
    height_m = FINISH_M + clear_m
    for number, room in enumerate(rooms):
        attributes: dict[str, AttributeValue] = {"room": number, "room_type": room.name}
        # Tiles of one room share its number: they count as one room without walls between them.
        for tile in cover(room.polygon, _ROOM_TILE_M):
            box = slab(tile, 0.0, height_m)
            site.assembly.add("room", box, "indoor", attributes=attributes)
    for wall in plan_walls(rooms, _furniture(site), site.layout.doors):
        _raise_wall(site, wall, height_m)
    floors = [shapely.Polygon(room.polygon) for room in rooms]
    outline = _outer_faces(floors)
    for tile in cover(outline, _ROOF_TILE_M):
        box = slab(tile, height_m, height_m + ROOF_M)
        site.assembly.add("roof", box, "outdoor", attributes={"form": "flat"})
    x0, y0, x1, y1 = outline.bounds
    plot = shapely.box(x0 - YARD_M, y0 - YARD_M, x1 + YARD_M, y1 + YARD_M)
    yard = shapely.difference(plot, outline)
    _lay_lawn(site, yard, FINISH_M)
    # Rooms before the yard: a start indoors is preferred.
    return [floors, [yard]], height_m + ROOF_M


def _rooms(site: Site) -> tuple[LayoutRoom, ...]:
    layout = site.layout
    if layout.rooms:
        return layout.rooms
    x0, y0, x1, y1 = site.bounds
    outline = layout.floor or ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    names = [layout.attributes.get(key) for key in ("room_type", "room_name")]
    name = next((name for name in names if isinstance(name, str) and name), "room")
    return (LayoutRoom(name=name, polygon=outline),)


def _lay_lawn(site: Site, area: BaseGeometry, thickness_m: float) -> None:
    for tile in cover(area, _LAWN_TILE_M):
        site.assembly.add("lawn", slab(tile, 0.0, thickness_m), "outdoor", attributes=_PLAIN)


def _furniture(site: Site) -> list[shapely.Polygon]:
    """Outlines of all objects that may be in the way through an opening."""
    outlines = [
        # What hangs above a door is not in the way.
        shapely.convex_hull(shapely.MultiPoint(kept.box.corners()[:, :2]))
        for kept in site.kept.values()
        if kept.low_m < DOOR_HEIGHT_M
    ]
    return [outline for outline in outlines if isinstance(outline, shapely.Polygon)]


def _raise_wall(site: Site, wall: WallPlan, height_m: float) -> None:
    attributes: dict[str, AttributeValue] = {"colour": "white"}
    if wall.opening_m is not None:
        attributes["door_m"] = wall.door_m
        attributes["door_offset_m"] = round(wall.opening_m, 3)
        attributes["door_height_m"] = FINISH_M + DOOR_HEIGHT_M
    # Our walls are long along their own y axis.
    size = (wall.thickness_m, wall.length_m, height_m)
    box = upright_box(wall.centre, wall.heading_rad - math.pi / 2, size, 0.0)
    site.assembly.add("wall", box, "indoor", attributes=attributes)


def _outer_faces(floors: list[shapely.Polygon]) -> BaseGeometry:
    """Outline of the outer walls; gaps between rooms that share a wall are closed."""
    closing_m = MAX_GAP_M / 2 + 0.01
    grown = shapely.union_all(floors).buffer(closing_m, join_style="mitre")
    return grown.buffer(OUTER_M - closing_m, join_style="mitre")
