"""Passages that are wide enough: doors of walls, and the clear width of corridors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import shapely
from shapely import affinity
from shapely.geometry.base import BaseGeometry

from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import ROOMS, WALLS

_STEP_M = 0.05
"""Steps in which the width of a corridor is measured."""
_ENDS_M = 0.5
"""Length at either end of a corridor that may be closed, by its end walls."""
_TOLERANCE_M = 0.01
"""Width by which a passage may fall short."""


@dataclass(frozen=True, slots=True)
class Passage:
    """A door or a corridor."""

    object_id: int
    """Wall of the door, or room that is the corridor."""
    what: str
    width_m: float


def widened(scene: Scene, least_m: float) -> Scene:
    """Widen every door of a wall to at least a width; the projection fits doors into walls."""
    return replace(scene, objects=tuple(_widened(obj, least_m) for obj in scene.objects))


def _widened(obj: SceneObject, least_m: float) -> SceneObject:
    width_m = _door_m(obj)
    if not 0 < width_m < least_m:
        return obj
    return replace(obj, attributes={**obj.attributes, "door_m": round(least_m, 4)})


def passages(scene: Scene) -> Iterator[Passage]:
    """Doors and corridors of a scene with their clear widths."""
    walls = [obj for obj in scene.objects if obj.category in WALLS]
    for wall in walls:
        width_m = _door_m(wall)
        if width_m > 0:
            yield Passage(wall.id, "door", min(width_m, wall.bbox.s[1]))
    for room in scene.objects:
        if room.category in ROOMS and room.attributes.get("use") == "corridor":
            yield Passage(room.id, "corridor", _corridor_width_m(room, walls))


def narrowest(scene: Scene) -> Passage | None:
    """The narrowest door or corridor of a scene; None if it has neither."""
    return min(passages(scene), key=lambda passage: passage.width_m, default=None)


def too_narrow(scene: Scene, least_m: float) -> str | None:
    """Describe in one line why a scene's passages are not wide enough; None if they are."""
    found = narrowest(scene)
    if found is None or found.width_m >= least_m - _TOLERANCE_M:
        return None
    return (
        f"the {found.what} of object {found.object_id} is {found.width_m:.2f} m wide; "
        f"valid: at least {least_m:g} m"
    )


def _door_m(obj: SceneObject) -> float:
    width = obj.attributes.get("door_m", 0.0) if obj.category in WALLS else 0.0
    return float(width) if isinstance(width, int | float) else 0.0


def _corridor_width_m(room: SceneObject, walls: list[SceneObject]) -> float:
    """Width of the widest disc that can be pushed along a corridor from end to end, m."""
    low, high = _rise_m(room.bbox)
    # The walls are cut at half the room's height, at most a metre above its floor.
    middle_m = (low + min(high, low + 2.0)) / 2
    inside = _footprint(room.bbox)
    solid = [_footprint(w.bbox) for w in walls if _spans(w.bbox, middle_m)]
    free = inside.difference(shapely.union_all(solid)) if solid else inside
    # From the full width down in small steps, until a disc passes.
    width_m = min(room.bbox.s[:2])
    while width_m > 0 and not _is_passable(free, room.bbox, width_m):
        width_m -= _STEP_M
    return max(width_m, 0.0)


def _is_passable(free: BaseGeometry, box: OrientedBox, width_m: float) -> bool:
    """Return true if the middles of a disc reach from one end of a corridor nearly to the other."""
    centres = free.buffer(-width_m / 2 + 1e-6)
    length_m = max(box.s[:2])
    wanted_m = length_m - width_m - 2 * _ENDS_M
    return any(_reach_m(part, box) >= wanted_m for part in shapely.get_parts(centres))


def _reach_m(part: BaseGeometry, box: OrientedBox) -> float:
    """Extent of a place along the long axis of a box, m."""
    if part.is_empty:
        return -1.0
    turned = affinity.rotate(part, -box.yaw_rad, origin=(0, 0), use_radians=True)
    x0, y0, x1, y1 = turned.bounds
    return x1 - x0 if box.s[0] >= box.s[1] else y1 - y0


def _footprint(box: OrientedBox) -> BaseGeometry:
    (x, y, _), (a, b, _) = box.p, box.s
    flat = shapely.box(-a / 2, -b / 2, a / 2, b / 2)
    turned = affinity.rotate(flat, box.yaw_rad, origin=(0, 0), use_radians=True)
    return affinity.translate(turned, x, y)


def _rise_m(box: OrientedBox) -> tuple[float, float]:
    return box.p[2] - box.s[2] / 2, box.p[2] + box.s[2] / 2


def _spans(box: OrientedBox, height_m: float) -> bool:
    low, high = _rise_m(box)
    return low < height_m < high
