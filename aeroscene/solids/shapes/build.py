"""Builds the primitives of objects in the world."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from inspect import getmembers, isfunction

import numpy as np

from aeroscene.files.bounds import MOST_PRIMITIVES
from aeroscene.scene import Scene, SceneError, SceneObject, Vector3
from aeroscene.scene.box import quat_product, rotation_matrix
from aeroscene.scene.catalogue import by_name
from aeroscene.solids.shapes import (
    bathroom,
    boats,
    buildings,
    fences,
    furniture,
    goods,
    ground,
    household,
    roofs,
    rooftop,
    seats,
    shell,
    stalls,
    storage,
    street,
    structures,
    terrain,
    vegetation,
    vehicles,
)
from aeroscene.solids.shapes.look import Look, Shape
from aeroscene.solids.shapes.outlined import outlined_parts
from aeroscene.solids.shapes.primitive import IDENTITY, Part, Primitive, block

SHAPES: Mapping[str, Shape] = {
    name.removesuffix("_"): shape
    for module in (
        bathroom,
        boats,
        buildings,
        fences,
        furniture,
        goods,
        ground,
        household,
        roofs,
        rooftop,
        seats,
        shell,
        stalls,
        storage,
        street,
        structures,
        terrain,
        vegetation,
        vehicles,
    )
    for name, shape in getmembers(module, isfunction)
    if name.removesuffix("_") in by_name() and shape.__module__ == module.__name__
}
"""The shape of every category: the function of its name, as `boats.boat`."""


_KEPT = 1024
"""Objects whose primitives are kept: those of a few scenes."""
_LEAST_M = 5e-4
_SLACK_M = 0.02
"""Length by which a part may stand out of its box: paint on a road, a handle."""


def object_parts(category: str, look: Look) -> list[Part]:
    """Parts of a category at a size; a size too odd for its shape gives a plain box."""
    parts = outlined_parts(category, look) or SHAPES[category](look)
    is_solid = any(part.collides for part in parts)
    if is_solid and all(_is_sound(part, look.size_m) for part in parts):
        return parts
    x, y, z = look.size_m
    return [block(x, y, (0.0, z), "concrete")]


def _is_sound(part: Part, size_m: Vector3) -> bool:
    if min(part.size_m) < _LEAST_M:
        return False
    extents = part.size_m
    if part.quat_wxyz != IDENTITY:
        extents = (np.abs(rotation_matrix(part.quat_wxyz)) @ extents).tolist()
    x, y, z = part.position_m
    offsets = (x, y, z - size_m[2] / 2)
    return all(
        abs(offset) + extent / 2 <= whole / 2 + _SLACK_M
        for offset, extent, whole in zip(offsets, extents, size_m, strict=True)
    )


@lru_cache(maxsize=_KEPT)
def object_primitives(obj: SceneObject) -> tuple[Primitive, ...]:
    """Primitives of one object in the world, ENU; kept, since a scene in the making asks again."""
    box = obj.bbox
    look = Look(box.s, obj.attributes, obj.id)
    rows = rotation_matrix(box.q).tolist()
    floor = box.s[2] / 2
    primitives = []
    for part in object_parts(obj.category, look):
        x, y, z = part.position_m
        z -= floor
        position = tuple(
            box.p[i] + rows[i][0] * x + rows[i][1] * y + rows[i][2] * z for i in range(3)
        )
        primitives.append(
            Primitive(
                kind=part.kind,
                position_enu_m=position,  # pyright: ignore[reportArgumentType]
                quat_wxyz=quat_product(box.q, part.quat_wxyz),  # pyright: ignore[reportArgumentType]
                size_m=part.size_m,
                material=part.material,
                object_id=obj.id,
                collides=part.collides,
                vertices_m=part.vertices_m,
            )
        )
    return tuple(primitives)


def scene_primitives(scene: Scene) -> tuple[Primitive, ...]:
    """Primitives of every object of a scene, in the order of the objects.

    Raises:
        SceneError: If they are more than `MOST_PRIMITIVES`.
    """
    primitives: list[Primitive] = []
    for obj in scene.objects:
        primitives += object_primitives(obj)
        if len(primitives) > MOST_PRIMITIVES:
            raise SceneError(
                f"scene {scene.scene_id!r}: object {obj.id}: the objects so far have more than "
                f"{MOST_PRIMITIVES} parts; valid: fewer or smaller objects"
            )
    return tuple(primitives)
