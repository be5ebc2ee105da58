"""Scenes to measure: a few boxes, and real ones that were disturbed."""

import math
from dataclasses import replace

import numpy as np

from aeroscene.landform import level
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import category_id


def box(p, s, yaw_deg=0.0, q=None):
    half = math.radians(yaw_deg) / 2
    return OrientedBox(
        tuple(map(float, p)), q or (math.cos(half), 0.0, 0.0, math.sin(half)), tuple(map(float, s))
    )


def scene_of(*rows, name="boxes"):
    """Rows are category, box and, where it has one, the row of the parent."""
    objects = tuple(
        SceneObject(
            id=10 + number,
            scene_id=name,
            parent_id=10 + parent[0] if parent else None,
            category_id=category_id(category),
            bbox=bbox,
            domain="outdoor",
        )
        for number, (category, bbox, *parent) in enumerate(rows)
    )
    return Scene(
        scene_id=name,
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-40.0, -40.0, 0.0),
        extent_max_enu_m=(40.0, 40.0, 40.0),
        start_position_enu_m=(0.0, 0.0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=0.0,
        longitude_deg=0.0,
        altitude_m=0.0,
        objects=objects,
    )


def moved(scene, shift_m):
    """Every object by its own row of `shift_m`."""
    objects = tuple(
        replace(obj, bbox=replace(obj.bbox, p=tuple((np.array(obj.bbox.p) + shift).tolist())))
        for obj, shift in zip(scene.objects, shift_m, strict=True)
    )
    return replace(scene, objects=objects, interaction_areas=())


def turned(scene, quarters):
    """The whole scene on flat ground by quarter turns about the origin."""
    scene = level(scene)
    c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarters % 4]
    half = quarters * math.pi / 4
    objects = []
    for obj in scene.objects:
        (x, y, z), (w, _, _, k) = obj.bbox.p, obj.bbox.q
        q = (
            w * math.cos(half) - k * math.sin(half),
            0.0,
            0.0,
            w * math.sin(half) + k * math.cos(half),
        )
        objects.append(
            replace(obj, bbox=replace(obj.bbox, p=(c * x - s * y, s * x + c * y, z), q=q))
        )
    return replace(scene, objects=tuple(objects), interaction_areas=())
