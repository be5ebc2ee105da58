"""Primitives of objects in the world, from the shapes of their categories.

Collisions, pictures, maps, landing areas and exports all start from these primitives, so that a
drone lands on what it sees and hits what is drawn. Shapes are functions that are found by the name
of their category; a new category needs no registration.
"""

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
from aeroscene.solids.shapes.outline_prisms import outlined_parts
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
"""Shape of every category: the function of its name, for example `boats.boat`."""


_KEPT = 1024
"""Number of objects whose primitives are kept: those of a few scenes."""
_LEAST_M = 5e-4
_SLACK_M = 0.02
"""Length by which a part may extend beyond its box: paint on a road, a handle."""


def object_parts(category: str, look: Look) -> list[Part]:
    """Parts of an object of some category.

    Args:
        category: Name of a category.
        look: Size, attributes and number of the object.

    Returns:
        Parts in the frame of the box. A size that is too odd for the shape gives a plain box
        instead, because no size of a valid scene may fail.
    """
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
    # A box about a turned part: sums of absolute values, the usual bound of a rotated box.
    if part.quat_wxyz != IDENTITY:
        extents = (np.abs(rotation_matrix(part.quat_wxyz)) @ extents).tolist()
    x, y, z = part.position_m
    # Parts are placed from the bottom of the box, hence the half height.
    offsets = (x, y, z - size_m[2] / 2)
    return all(
        abs(offset) + extent / 2 <= whole / 2 + _SLACK_M
        for offset, extent, whole in zip(offsets, extents, size_m, strict=True)
    )


@lru_cache(maxsize=_KEPT)
def object_primitives(obj: SceneObject) -> tuple[Primitive, ...]:
    """Primitives of one object in the world, ENU.

    They are kept, because a scene in the making asks for them again and again.
    """
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
                position_enu_m=position,
                quat_wxyz=quat_product(box.q, part.quat_wxyz),  # pyrefly: ignore[bad-argument-type]
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
        SceneError: If there are more than `MOST_PRIMITIVES`.
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
