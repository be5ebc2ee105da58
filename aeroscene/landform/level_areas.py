"""Ground of a site that stays level: paved, built or flooded ground, and some clearings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from jaxtyping import Float
from shapely.geometry.base import BaseGeometry

from aeroscene.neighbourhood.neighbourhood import RING_M
from aeroscene.neighbourhood.streets import streets_around
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import COVERS, GROUND, LAWNS, LEAFY, PADS, VEHICLES
from aeroscene.scene.footprint import footprint

PAD_M = 1.5
"""Level ground around a landing pad."""
_WIDE_M = 3.5
"""Longest side up to which objects follow the ground; larger ones stand level."""
_KERB_M = 0.5
"""Width of level ground beside streets outside of the site."""
CLEARING_M = 2.75
"""Radius of a clearing, on which a large drone can land."""
_WIDE_LAWN_M2 = 300.0
"""Area from which a lawn has two clearings."""
_APART_M = 8.0
"""Distance between the middles of two clearings of a lawn."""
_MOST_CLEARINGS = 4
"""Most clearings of a scene."""


def level_ground(scene: Scene, places: Float[np.ndarray, "n 2"]) -> list[BaseGeometry]:
    """Outlines of everything that needs level ground, in the site and around it; from above, ENU.

    Args:
        scene: Scene.
        places: Possible middles of clearings.
    """
    found = [*_stands(scene), *_streets(scene)]
    return [*found, *_clearings(scene, found, places)]


def _stands(scene: Scene) -> Iterator[BaseGeometry]:
    """Outlines of covers and objects that stay level."""
    for obj in scene.objects:
        if _is_level(scene, obj):
            outline = footprint(obj)
            yield outline.buffer(PAD_M) if obj.category in PADS else outline


def _clearings(
    scene: Scene, level: Sequence[BaseGeometry], places: Float[np.ndarray, "n 2"]
) -> Iterator[BaseGeometry]:
    """Discs of lawn that stay level, so that large drones find room among mounds.

    The ones nearest to level ground are taken, which leaves the middle of a lawn to the mounds.
    """
    lawns = [footprint(obj) for obj in scene.objects if _is_green(scene, obj)]
    if not lawns:
        return
    things = [
        footprint(obj)
        for obj in scene.objects
        if obj.domain == "outdoor" and not obj.is_coarse and obj.category not in GROUND
    ]
    is_green = shapely.intersects_xy(shapely.union_all(lawns), *places.T)
    places = places[is_green]
    points = np.asarray(shapely.points(places))
    away_m = _nearest_m(level, points)
    room_m = _nearest_m([*level, *things, *(lawn.exterior for lawn in lawns)], points)
    # The nearest to level ground come first.
    wide = np.flatnonzero(room_m >= CLEARING_M)
    wide = wide[np.argsort(away_m[wide], kind="stable")]
    n_left = _MOST_CLEARINGS
    for lawn in sorted(lawns, key=lambda each: -each.area):
        inside = places[wide[shapely.intersects(lawn, points[wide])]]
        for _ in range(min(n_left, 2 if lawn.area > _WIDE_LAWN_M2 else 1)):
            if len(inside):
                n_left -= 1
                yield shapely.Point(inside[0]).buffer(CLEARING_M)
                # Farther apart than their width, so that two clearings are two places to land.
                inside = inside[np.hypot(*(inside - inside[0]).T) >= _APART_M]


def _nearest_m(outlines: Sequence[BaseGeometry], points: np.ndarray) -> Float[np.ndarray, " n"]:
    """Distance of points to the nearest of some outlines, m; 0 within one, infinite without any."""
    if not outlines or not len(points):
        return np.full(len(points), np.inf)
    tree = shapely.STRtree(outlines)
    _, away_m = tree.query_nearest(points, return_distance=True, all_matches=False)
    return away_m


def _is_level(scene: Scene, obj: SceneObject) -> bool:
    """Return true if an object needs level ground of its own, not as a part of another."""
    if _is_green(scene, obj):
        return False
    # Its parent's ground decides.
    parent = None if obj.parent_id is None else scene.object_by_id[obj.parent_id]
    if parent is not None and parent.category not in COVERS:
        return False
    if obj.is_coarse or obj.category in PADS | VEHICLES:
        return True
    return obj.category not in LEAFY and max(obj.bbox.s[:2]) > _WIDE_M


def _is_green(scene: Scene, obj: SceneObject) -> bool:
    if obj.category not in LAWNS:
        return False
    above = (scene.object_by_id[each].category for each in scene.ancestors(obj.id))
    return all(category in COVERS for category in above)


def _streets(scene: Scene) -> Iterator[BaseGeometry]:
    for street in streets_around(scene, RING_M):
        end = np.array(street.begin) + street.length_m * np.array(street.along)
        line = shapely.LineString([street.begin, end])
        yield line.buffer(street.width_m / 2 + _KERB_M, cap_style="flat")
