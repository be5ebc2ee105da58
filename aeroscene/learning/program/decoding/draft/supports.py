"""Places that a category requires, whatever a unit's numbers: boats afloat, plates before chairs.

A relation says how an object stands to its host, but not that there is water under a boat. Here
such objects are moved to the nearest suitable place. Units that were read off a scene have one
already and stay. An object without any such place is left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import shapely

from aeroscene.feasibility.seats import TO_CHAIR_M
from aeroscene.feasibility.strays import LEAST_ON_WATER
from aeroscene.learning.program.decoding.draft.neighbours import moved, way_onto
from aeroscene.relations.plane import QUARTER, Place, Rectangle, footprint, turned_reach_m
from aeroscene.relations.relation import LANE_RATIOS
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import AFLOAT, BRIDGES, ROADS, SEATS, VEHICLES, WATER

_MIDDLE_M = 0.3
"""Distance from the middle line of a road within which a vehicle is in no lane."""
_LEAST_OVER = 0.1
"""Least share of a bridge's outline over the water or road that it crosses."""


def mended(
    category: str, boxes: Sequence[OrientedBox], objects: Sequence[SceneObject]
) -> list[OrientedBox]:
    """Return the boxes of a unit's members where their category has to be.

    Args:
        category: Category of the unit.
        boxes: Boxes as drawn.
        objects: Objects so far.
    """
    if category in AFLOAT:
        waters = _footprints(objects, WATER)
        return [found for box in boxes if (found := _afloat(box, waters))]
    if category in BRIDGES:
        crossed = _footprints(objects, WATER | ROADS)
        return [found for box in boxes if (found := _over(box, crossed))]
    if category in VEHICLES:
        roads = _footprints(objects, ROADS)
        return [_in_lane(box, roads) for box in boxes]
    return list(boxes)


def drawn_in(boxes: Sequence[OrientedBox], tiles: Sequence[Rectangle]) -> list[OrientedBox]:
    """Move a unit's boxes so that the middle of each is on a tile of its bearer.

    All go together by the least shift onto a tile. Members of a group that is too large are left
    out if they are outside even then.
    """
    if all(is_on_any(box, tiles) for box in boxes):
        return list(boxes)
    if len(boxes) == 1:
        return [_moved_in(boxes[0], tiles)]
    # The tile with the least shift, of a room that consists of several.
    shift = min((way_onto(boxes, tile) for tile in tiles), key=lambda way: math.hypot(*way))
    inside = [box for each in boxes if is_on_any(box := moved(each, shift), tiles)]
    return inside or [_moved_in(boxes[0], tiles)]


def is_on_any(box: OrientedBox, outlines: Sequence[Rectangle]) -> bool:
    """True if the middle of a box is on any of some outlines, seen from above."""
    at = footprint(box).place
    local = ((outline.half_m, outline.place.local(at)) for outline in outlines)
    return any(abs(u_m) <= half_m[0] and abs(v_m) <= half_m[1] for half_m, (u_m, v_m, _) in local)


def laid_for(plates: Sequence[OrientedBox], objects: Sequence[SceneObject]) -> list[OrientedBox]:
    """Return the plates on a table that have a chair before them."""
    chairs = [obj.bbox.p[:2] for obj in objects if obj.category in SEATS]
    return [
        plate
        for plate in plates
        if any(math.dist(plate.p[:2], chair) <= TO_CHAIR_M for chair in chairs)
    ]


def _footprints(objects: Sequence[SceneObject], categories: frozenset[str]) -> list[Rectangle]:
    return [footprint(obj.bbox) for obj in objects if obj.category in categories]


def _polygon(outline: Rectangle) -> shapely.Polygon:
    (x, y), at = outline.half_m, outline.place
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    corners = [(x, y), (-x, y), (-x, -y), (x, -y)]
    return shapely.Polygon([(at.x_m + c * u - s * v, at.y_m + s * u + c * v) for u, v in corners])


