"""The scene in a recording: primitives in batches by coarse object, ground, areas."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import rerun as rr
from jaxtyping import Float, Int

from aeroscene.scene import InteractionArea, Scene, SceneObject
from aeroscene.scene.catalogue import CATALOGUE
from aeroscene.solids.shapes import MATERIALS, Primitive
from scenarios.recording import layout

DRONE_CLASS_RGB: Mapping[str, tuple[int, int, int]] = {
    "small": (88, 196, 255),
    "medium": (120, 220, 90),
    "large": (255, 190, 60),
}
"""Colour of a landing area, by the largest class of drone that fits."""
PERCHING_RGB = (214, 120, 255)
"""Colour of a perching area."""

_GROUND_RGB = (96, 122, 76)
_GROUND_MARGIN_M = 20.0
_GROUND_HEIGHT_M = -0.02
"""A touch below zero, where floors and roads lie."""
_AREA_LIFT_M = 0.04
"""Height of a drawn landing area above its surface, so that the two do not flicker."""
_AREA_FILL_ALPHA = 110


def log_scene(stream: rr.RecordingStream, scene: Scene, primitives: Iterable[Primitive]) -> None:
    """Write everything about the scene that never changes."""
    stream.log(layout.WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    classes = [rr.AnnotationInfo(id=c.id, label=c.name) for c in CATALOGUE.values()]
    stream.log(layout.SCENE, rr.AnnotationContext(classes), static=True)
    _log_ground(stream, scene)
    objects = {o.id: o for o in scene.objects}
    groups: dict[str, list[Primitive]] = defaultdict(list)
    for primitive in primitives:
        groups[_group_path(objects, primitive.object_id)].append(primitive)
    categories = {o.id: o.category_id for o in scene.objects}
    for path, members in groups.items():
        _log_group(stream, path, members, categories)
    for drone_class, rgb in DRONE_CLASS_RGB.items():
        areas = [a for a in scene.landing_areas if a.drone_class == drone_class]
        _log_areas(stream, f"{layout.LANDING_AREAS}/{drone_class}", rgb, areas)
    _log_areas(stream, layout.PERCHING_AREAS, PERCHING_RGB, scene.perching_areas)


def _group_path(objects: Mapping[int, SceneObject], object_id: int) -> str:
    """Entity of the nearest coarse object that an object is or belongs to, below its parents."""
    chain: list[str] = []
    next_id: int | None = object_id
    while next_id is not None and next_id in objects:
        member = objects[next_id]
        if member.is_coarse:
            chain.append(f"{member.category}_{member.id}")
        next_id = member.parent_id
    return "/".join([layout.SCENE, *reversed(chain)]) if chain else f"{layout.SCENE}/terrain"


def _log_group(
    stream: rr.RecordingStream,
    path: str,
    members: Sequence[Primitive],
    categories: Mapping[int, int],
) -> None:
    kinds: dict[str, list[Primitive]] = defaultdict(list)
    for primitive in members:
        kinds[primitive.kind].append(primitive)
    for kind, batch in kinds.items():
        class_ids = [categories.get(p.object_id, 0) for p in batch]
        stream.log(f"{path}/{kind}", _BATCHES[kind](batch, class_ids), static=True)


def _positions(batch: Sequence[Primitive]) -> Float[np.ndarray, "n 3"]:
    return np.array([p.position_enu_m for p in batch], dtype=np.float32)


def _sizes(batch: Sequence[Primitive]) -> Float[np.ndarray, "n 3"]:
    return np.array([p.size_m for p in batch], dtype=np.float32)


def _quats_xyzw(batch: Sequence[Primitive]) -> Float[np.ndarray, "n 4"]:
    return np.roll(np.array([p.quat_wxyz for p in batch], dtype=np.float32), -1, axis=1)


def _colours(batch: Sequence[Primitive]) -> Int[np.ndarray, "n 4"]:
    rgba = np.array([MATERIALS[p.material].rgba for p in batch])
    return np.round(255 * rgba).astype(np.uint8)


def _boxes(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Boxes3D:
    return rr.Boxes3D(
        centers=_positions(batch),
        half_sizes=_sizes(batch) / 2,
        quaternions=_quats_xyzw(batch),
        colors=_colours(batch),
        class_ids=class_ids,
        fill_mode="solid",
        show_labels=False,
    )


def _cylinders(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Cylinders3D:
    sizes = _sizes(batch)
    return rr.Cylinders3D(
        centers=_positions(batch),
        radii=sizes[:, :2].max(axis=1) / 2,
        lengths=sizes[:, 2],
        quaternions=_quats_xyzw(batch),
        colors=_colours(batch),
        class_ids=class_ids,
        fill_mode="solid",
        show_labels=False,
    )


def _ellipsoids(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Ellipsoids3D:
    return rr.Ellipsoids3D(
        centers=_positions(batch),
        half_sizes=_sizes(batch) / 2,
        quaternions=_quats_xyzw(batch),
        colors=_colours(batch),
        class_ids=class_ids,
        fill_mode="solid",
        show_labels=False,
    )


def _meshes(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Mesh3D:
    """All convex hulls of the batch as one mesh with flat faces."""
    corners: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    colours: list[np.ndarray] = []
    for primitive, rgba in zip(batch, _colours(batch), strict=True):
        triangles = hull_triangles(np.asarray(primitive.vertices_m, dtype=float))
        rotation = _rotation_matrix(primitive.quat_wxyz)
        placed = triangles @ rotation.T + np.array(primitive.position_enu_m)
        normal = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        corners.append(placed.reshape(-1, 3))
        normals.append(np.repeat(normal, 3, axis=0))
        colours.append(np.tile(rgba, (3 * len(triangles), 1)))
    return rr.Mesh3D(
        vertex_positions=np.concatenate(corners).astype(np.float32),
        vertex_normals=np.concatenate(normals).astype(np.float32),
        vertex_colors=np.concatenate(colours),
        class_ids=class_ids[:1],
    )


_BATCHES = {"box": _boxes, "cylinder": _cylinders, "ellipsoid": _ellipsoids, "mesh": _meshes}


def hull_triangles(vertices_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3 3"]:
    """Triangles of a convex hull, counter-clockwise seen from outside."""
    from scipy.spatial import ConvexHull  # noqa: PLC0415 - a third of a second to import

    hull = ConvexHull(vertices_m)
    triangles = vertices_m[hull.simplices]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    is_inward = np.sum(normal * hull.equations[:, :3], axis=1) < 0
    triangles[is_inward] = triangles[is_inward][:, ::-1]
    return triangles


def _rotation_matrix(quat_wxyz: Sequence[float]) -> Float[np.ndarray, "3 3"]:
    w, x, y, z = quat_wxyz
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _log_ground(stream: rr.RecordingStream, scene: Scene) -> None:
    (west, south, _), (east, north, _) = scene.extent_min_enu_m, scene.extent_max_enu_m
    west, south = west - _GROUND_MARGIN_M, south - _GROUND_MARGIN_M
    east, north = east + _GROUND_MARGIN_M, north + _GROUND_MARGIN_M
    corners = [(west, south), (east, south), (east, north), (west, north)]
    stream.log(
        layout.GROUND,
        rr.Mesh3D(
            vertex_positions=[(x, y, _GROUND_HEIGHT_M) for x, y in corners],
            triangle_indices=[[0, 1, 2], [0, 2, 3]],
            vertex_normals=[(0.0, 0.0, 1.0)] * 4,
            vertex_colors=[_GROUND_RGB] * 4,
        ),
        static=True,
    )


def _log_areas(
    stream: rr.RecordingStream,
    path: str,
    rgb: tuple[int, int, int],
    areas: Sequence[InteractionArea],
) -> None:
    if not areas:
        return
    lifted = [np.array(a.polygon) + np.array((0.0, 0.0, _AREA_LIFT_M)) for a in areas]
    stream.log(
        f"{path}/outline",
        rr.LineStrips3D(
            [np.vstack([polygon, polygon[:1]]) for polygon in lifted],
            colors=[rgb] * len(areas),
            radii=0.03,
            labels=[f"{a.kind} {a.drone_class} {a.id}" for a in areas],
            show_labels=False,
        ),
        static=True,
    )
    triangles = np.concatenate([polygon_triangles(polygon) for polygon in lifted])
    n_corners = 3 * len(triangles)
    stream.log(
        f"{path}/fill",
        rr.Mesh3D(
            vertex_positions=triangles.reshape(-1, 3).astype(np.float32),
            vertex_normals=[(0.0, 0.0, 1.0)] * n_corners,
            albedo_factor=(*rgb, _AREA_FILL_ALPHA),
        ),
        static=True,
    )


def polygon_triangles(polygon_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3 3"]:
    """Triangles that fill a simple polygon; each keeps the heights of its corners."""
    import shapely  # noqa: PLC0415 - only recordings triangulate

    footprint = shapely.Polygon(polygon_enu_m[:, :2])
    pieces = shapely.get_parts(shapely.constrained_delaunay_triangles(footprint))
    height_m = {tuple(corner[:2]): corner[2] for corner in polygon_enu_m}
    mean_m = float(polygon_enu_m[:, 2].mean())
    return np.array(
        [
            [(x, y, height_m.get((x, y), mean_m)) for x, y in piece.exterior.coords[:3]]
            for piece in pieces
        ]
    ).reshape(-1, 3, 3)
