"""Start of a flight in a scene without a pad, from geometry alone.

A start is the middle of a wide free disc of ground. The first one counts from which there are
enough areas to fly to. If no such one exists, the one with the most areas counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.areas.bare_ground import above_ground
from aeroscene.areas.landing import derive_interaction_areas
from aeroscene.areas.needs import AreaLimits
from aeroscene.areas.reachability import access_field
from aeroscene.scene import Scene, SceneObject, Vector3
from aeroscene.scene.catalogue import LAWNS, OPEN_GROUND, ROADS, ROOMS
from aeroscene.scene.footprint import footprint
from aeroscene.solids.freespace import VoxelField
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.shapes.shell import FINISH_M

LEAST_RADIUS_M = 0.5
"""Least radius of the disc; a Hummingbird just fits into it."""
FREE_HEIGHT_M = 2.5
"""Least free height over the disc."""
MAX_PLACES = 3
"""Places that are tried on grounds of one rank."""
AWAY_M = 2.0
"""Landing areas nearer to the start than this make no flight."""
ENOUGH_AREAS = 3
"""Landing areas away from a start, for more than a small drone, that make it a good one."""
NO_START = "no free place to start from; valid: a disc of 0.5 m radius with nothing on or above it"
"""Message about a scene in which `with_start` finds no start."""
_FLAT_M = 0.06
"""Height above the ground up to which an object is part of it."""
_LOWEST_M = 0.3
"""A floor is a lowest one if it is at most this high above the bottom of the flight volume."""
# Tolerance of the largest circle's radius.
_TOLERANCE_M = 0.05


@dataclass(frozen=True, slots=True)
class Ground:
    """A piece of ground on which a flight may start."""

    outline: BaseGeometry
    height_m: float
    """Height of its upper face."""
    within: frozenset[int] = frozenset()
    """Ids of the objects that contain it, such as the building around a floor."""


def with_start(
    scene: Scene,
    ranks: Iterable[Sequence[Ground]],
    limits: AreaLimits | None = None,
    primitives: Sequence[Primitive] | None = None,
    field: VoxelField | None = None,
) -> Scene | None:
    """Return a scene with a start, and with the interaction areas that can be reached from there.

    Args:
        scene: The scene; the start and the areas that it has are ignored.
        ranks: Grounds, the preferred ones first.
        limits: Greatest numbers of areas; None sets no limit.
        primitives: The scene's primitives, if the caller has them already.
        field: Its distance field, likewise.

    Returns:
        The scene; None if there is no free place to start from.
    """
    primitives = scene_primitives(scene) if primitives is None else primitives
    if field is None:
        field = access_field(scene, primitives)
    best: tuple[int, Scene] | None = None
    for grounds in ranks:
        for place, yaw_rad in start_places(scene.objects, grounds):
            if not _is_inside(scene, place):
                continue
            found = replace(scene, start_position_enu_m=place, start_yaw_rad=yaw_rad)
            areas = derive_interaction_areas(found, primitives, field, limits)
            found = replace(found, interaction_areas=areas)
            n_away = _count_away(found)
            if best is None or n_away > best[0]:
                best = n_away, found
            # A good start ends the search, because each try derives all areas.
            if n_away >= ENOUGH_AREAS:
                return found
    return None if best is None else best[1]


def _is_inside(scene: Scene, place: Vector3) -> bool:
    bounds = zip(scene.extent_min_enu_m, place, scene.extent_max_enu_m, strict=True)
    return all(low <= value <= high for low, value, high in bounds)


def _count_away(scene: Scene) -> int:
    """Return the number of areas away from the start for more than a small drone."""
    x, y, _ = scene.start_position_enu_m
    return sum(
        area.drone_class != "small"
        and math.hypot(area.centroid[0] - x, area.centroid[1] - y) >= AWAY_M
        for area in scene.landing_areas
    )


def grounds_of(scene: Scene) -> tuple[tuple[Ground, ...], ...]:
    """Return the grounds of a scene by rank: indoors the lowest floors first, else open ground."""
    floors = tuple(
        Ground(footprint(obj), _bottom_m(obj) + FINISH_M, frozenset(scene.ancestors(obj.id)))
        for obj in scene.objects
        if obj.category in ROOMS and _bottom_m(obj) <= scene.extent_min_enu_m[2] + _LOWEST_M
    )
    is_open, last_resort = (
        tuple(
            _cover(scene, obj)
            for obj in scene.objects
            if obj.category in names and obj.domain == "outdoor"
        )
        for names in (OPEN_GROUND, ROADS)
    )
    if scene.domain == "indoor":
        return (floors, is_open, last_resort)
    return (is_open, last_resort, floors)


def _cover(scene: Scene, obj: SceneObject) -> Ground:
    """Return a cover as a ground, without the parts that the relief of the scene buries."""
    top_m = obj.bbox.p[2] + obj.bbox.s[2] / 2
    return Ground(above_ground(scene, footprint(obj), top_m), top_m)


def _bottom_m(obj: SceneObject) -> float:
    return obj.bbox.p[2] - obj.bbox.s[2] / 2


def start_places(
    objects: Sequence[SceneObject], grounds: Sequence[Ground]
) -> Iterator[tuple[Vector3, float]]:
    """Yield places to start from with the heading there, the widest disc first.

    The heading points to the middle of all grounds.

    Args:
        objects: All objects of the scene.
        grounds: Grounds on which to look.
    """
    if not grounds:
        return
    blocked = {
        key: shapely.union_all(_obstacles(objects, *key))
        # Grounds of one height in one building share their obstacles.
        for key in dict.fromkeys((ground.height_m, ground.within) for ground in grounds)
    }
    free = [shapely.difference(g.outline, blocked[g.height_m, g.within]) for g in grounds]
    middle = shapely.union_all([ground.outline for ground in grounds]).centroid
    for _ in range(MAX_PLACES):
        widest = _widest(free)
        if widest is None or widest[1].length < LEAST_RADIUS_M:
            return
        number, circle = widest
        (x, y), _ = shapely.get_coordinates(circle).tolist()
        yaw_rad = math.atan2(middle.y - y, middle.x - x)
        height_m = round(grounds[number].height_m, 4)
        yield (round(x, 3), round(y, 3), height_m), round(yaw_rad, 4)
        disc = shapely.Point(x, y).buffer(circle.length)
        free = [shapely.difference(region, disc) for region in free]


def _obstacles(
    objects: Sequence[SceneObject], ground_m: float, within: frozenset[int]
) -> list[BaseGeometry]:
    """Return the outlines of boxes in the way of a drone that stands on the ground."""
    outlines: list[BaseGeometry] = []
    for obj in objects:
        corners = obj.bbox.corners()
        low, high = float(corners[:, 2].min()), float(corners[:, 2].max())
        is_low = high > ground_m + _FLAT_M and low < ground_m + FREE_HEIGHT_M
        if is_low and obj.category not in LAWNS | ROOMS and obj.id not in within:
            outlines.append(footprint(obj))
    return outlines


def _widest(regions: Sequence[BaseGeometry]) -> tuple[int, shapely.LineString] | None:
    """Return the number of a region and the largest circle in any region, as its radius."""
    parts = [
        (number, part)
        for number, region in enumerate(regions)
        for part in shapely.get_parts(region)
        # Smaller parts cannot contain the least disc.
        if part.area > LEAST_RADIUS_M**2
    ]
    if not parts:
        return None
    circles = [shapely.maximum_inscribed_circle(part, _TOLERANCE_M) for _, part in parts]
    best = int(np.argmax([circle.length for circle in circles]))
    return parts[best][0], circles[best]
