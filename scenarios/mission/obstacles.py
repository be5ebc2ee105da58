"""A scene's solids and free space in the planner's terms.

`autonomy` never sees a scene. This module turns its solids, its ground and its relief into arrays
of convex obstacles.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from aeroscene.scene import Relief, Scene, Vector3
from aeroscene.solids.freespace import VoxelField
from aeroscene.solids.ground import ground_patches
from aeroscene.solids.shapes import Primitive
from autonomy.planning import DistanceField, Obstacles, Shape
from autonomy.planning.obstacles import join
from flightsim.looks.hull import hull_faces

_SHAPES = {
    "box": Shape.BOX,
    "cylinder": Shape.CYLINDER,
    "ellipsoid": Shape.ELLIPSOID,
    "mesh": Shape.HULL,
}
_GROUND_DEPTH_M = 10.0  # thickness of the slab below the flight volume
_GROUND_TOLERANCE_M = 0.03
"""Height up to which the obstacles of a relief reach above the ground, if they are few."""
_MOST_PRISMS = 20_000
"""Greatest number of obstacles of a relief; a rougher one gets larger obstacles, which extend
higher above it."""
_KEPT_HULLS = 4096  # meshes repeat: the same tree stands in many places


def scene_obstacles(scene: Scene, primitives: Sequence[Primitive]) -> Obstacles:
    """Return the obstacles of everything that a drone can touch, the ground last.

    Args:
        scene: Scene with its extent and relief.
        primitives: Its solids; those that do not collide are left out.
    """
    solids = [primitive for primitive in primitives if primitive.collides]
    faces = [_faces(primitive) for primitive in solids]
    things = Obstacles(
        center_enu_m=np.array([s.position_enu_m for s in solids], dtype=float).reshape(-1, 3),
        quat_wxyz=np.array([s.quat_wxyz for s in solids], dtype=float).reshape(-1, 4),
        size_m=np.array([s.size_m for s in solids], dtype=float).reshape(-1, 3),
        shape=np.array([_SHAPES[s.kind] for s in solids], dtype=np.int64),
        faces=np.concatenate([*faces, np.zeros((0, 4))]),
        faces_end=np.cumsum([len(f) for f in faces], dtype=np.int64),
    )
    ground = Obstacles.boxes(*(np.array([part]) for part in _ground(scene)))
    if scene.relief is None:
        return join([things, ground])
    return join([things, _hills(scene, scene.relief), ground])


def distance_field(voxels: VoxelField) -> DistanceField:
    """Return the scene's distance field in the planner's type."""
    return DistanceField(
        origin_enu_m=voxels.origin_enu_m,
        resolution_m=voxels.resolution_m,
        distance_m=np.ascontiguousarray(voxels.distance_m),
    )


def _faces(primitive: Primitive) -> np.ndarray:
    """Normals and offsets of a hull's faces, local; none for shapes given by their extents."""
    return _hull_planes(primitive.vertices_m) if primitive.kind == "mesh" else np.zeros((0, 4))


@functools.lru_cache(maxsize=_KEPT_HULLS)
def _hull_planes(vertices_m: tuple[Vector3, ...]) -> np.ndarray:
    corners = np.array(vertices_m)
    return np.array([[*n, n @ corners[members[0]]] for n, members in hull_faces(corners)])


def _hills(scene: Scene, relief: Relief) -> Obstacles:
    """Return prisms below the ground of a relief, each up to a plane nowhere below the ground."""
    bounds = (*scene.extent_min_enu_m[:2], *scene.extent_max_enu_m[:2])
    # Half, because a plane may lie as far above the ground as it lay below before it was raised.
    tolerance_m = _GROUND_TOLERANCE_M / 2
    while len(patches := ground_patches(relief, bounds, tolerance_m)) > _MOST_PRISMS:
        tolerance_m *= 2.0
    low_m = min(scene.extent_min_enu_m[2], relief.min_m) - 1.0
    prisms = [
        _prism(corners, gradient, height_m, low_m)
        for corners, gradient, height_m in zip(
            patches.corners_enu_m,
            patches.gradient,
            patches.height_at_origin_m + patches.above_m,
            strict=True,
        )
    ]
    centers, sizes, faces = zip(*prisms, strict=True)
    n = len(prisms)
    return Obstacles(
        center_enu_m=np.array(centers),
        quat_wxyz=np.tile((1.0, 0.0, 0.0, 0.0), (n, 1)),
        size_m=np.array(sizes),
        shape=np.full(n, int(Shape.HULL)),
        faces=np.concatenate(faces),
        faces_end=np.cumsum([len(face) for face in faces], dtype=np.int64),
    )


def _prism(
    corners: np.ndarray, gradient: np.ndarray, height_at_origin_m: float, low_m: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centre, size and faces of an upright prism with an oblique top."""
    top_m = height_at_origin_m + corners @ gradient
    low, high = np.array([*corners.min(0), low_m]), np.array([*corners.max(0), top_m.max()])
    center = (low + high) / 2
    along = np.roll(corners, -1, axis=0) - corners
    # Corners run counter-clockwise, so the right of an edge is outside.
    outward = np.stack([along[:, 1], -along[:, 0], np.zeros(len(along))], axis=1)
    upward = np.array([-gradient[0], -gradient[1], 1.0])
    normals = np.vstack([outward, upward, (0.0, 0.0, -1.0)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    on_faces = np.vstack([np.column_stack([corners, top_m]), (*corners[0], top_m[0]), low])
    offsets = np.einsum("ij,ij->i", normals, on_faces - center)
    return center, high - low, np.column_stack([normals, offsets])


def _ground(
    scene: Scene,
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Centre, attitude and size of a slab that extends well beyond the flight volume."""
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    size = 3 * (high - low)
    size[2] = _GROUND_DEPTH_M
    center = (low + high) / 2
    center[2] = low[2] - _GROUND_DEPTH_M / 2
    return tuple(center.tolist()), (1.0, 0.0, 0.0, 0.0), tuple(size.tolist())
