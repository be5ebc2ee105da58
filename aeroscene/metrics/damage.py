"""Scenes damaged on purpose, in known order, to test the figures themselves.

    damaged = DAMAGES["jitter_0.3"](scene, rng)

A figure that does not rise from a milder to a worse damage of one kind does not measure what its
name says. docs/metrics.md has the table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from aeroscene.landform import level
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import CATALOGUE, SEATS

Damage = Callable[[Scene, np.random.Generator], Scene]
"""Function from a scene to the same scene with some objects changed, without areas."""

# Share of the chairs that are turned, and the least angle: a quarter turn is plainly wrong.
_CHAIRS_TURNED = 0.5
_LEAST_TURN_RAD = math.pi / 2


def jittered(scene: Scene, rng: np.random.Generator, *, spread_m: float) -> Scene:
    """Displace every object relative to its parent by a Gaussian along each axis.

    Children move along with their parents.

    Args:
        scene: The scene.
        rng: Source of the displacements.
        spread_m: Standard deviation along each axis.
    """
    scene = level(scene)
    shift_m: dict[int | None, np.ndarray] = {None: np.zeros(3)}
    for obj in scene.objects:
        shift_m[obj.id] = shift_m[obj.parent_id] + rng.normal(0.0, spread_m, 3)
    return _with(scene, [_at(obj, np.array(obj.bbox.p) + shift_m[obj.id]) for obj in scene.objects])


def relabelled(scene: Scene, rng: np.random.Generator) -> Scene:
    """Exchange categories at random among the objects of a level; boxes stay.

    Args:
        scene: The scene.
        rng: Source of the exchange.
    """
    scene = level(scene)
    category = np.array([obj.category_id for obj in scene.objects])
    is_coarse = np.array([CATALOGUE[number].level == "coarse" for number in category.tolist()])
    for is_first in (True, False):
        rows = np.flatnonzero(is_coarse == is_first)
        category[rows] = category[rng.permutation(rows)]
    pairs = zip(scene.objects, category.tolist(), strict=True)
    # Attributes belong to the shape of a category, so they are removed.
    return _with(scene, [replace(obj, category_id=number, attributes={}) for obj, number in pairs])


def spun(scene: Scene, rng: np.random.Generator) -> Scene:
    """Turn every object about its own vertical by any angle."""
    scene = level(scene)
    angles = rng.uniform(-math.pi, math.pi, len(scene.objects)).tolist()
    pairs = zip(scene.objects, angles, strict=True)
    return _with(scene, [_turned(obj, angle) for obj, angle in pairs])


def with_chairs_turned(
    scene: Scene, rng: np.random.Generator, *, share: float = _CHAIRS_TURNED
) -> Scene:
    """Turn a share of the chairs about their own vertical by a quarter turn or more.

    Args:
        scene: The scene.
        rng: Chooses the chairs and their angles.
        share: Share of the chairs that are turned.
    """
    scene = level(scene)
    chairs = [row for row, obj in enumerate(scene.objects) if obj.category in SEATS]
    rows = set(rng.permutation(chairs)[: round(share * len(chairs))].tolist())
    # From a quarter turn to one before the full turn: never nearly as before.
    angles = rng.uniform(_LEAST_TURN_RAD, 2 * math.pi - _LEAST_TURN_RAD, len(scene.objects))
    return _with(
        scene,
        [
            _turned(obj, float(angles[row])) if row in rows else obj
            for row, obj in enumerate(scene.objects)
        ],
    )


DAMAGES: Mapping[str, Damage] = {
    "jitter_0.1": partial(jittered, spread_m=0.1),
    "jitter_0.3": partial(jittered, spread_m=0.3),
    "jitter_1": partial(jittered, spread_m=1.0),
    "chairs_turned": with_chairs_turned,
    "random_yaw": spun,
    "shuffled_categories": relabelled,
}
"""Damages by name; jitter in metres."""


def _with(scene: Scene, objects: list[SceneObject]) -> Scene:
    return replace(scene, objects=tuple(objects), interaction_areas=())


def _at(obj: SceneObject, place_enu_m: np.ndarray) -> SceneObject:
    x, y, z = place_enu_m.tolist()
    return replace(obj, bbox=replace(obj.bbox, p=(x, y, z)))


def _turned(obj: SceneObject, angle_rad: float) -> SceneObject:
    quat_wxyz = quat_from_yaw(obj.bbox.yaw_rad + angle_rad)
    return replace(obj, bbox=replace(obj.bbox, q=quat_wxyz))
