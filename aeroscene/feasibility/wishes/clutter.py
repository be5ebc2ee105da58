"""Clutter: more loose objects on the ground and on the floors of rooms.

They are thrown onto open ground and floors by area, on top of whatever stands there. The projection
that follows moves each to the nearest free place, out of doorways and away from the home pad.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aeroscene.feasibility.roles import BEARING
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import FLOORS, LOOSE, ROOMS, TERRAIN, by_name

_LOOSE = sorted(LOOSE)
"""Sorted, so that the same seed throws the same objects: sets have no order of their own."""
USUAL = 15
"""Mean number of loose objects on the ground and floors of 30 shipped scenes. A scene with fewer
counts as if it had this many.
"""
_LEAST_SIDE_M = 2.0
"""Width up to which ground and rooms stay as they are."""
_RIM_M = 0.7
"""Distance of an object's middle from the border of the surface onto which it is thrown."""


def cluttered(scene: Scene, times: float, rng: np.random.Generator) -> Scene:
    """Throw loose objects into a scene until it has a multiple of them; overlaps are left.

    Args:
        scene: A scene before its projection.
        times: Factor, from 1.
        rng: Draws objects and places.

    Returns:
        The scene; the given one if it has no open surface or nothing is to be added.
    """
    hosts = [obj for obj in scene.objects if _is_open(obj)]
    n_loose = sum(_is_loose(scene, obj) for obj in scene.objects)
    n_more = round((times - 1.0) * max(n_loose, USUAL))
    if not hosts or n_more <= 0:
        return scene
    areas_m2 = np.array([host.bbox.s[0] * host.bbox.s[1] for host in hosts])
    chosen = rng.choice(len(hosts), size=n_more, p=areas_m2 / areas_m2.sum())
    first = 1 + max(obj.id for obj in scene.objects)
    more = [_thrown(hosts[k], first + i, rng) for i, k in enumerate(chosen.tolist())]
    return replace(scene, objects=(*scene.objects, *more))


def clutter_factor(before: Scene, after: Scene) -> float:
    """Factor by which a scene has more loose objects than before `cluttered`; 1 for as many."""
    n_before, n_after = (
        sum(_is_loose(scene, obj) for obj in scene.objects) for scene in (before, after)
    )
    return 1.0 + (n_after - n_before) / max(n_before, USUAL)


def _is_open(obj: SceneObject) -> bool:
    is_floor = obj.category in ROOMS or (
        obj.category in BEARING - TERRAIN and obj.domain == "outdoor"
    )
    return is_floor and min(obj.bbox.s[:2]) >= _LEAST_SIDE_M


def _is_loose(scene: Scene, obj: SceneObject) -> bool:
    """Return true if an object lies about on ground or a floor, not on a shelf."""
    if obj.category not in LOOSE or obj.parent_id is None:
        return False
    return scene.object_by_id[obj.parent_id].category in BEARING | ROOMS | FLOORS


def _thrown(host: SceneObject, number: int, rng: np.random.Generator) -> SceneObject:
    kind = by_name()[_LOOSE[int(rng.integers(len(_LOOSE)))]]
    sides = (kind.length_m, kind.width_m, kind.height_m)
    size = np.round([rng.uniform(*side) for side in sides], 3)
    centre, extent = np.array(host.bbox.p), np.array(host.bbox.s)
    reach = extent[:2] / 2 - _RIM_M
    u, v = rng.uniform(-reach, reach)
    c, s = math.cos(host.bbox.yaw_rad), math.sin(host.bbox.yaw_rad)
    floor = -1.0 if host.category in ROOMS else 1.0
    z = centre[2] + floor * extent[2] / 2 + size[2] / 2
    at = np.round([centre[0] + c * u - s * v, centre[1] + s * u + c * v, z], 4)
    return SceneObject(
        id=number,
        scene_id=host.scene_id,
        parent_id=host.id,
        category_id=kind.id,
        bbox=OrientedBox(
            tuple(at.tolist()), quat_from_yaw(rng.uniform(-math.pi, math.pi)), tuple(size.tolist())
        ),
        domain=host.domain,
    )
