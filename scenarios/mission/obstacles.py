"""A scene's solids and free space in the planner's terms."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from aeroscene.scene import Scene, Vector3
from aeroscene.solids.freespace import VoxelField
from aeroscene.solids.shapes import Primitive
from autonomy.planning import DistanceField, Obstacles, Shape
from flightsim.looks.hull import hull_faces

_SHAPES = {
    "box": Shape.BOX,
    "cylinder": Shape.CYLINDER,
    "ellipsoid": Shape.ELLIPSOID,
    "mesh": Shape.HULL,
}
_GROUND_DEPTH_M = 10.0
_KEPT_HULLS = 4096


def scene_obstacles(scene: Scene, primitives: Sequence[Primitive]) -> Obstacles:
    """Obstacles of everything that a drone can touch, the ground last."""
    solids = [primitive for primitive in primitives if primitive.collides]
    faces = [_faces(primitive) for primitive in solids]
    ground_center, ground_size = _ground(scene)
    return Obstacles(
        center_enu_m=np.array([*(s.position_enu_m for s in solids), ground_center]),
        quat_wxyz=np.array([*(s.quat_wxyz for s in solids), (1.0, 0.0, 0.0, 0.0)]),
        size_m=np.array([*(s.size_m for s in solids), ground_size]),
        shape=np.array([*(_SHAPES[s.kind] for s in solids), Shape.BOX], dtype=np.int64),
        faces=np.concatenate([*faces, np.zeros((0, 4))]),
        faces_end=np.cumsum([*(len(f) for f in faces), 0], dtype=np.int64),
    )


def distance_field(voxels: VoxelField) -> DistanceField:
    """The scene's distance field in the planner's type."""
    return DistanceField(
        origin_enu_m=voxels.origin_enu_m,
        resolution_m=voxels.resolution_m,
        distance_m=np.ascontiguousarray(voxels.distance_m),
    )


def _faces(primitive: Primitive) -> np.ndarray:
    """Normals and offsets of a hull's faces, local; none for shapes measured by their extents."""
    return _hull_planes(primitive.vertices_m) if primitive.kind == "mesh" else np.zeros((0, 4))


@functools.lru_cache(maxsize=_KEPT_HULLS)
def _hull_planes(vertices_m: tuple[Vector3, ...]) -> np.ndarray:
    corners = np.array(vertices_m)
    return np.array([[*n, n @ corners[members[0]]] for n, members in hull_faces(corners)])


def _ground(scene: Scene) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Centre and size of a slab that extends well beyond the flight volume."""
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    size = 3 * (high - low)
    size[2] = _GROUND_DEPTH_M
    center = (low + high) / 2
    center[2] = low[2] - _GROUND_DEPTH_M / 2
    return tuple(center.tolist()), tuple(size.tolist())
