"""Meshes of each object of a scene in its own frame, so that it can be moved in other programs.

An object's frame is its box's: origin in the middle, axes along the box. Poses are 4 x 4 matrices
that take a column of the frame on their right to the frame on their left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from jaxtyping import Float

from aeroscene.neighbourhood import neighbours_of
from aeroscene.scene import InteractionArea, Scene, SceneObject
from aeroscene.scene.box import rotation_matrix
from aeroscene.solids.shapes import Primitive
from flightsim.looks.surfaces import Detail, surface_enu
from flightsim.looks.tessellation import Surface

EXPORT_DETAIL = Detail(slices=20, stacks=12)
"""Detail of round shapes in files: between a camera's and a picture's."""

AREA_RGB = {
    "small": (0.20, 0.65, 0.95),
    "medium": (0.20, 0.80, 0.40),
    "large": (0.98, 0.65, 0.15),
}
"""Colours of areas by the drones that they are for, red, green and blue from 0 to 1."""

Pose = Float[np.ndarray, "4 4"]


@dataclass(frozen=True, eq=False)
class ObjectMesh:
    """One object with its skin and its solids."""

    obj: SceneObject
    pose_enu: Pose
    pose_parent: Pose
    """Pose in the frame of the parent object; for a root equal to `pose_enu`."""
    skins: dict[str, Surface]
    """Visible surfaces in the object's frame, one for each material."""
    solids: tuple[Primitive, ...]
    """Collision solids in the world, not in the object's frame."""


def object_meshes(
    scene: Scene, primitives: tuple[Primitive, ...], detail: Detail = EXPORT_DETAIL
) -> Iterator[ObjectMesh]:
    """Yield every object of a scene, parents before their children.

    Args:
        scene: Scene with the objects.
        primitives: Its solids, those of an object one after the other.
        detail: Detail of round shapes.
    """
    parts = {
        object_id: tuple(group)
        # Equal ids must be neighbours for this, as `scene_primitives` makes them.
        for object_id, group in groupby(primitives, lambda primitive: primitive.object_id)
    }
    poses: dict[int, Pose] = {}
    for obj in scene.objects:
        pose = pose_matrix(obj.bbox.p, obj.bbox.q)
        poses[obj.id] = pose
        own = parts.get(obj.id, ())
        yield ObjectMesh(
            obj=obj,
            pose_enu=pose,
            pose_parent=(
                pose if obj.parent_id is None else np.linalg.inv(poses[obj.parent_id]) @ pose
            ),
            skins=_skins(own, np.linalg.inv(pose), detail),
            solids=tuple(primitive for primitive in own if primitive.collides),
        )


def neighbour_skins(scene: Scene, detail: Detail = EXPORT_DETAIL) -> dict[str, Surface]:
    """Return the visible surfaces of the land around a site, in the world, by their materials."""
    return _skins(neighbours_of(scene), np.eye(4), detail)


def object_name(obj: SceneObject) -> str:
    """Return the name of an object's node, such as table_17."""
    return f"{obj.category}_{obj.id}"


def area_name(area: InteractionArea) -> str:
    """Return the name of an area's node, such as landing_3_medium."""
    return f"{area.kind}_{area.id}_{area.drone_class}"


def area_facts(area: InteractionArea) -> dict[str, Any]:
    """Return the facts about an area, for formats of numbers and text; object -1 is none."""
    return {
        "drone_class": area.drone_class,
        "radius_m": area.radius,
        "slope_rad": area.slope_rad,
        "clearance_m": area.clearance_m,
        "surface": area.surface,
        "object_id": -1 if area.object_id is None else area.object_id,
    }


def scene_facts(scene: Scene) -> dict[str, Any]:
    """Return the facts about a scene: its id and domain, and its place on the globe."""
    names = ("scene_id", "domain", "latitude_deg", "longitude_deg", "altitude_m")
    return {name: getattr(scene, name) for name in names}


def pose_matrix(position_m: tuple[float, ...], quat_wxyz: tuple[float, ...]) -> Pose:
    """Return the pose of a frame from its origin and attitude.

    Args:
        position_m: Origin in the outer frame.
        quat_wxyz: Unit quaternion, inner to outer frame.
    """
    pose = np.eye(4)
    pose[:3, :3] = rotation_matrix(quat_wxyz)
    pose[:3, 3] = position_m
    return pose


def _skins(primitives: tuple[Primitive, ...], local: Pose, detail: Detail) -> dict[str, Surface]:
    surfaces: dict[str, list[Surface]] = {}
    for primitive in primitives:
        surfaces.setdefault(primitive.material, []).append(surface_enu(primitive, detail))
    return {name: _moved(joined(group), local) for name, group in surfaces.items()}


def joined(surfaces: list[Surface]) -> Surface:
    """Join several surfaces into one, each with its own vertices."""
    # Triangles count vertices, so each surface's numbers shift by the vertices before it.
    first = np.cumsum([0] + [len(surface.vertices_m) for surface in surfaces[:-1]])
    return Surface(
        np.concatenate([surface.vertices_m for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.texture_m for surface in surfaces]),
        np.concatenate([s.triangles + n for s, n in zip(surfaces, first, strict=True)]),
    )


def _moved(surface: Surface, pose: Pose) -> Surface:
    turn = pose[:3, :3].T  # points are rows, so the rotation is transposed
    return Surface(
        surface.vertices_m @ turn + pose[:3, 3],
        surface.normals @ turn,
        surface.texture_m,
        surface.triangles,
    )
