"""The scene in a recording: primitives in batches by coarse object, ground, areas.

A scene has thousands of primitives, and an entity for each would make the viewer slow. They are
therefore grouped by the coarse object that they belong to, such as a building or a room, and by
their kind. The tree of entities in the viewer is then the tree of coarse objects, and a user can
hide a storey with one click.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr
from jaxtyping import Float, Num
from scipy.spatial.transform import Rotation

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

_GROUND_REACH_M = 100.0
_GROUND_HEIGHT_M = -0.02
"""Height of the drawn ground, just below zero, where floors and roads lie."""
_AREA_LIFT_M = 0.04
"""Height of a drawn landing area above its surface, so that the two do not flicker."""
_AREA_FILL_ALPHA = 110


def log_scene(stream: rr.RecordingStream, scene: Scene, primitives: Iterable[Primitive]) -> None:
    """Write everything about the scene that never changes.

    Args:
        stream: Recording.
        scene: Scene with its areas and its surroundings.
        primitives: Shapes of its objects, each with the object's id.
    """
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
    """Return the entity of the coarse object that an object is or belongs to."""
    chain: list[str] = []
    next_id: int | None = object_id
    while next_id is not None and next_id in objects:
        member = objects[next_id]
        if member.is_coarse:
            chain.append(f"{member.category}_{member.id}")
        next_id = member.parent_id
    return "/".join([layout.SCENE, *reversed(chain)]) if chain else f"{layout.SCENE}/terrain"


def _log_group(
    stream: rr.RecordingStream, path: str, members: list[Primitive], categories: Mapping[int, int]
) -> None:
    kinds: dict[str, list[Primitive]] = defaultdict(list)
    for primitive in members:
        kinds[primitive.kind].append(primitive)
    for kind, batch in kinds.items():
        class_ids = [categories.get(p.object_id, 0) for p in batch]
        stream.log(f"{path}/{kind}", _BATCHES[kind](batch, class_ids), static=True)


def _placed(batch: Sequence[Primitive], class_ids: Sequence[int]) -> dict[str, Any]:
    """Return poses, colours and classes of a batch, as rerun's arguments."""
    rgba = np.array([MATERIALS[p.material].rgba for p in batch])
    return {
        "centers": np.array([p.position_enu_m for p in batch], dtype=np.float32),
        # rerun's quaternions have the scalar part last.
        "quaternions": np.roll(
            np.array([p.quat_wxyz for p in batch], dtype=np.float32), -1, axis=1
        ),
        "colors": np.round(255 * rgba).astype(np.uint8),
        "class_ids": class_ids,
        "fill_mode": "solid",
        "show_labels": False,
    }


def _sizes(batch: Sequence[Primitive]) -> Float[np.ndarray, "n 3"]:
    return np.array([p.size_m for p in batch], dtype=np.float32)


