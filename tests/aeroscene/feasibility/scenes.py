"""Small scenes for the tests of the projection, and noise that unsettles any."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id

LAWN, HOME, TABLE, CUP, BENCH, PLAZA = range(6)


def thing(number, category, p, s, parent=None, yaw_rad=0.0, **attributes):
    return SceneObject(
        id=number,
        scene_id="garden",
        parent_id=parent,
        category_id=category_id(category),
        bbox=OrientedBox(p, quat_from_yaw(yaw_rad), s),
        domain="outdoor",
        attributes=attributes,
    )


GARDEN = (
    thing(LAWN, "lawn", (0.0, 0.0, 0.03), (30.0, 30.0, 0.06)),
    thing(HOME, "landing_pad", (8.0, 8.0, 0.085), (2.6, 2.6, 0.05), LAWN, is_start=True),
    thing(TABLE, "table", (-6.0, 0.0, 0.435), (1.2, 2.0, 0.75), LAWN),
    thing(CUP, "cup", (-6.0, 0.5, 0.86), (0.1, 0.1, 0.1), TABLE),
    thing(BENCH, "bench", (-6.0, -5.0, 0.46), (0.6, 1.8, 0.8), LAWN),
    thing(PLAZA, "plaza", (0.0, 20.0, 0.05), (30.0, 10.0, 0.1)),
)


def garden(*changed: SceneObject) -> Scene:
    """The garden with some of its objects replaced, or added."""
    things = {obj.id: obj for obj in GARDEN} | {obj.id: obj for obj in changed}
    return Scene(
        scene_id="garden",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-20.0, -20.0, 0.0),
        extent_max_enu_m=(20.0, 30.0, 25.0),
        start_position_enu_m=(8.0, 8.0, 0.11),
        start_yaw_rad=0.0,
        latitude_deg=47.0,
        longitude_deg=8.0,
        altitude_m=400.0,
        objects=tuple(things.values()),
    )


def unsettled(scene: Scene, sigma_m: float, seed: int) -> Scene:
    """A scene of which every object is off its place upon its parent, along the vertical a little.

    Children move along; sizes are off by 2%. Small things are off by less.
    """
    rng = np.random.default_rng(seed)
    moved: dict[int | None, np.ndarray] = {None: np.zeros(3)}
    objects = []
    for obj in scene.objects:
        scale = min(1.0, max(obj.bbox.s[:2])) * np.array((1.0, 1.0, 0.2))
        moved[obj.id] = moved[obj.parent_id] + sigma_m * scale * rng.normal(size=3)
        p = np.array(obj.bbox.p) + moved[obj.id]
        s = [side * math.exp(0.02 * rng.normal()) for side in obj.bbox.s]
        box = OrientedBox((float(p[0]), float(p[1]), float(p[2])), obj.bbox.q, (s[0], s[1], s[2]))
        objects.append(replace(obj, bbox=box))
    return replace(scene, objects=tuple(objects), interaction_areas=())


def row_of(layout, number):
    """Row of the object with this id."""
    return next(row for row, obj in enumerate(layout.objects) if obj.id == number)
