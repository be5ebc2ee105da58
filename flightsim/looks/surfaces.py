"""Surfaces of primitives in the world; round ones have the detail of the picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from aeroscene.solids.shapes import Primitive
from flightsim.looks.tessellation import Surface, box, cylinder, ellipsoid, hull


@dataclass(frozen=True, kw_only=True, slots=True)
class Detail:
    """Detail of a drawn world."""

    slices: int
    """Number of sides of round shapes."""
    stacks: int
    """Number of their bands from pole to pole."""
    has_light: bool = False
    """True puts light and shadows into the skins, for renderers that compute none."""
    has_textures: bool = True
    """True gives the skins their textures; without them every surface has one colour."""


FAST = Detail(slices=14, stacks=8, has_light=True)
"""Detail that software rendering at camera rate affords."""
BARE = replace(FAST, has_light=False, has_textures=False)
"""The same surfaces for images of depth alone, without the cost of light and textures."""
FINE = Detail(slices=40, stacks=24)
"""Detail of pictures, which are lit pixel by pixel."""


def surface_enu(primitive: Primitive, detail: Detail) -> Surface:
    """Return the surface of a primitive in the world.

    Args:
        primitive: The solid.
        detail: Sides and bands of round shapes.
    """
    local = _local_surface(primitive, detail)
    turn = rotation_enu(primitive).T
    return Surface(
        local.vertices_m @ turn + primitive.position_enu_m,
        local.normals @ turn,
        local.texture_m,
        local.triangles,
    )


def rotation_enu(primitive: Primitive) -> np.ndarray:
    """Return the axes (3, 3) of the primitive in the world, as columns."""
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, np.array(primitive.quat_wxyz))
    return rotation.reshape(3, 3)


def _local_surface(primitive: Primitive, detail: Detail) -> Surface:
    size_m = np.array(primitive.size_m)
    if primitive.kind == "box":
        return box(size_m)
    if primitive.kind == "ellipsoid":
        return ellipsoid(size_m, detail.slices, detail.stacks)
    if primitive.kind == "cylinder":
        return cylinder(float(size_m[0]) / 2, float(size_m[2]), detail.slices)
    return hull(np.array(primitive.vertices_m))