def _boxes(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Boxes3D:
    return rr.Boxes3D(half_sizes=_sizes(batch) / 2, **_placed(batch, class_ids))


def _cylinders(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Cylinders3D:
    size = _sizes(batch)
    # rerun's cylinders are round, so an elliptic one takes its larger radius.
    return rr.Cylinders3D(
        radii=size[:, :2].max(axis=1) / 2, lengths=size[:, 2], **_placed(batch, class_ids)
    )


def _ellipsoids(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Ellipsoids3D:
    return rr.Ellipsoids3D(half_sizes=_sizes(batch) / 2, **_placed(batch, class_ids))


def _meshes(batch: Sequence[Primitive], class_ids: Sequence[int]) -> rr.Mesh3D:
    """Return all convex hulls of the batch as one mesh with flat faces."""
    hulls = [
        Rotation.from_quat(p.quat_wxyz, scalar_first=True).apply(
            hull_triangles(np.asarray(p.vertices_m, dtype=float)).reshape(-1, 3)
        )
        + p.position_enu_m
        for p in batch
    ]
    rgba = [MATERIALS[p.material].rgba for p in batch]
    # A hull has three corners for each of its triangles, and each triangle one colour.
    colours = np.repeat(np.round(255 * np.array(rgba)), [len(h) // 3 for h in hulls], axis=0)
    # The class of the first hull stands for all: rerun has no class for a part of a mesh.
    return flat_mesh(np.concatenate(hulls).reshape(-1, 3, 3), colours, class_ids=class_ids[:1])


def flat_mesh(
    corners_m: Float[np.ndarray, "t 3 3"], colours: Num[np.ndarray, "t c"], **more: Any
) -> rr.Mesh3D:
    """Return a mesh of triangles, each of one colour and lit as a flat face.

    Args:
        corners_m: Corners of each triangle, counter-clockwise seen from outside.
        colours: Colour of each triangle, 0 to 255, with or without opacity.
        more: Further arguments of `rerun.Mesh3D`.
    """
    # Corners are not shared: a shared corner would have one normal, and edges would look round.
    normals = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    # The floor keeps triangles without an area from dividing by zero.
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return rr.Mesh3D(
        vertex_positions=corners_m.reshape(-1, 3).astype(np.float32),
        vertex_normals=np.repeat(normals, 3, axis=0).astype(np.float32),
        vertex_colors=np.repeat(colours.astype(np.uint8), 3, axis=0),
        **more,
    )


_BATCHES = {"box": _boxes, "cylinder": _cylinders, "ellipsoid": _ellipsoids, "mesh": _meshes}


def hull_triangles(vertices_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3 3"]:
    """Return the triangles of a convex hull, counter-clockwise seen from outside.

    Args:
        vertices_m: Points, at least four that are not in one plane.
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(vertices_m)
    triangles = vertices_m[hull.simplices]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    # Qhull's triangles turn either way, but its plane equations have outward normals.
    is_inward = np.sum(normal * hull.equations[:, :3], axis=1) < 0
    triangles[is_inward] = triangles[is_inward][:, ::-1]
    return triangles


def _log_ground(stream: rr.RecordingStream, scene: Scene) -> None:
    """Write ground and surroundings of the site, each paint with its texture, just below floors."""
    # Only writing a scene loads textures; reading a recording does not.
    from aeroscene.neighbourhood import neighbours_of
    from flightsim.looks.mesh import MeshBuilder
    from flightsim.looks.neighbours import add_neighbours
    from flightsim.looks.skins import skins
    from flightsim.looks.surroundings import add_surroundings
    from flightsim.looks.textures import tile

    builder = MeshBuilder(scene.relief)
    add_surroundings(builder, scene, _GROUND_REACH_M)
    add_neighbours(builder, neighbours_of(scene))
    for number, skin in enumerate(skins(builder.mesh())):
        texture = skin.paint.texture
        picture = None if texture is None else tile(texture, skin.paint.rgb)
        ground = rr.Mesh3D(
            vertex_positions=skin.vertices_enu_m + np.array((0.0, 0.0, _GROUND_HEIGHT_M)),
            triangle_indices=skin.triangles,
            vertex_normals=skin.normals,
            vertex_texcoords=skin.texture_tiles,
            albedo_texture=picture,
            albedo_factor=skin.paint.rgb if picture is None else None,
        )
        stream.log(f"{layout.GROUND}/{number}", ground, static=True)


def _log_areas(
    stream: rr.RecordingStream, path: str, rgb: tuple[int, ...], areas: Sequence[InteractionArea]
) -> None:
    if not areas:
        return
    lifted = [np.array(a.polygon) + np.array((0.0, 0.0, _AREA_LIFT_M)) for a in areas]
    outlines = rr.LineStrips3D(
        [np.vstack([polygon, polygon[:1]]) for polygon in lifted],
        colors=[rgb] * len(areas),
        radii=0.03,
        labels=[f"{a.kind} {a.drone_class} {a.id}" for a in areas],
        show_labels=False,
    )
    stream.log(f"{path}/outline", outlines, static=True)
    triangles = np.concatenate([polygon_triangles(polygon) for polygon in lifted])
    fill = rr.Mesh3D(
        vertex_positions=triangles.reshape(-1, 3).astype(np.float32),
        # Lit as a level face, whatever its slope.
        vertex_normals=[(0.0, 0.0, 1.0)] * (3 * len(triangles)),
        albedo_factor=(*rgb, _AREA_FILL_ALPHA),
    )
    stream.log(f"{path}/fill", fill, static=True)


def polygon_triangles(polygon_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3 3"]:
    """Return the triangles that fill a simple polygon; each keeps the heights of its corners.

    Args:
        polygon_enu_m: Corners in order, without a repeated first one; it may be concave.
    """
    import shapely

    # Shapely triangulates in the plane, so heights are looked up by corner afterwards.
    footprint = shapely.Polygon(polygon_enu_m[:, :2])
    pieces = shapely.get_parts(shapely.constrained_delaunay_triangles(footprint))
    height_m = {tuple(corner[:2]): corner[2] for corner in polygon_enu_m}
    mean_m = float(polygon_enu_m[:, 2].mean())
    corners = [corner for piece in pieces for corner in piece.exterior.coords[:3]]
    lifted = [(x, y, height_m.get((x, y), mean_m)) for x, y in corners]
    return np.array(lifted).reshape(-1, 3, 3)
