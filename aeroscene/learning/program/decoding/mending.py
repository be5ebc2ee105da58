"""What a unit's place has to be whatever its numbers: boats afloat, traffic on its own side.

Nothing changes where nothing has to: what was read off a scene stays as it is. What has no such
place is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import shapely

from aeroscene.relations.hosts import SEATED_AT, VEHICLES
from aeroscene.relations.plane import QUARTER, Place, Rectangle, footprint, turned_reach_m
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.box import quat_from_yaw

AFLOAT = frozenset({"boat"})
BRIDGES = frozenset({"bridge"})
CROSSED = frozenset({"water", "road"})
_LEAST_AFLOAT, _LEAST_OVER = 0.95, 0.1
"""Least shares of the outlines of a boat on water, of a bridge over what it crosses."""
_ACROSS_RAD = math.radians(45.0)
_IN_THE_WAY_M = 0.02
"""Deepest that a chair reaches into what it does not belong to."""
_STEP_M, _N_SPOKES, _MOST_M = 0.1, 16, 4.0


def mended(
    category: str, boxes: Sequence[OrientedBox], objects: Sequence[SceneObject]
) -> list[OrientedBox]:
    """The boxes of a unit's members where they have to be, among what stands already."""
    if category in AFLOAT:
        waters = _footprints(objects, frozenset({"water"}))
        return [found for box in boxes if (found := _afloat(box, waters))]
    if category in BRIDGES:
        crossed = _footprints(objects, CROSSED)
        return [found for box in boxes if (found := _over(box, crossed))]
    if category in VEHICLES:
        roads = _footprints(objects, frozenset({"road"}))
        return [_on_its_side(box, roads) for box in boxes]
    return list(boxes)


def _footprints(objects: Sequence[SceneObject], categories: frozenset[str]) -> list[Rectangle]:
    return [footprint(obj.bbox) for obj in objects if obj.category in categories]


def _polygon(outline: Rectangle) -> shapely.Polygon:
    (x, y), at = outline.half_m, outline.place
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    corners = [(x, y), (-x, y), (-x, -y), (x, -y)]
    return shapely.Polygon([(at.x_m + c * u - s * v, at.y_m + s * u + c * v) for u, v in corners])


def _share_on(box: OrientedBox, outlines: Sequence[Rectangle]) -> float:
    """Share of a box, seen from above, that lies on any of some outlines."""
    own = _polygon(footprint(box))
    whole = shapely.union_all([_polygon(each) for each in outlines])
    return float(shapely.area(shapely.intersection(own, whole)) / own.area)


def _afloat(box: OrientedBox, waters: Sequence[Rectangle]) -> OrientedBox | None:
    """A boat where it is if that is water, else on the nearest that is large enough for it."""
    if not waters:
        return None
    if _share_on(box, waters) >= _LEAST_AFLOAT:
        return box
    found = [
        moved
        for water in waters
        for turns in (0, 1)
        if (moved := _inside(box, water, turns)) is not None
    ]
    return min(found, key=lambda moved: math.dist(moved.p, box.p), default=None)


def _inside(box: OrientedBox, outline: Rectangle, turns: int) -> OrientedBox | None:
    """A box wholly inside an outline, after quarter turns; None where it has no room."""
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


def _over(box: OrientedBox, crossed: Sequence[Rectangle]) -> OrientedBox | None:
    """A bridge where it is if that is over water or road, else over the middle of the nearest."""
    if not crossed:
        return None
    if _share_on(box, crossed) >= _LEAST_OVER:
        return box
    at = footprint(box).place
    nearest = min(
        crossed, key=lambda each: math.hypot(each.place.x_m - at.x_m, each.place.y_m - at.y_m)
    )
    return _put(box, replace(at, x_m=nearest.place.x_m, y_m=nearest.place.y_m))


def _on_its_side(box: OrientedBox, roads: Sequence[Rectangle]) -> OrientedBox:
    """A vehicle on a road headed along it, with the road's middle to its left."""
    at = footprint(box).place
    on = [(*road.place.local(at), road) for road in roads]
    under = [
        each
        for each in on
        if abs(each[0]) <= each[3].half_m[0] and abs(each[1]) <= each[3].half_m[1]
    ]
    if not under:
        return box
    _, v_m, turn_rad, _ = min(under, key=lambda each: abs(math.sin(each[2])))
    is_across = abs(math.cos(turn_rad)) < math.cos(_ACROSS_RAD)
    if not is_across and v_m * math.cos(turn_rad) <= 0:
        return box
    ahead_rad = 0.0 if v_m <= 0 else math.pi
    off_rad = math.remainder(turn_rad, QUARTER)
    return _put(box, replace(at, yaw_rad=at.yaw_rad - turn_rad + ahead_rad + off_rad))


def _put(box: OrientedBox, at: Place) -> OrientedBox:
    """A box at a place, upright."""
    return OrientedBox((at.x_m, at.y_m, box.p[2]), quat_from_yaw(at.yaw_rad), box.s)


def room_for_seats(
    chairs: Sequence[OrientedBox], table: int, objects: Sequence[SceneObject]
) -> tuple[tuple[float, float], list[bool]]:
    """How far a table moves with its chairs so that none reaches into another, and which have room.

    Args:
        chairs: Boxes of the table's chairs.
        table: Its id.
        objects: All that stands, their ids being their places.
    """
    others = [
        obj
        for obj in objects
        if obj.category in SEATED_AT | {"chair"}
        and obj.id != table
        and obj.parent_id == objects[table].parent_id
    ]
    group = [objects[table].bbox, *chairs]
    obstacles = [_polygon(footprint(obj.bbox)) for obj in others if _is_level(obj.bbox, group)]
    own = np.array([_polygon(footprint(box)).buffer(-_IN_THE_WAY_M) for box in group])
    whole = shapely.union_all(obstacles)
    shapely.prepare(whole)
    in_the_way = shapely.intersects(own[1:], whole)
    if not in_the_way.any():
        return (0.0, 0.0), [True] * len(chairs)
    for shift_m in _shifts():
        if not shapely.intersects(shapely.transform(own, lambda at: at + shift_m), whole).any():  # noqa: B023
            return shift_m, [True] * len(chairs)
    return (0.0, 0.0), (~in_the_way).tolist()


def _is_level(box: OrientedBox, group: Sequence[OrientedBox]) -> bool:
    """Whether a box shares height with any of a group."""
    return any(abs(box.p[2] - other.p[2]) < (box.s[2] + other.s[2]) / 2 for other in group)


def _shifts() -> Iterator[tuple[float, float]]:
    """Ways to go, the shortest first."""
    radius_m = _STEP_M
    while radius_m < _MOST_M:
        for spoke in range(_N_SPOKES):
            angle = spoke * math.tau / _N_SPOKES
            yield radius_m * math.cos(angle), radius_m * math.sin(angle)
        radius_m += max(_STEP_M, 0.15 * radius_m)