def _share_on(box: OrientedBox, outlines: Sequence[Rectangle]) -> float:
    """Return the share of a box, seen from above, that lies on any of some outlines."""
    own = _polygon(footprint(box))
    # Joined first: covers overlap, and shared ground must not count twice.
    whole = shapely.union_all([_polygon(each) for each in outlines])
    return float(shapely.area(shapely.intersection(own, whole)) / own.area)


def _afloat(box: OrientedBox, waters: Sequence[Rectangle]) -> OrientedBox | None:
    """Return a boat's box: unchanged on water, else on the nearest water that is large enough."""
    if not waters:
        return None
    if _share_on(box, waters) >= LEAST_ON_WATER:
        return box
    found = [
        moved
        for water in waters
        # A boat that is too long for a narrow water may fit across it.
        for turns in (0, 1)
        if (moved := _inside(box, water, turns)) is not None
    ]
    return min(found, key=lambda moved: math.dist(moved.p, box.p), default=None)


def _inside(box: OrientedBox, outline: Rectangle, turns: int) -> OrientedBox | None:
    """Return a box wholly inside an outline, after quarter turns; None if it has no room."""
    at = footprint(box)
    u_m, v_m, turn_rad = outline.place.local(at.place)
    turn_rad += turns * QUARTER
    reach_m = turned_reach_m(at.half_m, turn_rad)
    play_m = [half_m - own_m for half_m, own_m in zip(outline.half_m, reach_m, strict=True)]
    if min(play_m) < 0:
        return None
    u_m, v_m = (
        min(max(value, -most_m), most_m) for value, most_m in zip((u_m, v_m), play_m, strict=True)
    )
    return _put(box, outline.place.moved(u_m, v_m, turn_rad))


def _moved_in(box: OrientedBox, outlines: Sequence[Rectangle]) -> OrientedBox:
    """Return a box inside the nearest outline; in its middle along axes without room."""
    found: list[OrientedBox] = []
    for outline in outlines:
        at = footprint(box)
        u_m, v_m, turn_rad = outline.place.local(at.place)
        reach_m = turned_reach_m(at.half_m, turn_rad)
        play_m = [max(0.0, a - b) for a, b in zip(outline.half_m, reach_m, strict=True)]
        u_m, v_m = (
            min(max(value, -most_m), most_m)
            for value, most_m in zip((u_m, v_m), play_m, strict=True)
        )
        to = outline.place.moved(u_m, v_m)
        found.append(replace(box, p=(to.x_m, to.y_m, box.p[2])))
    return min(found, key=lambda moved: math.dist(moved.p, box.p))


def _over(box: OrientedBox, crossed: Sequence[Rectangle]) -> OrientedBox | None:
    """Return a bridge's box: unchanged over water or road, else over the nearest one's middle."""
    if not crossed:
        return None
    if _share_on(box, crossed) >= _LEAST_OVER:
        return box
    at = footprint(box).place
    nearest = min(
        crossed, key=lambda each: math.hypot(each.place.x_m - at.x_m, each.place.y_m - at.y_m)
    )
    return _put(box, replace(at, x_m=nearest.place.x_m, y_m=nearest.place.y_m))


def _in_lane(box: OrientedBox, roads: Sequence[Rectangle]) -> OrientedBox:
    """Move a vehicle on the middle line of a road to the lane on its right."""
    at = footprint(box).place
    for road in roads:
        u_m, v_m, turn_rad = road.place.local(at)
        if abs(u_m) <= road.half_m[0] and abs(v_m) < _MIDDLE_M:
            lane_m = 2 * road.half_m[1] * LANE_RATIOS[1]
            # Right-hand traffic: along the road's axis the lane lies at negative v.
            if math.cos(turn_rad) >= 0:
                return _put(box, road.place.moved(u_m, -lane_m))
            return _put(box, road.place.moved(u_m, lane_m, math.pi))
    return box


def _put(box: OrientedBox, at: Place) -> OrientedBox:
    """Return a box at a place, upright."""
    return OrientedBox((at.x_m, at.y_m, box.p[2]), quat_from_yaw(at.yaw_rad), box.s)
