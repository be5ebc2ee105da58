"""Baked light in the skins, for renderers that only multiply: sun, shadows, sky and lamps.

The static world and the sun never change, so light is computed once when a world is drawn first.
Large flat faces get shadows with exact edges, laid over them as triangles; small and round ones are
shaded by vertex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Relief
from aeroscene.scene.relief import ground_m
from aeroscene.solids.shapes import Primitive
from flightsim.looks.light import SUN_DIRECTION, is_sunward, normals_for_light, surface_light
from flightsim.looks.mesh import WorldMesh
from flightsim.looks.rays import RayScene
from flightsim.looks.shadows import cast, casters
from flightsim.looks.surfaces import rotation_enu
from flightsim.looks.tessellation import unit_box

_LARGE_FACE_M2 = 4.0
"""Area above which faces get shadows with edges; smaller ones are shaded per corner."""
# Smaller or thinner solids cast no shadow that a camera would show.
_LEAST_CASTER_M = 0.5
_LEAST_CASTER_WIDTH_M = 0.04
_OFF_SURFACE_M = 0.02  # start of rays before a surface, so that it does not hide itself
_LAMP_LIGHT = 0.9  # light of lamps, almost the brightest
_ROOF_M2 = 6.0  # least area of a face that counts as a roof
_UNDER_ROOF_M = 0.25
"""Distance before a face at which to test whether it is indoors."""
# Straight up and four slanting directions, 42 degrees above the horizon.
_SKY_RAYS = np.array(
    [(0.0, 0.0, 1.0), *((0.74 * c, 0.74 * s, 0.67) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1)))]
)
# Sixteen points of a circle, and ten for cylinders; the last equals the first and is left out.
_CIRCLE = np.linspace(0.0, 2 * np.pi, 17)[:-1]
_DECAGON = np.linspace(0.0, 2 * np.pi, 11)[:-1]


def lit(mesh: WorldMesh, solids: Sequence[Primitive], relief: Relief | None = None) -> WorldMesh:
    """Return the mesh with shadows on it and light in its normals.

    Args:
        mesh: Mesh of the whole world, with true normals.
        solids: Solids that cast shadows.
        relief: Height of the ground; without it the ground is the plane z = 0.
    """
    face_of = _face_of_vertex(mesh)
    rings = _rings(mesh)
    normals = mesh.normals_enu
    middles, areas_m2 = _middles_and_areas(mesh, rings)
    face_normals = normals[mesh.face_first]
    above_m = middles[:, 2] - ground_m(relief, middles[:, 0], middles[:, 1])
    sky = _sky_share(mesh, face_of, middles, areas_m2, above_m)
    is_exact = (areas_m2 > _LARGE_FACE_M2) & is_sunward(face_normals)
    is_shown = ~np.array([paint.is_clear for paint in mesh.paints], dtype=bool)[mesh.face_paint]
    exact = np.flatnonzero(is_exact & is_shown)
    corners = np.concatenate([np.zeros(0, dtype=int), *(rings[f] for f in exact)])
    shadows = cast(
        casters(_casters(solids)),
        mesh.vertices_enu_m[corners],
        np.repeat(np.arange(len(exact)), mesh.face_count[exact]),
        face_normals[exact],
        is_ground_level=relief is None,
    )
    sun = _sun_at_vertices(mesh, face_of, middles)
    is_of_exact = np.isin(face_of, exact)
    whole = exact[shadows.is_whole]
    # Faces with exact shadows are lit wholly here; the overlay darkens parts of them.
    sun[is_of_exact] = 1.0
    sun[np.isin(face_of, whole)] = 0.0
    light = surface_light(normals, sun, sky) * _mottling(mesh)
    light[mesh.triangles[mesh.is_lamp()]] = _LAMP_LIGHT
    base = replace(mesh, normals_enu=normals_for_light(light))
    return base.with_overlay(_overlay(mesh, exact, shadows.face, shadows.corners_enu_m, sky))


def _face_of_vertex(mesh: WorldMesh) -> np.ndarray:
    """Index of the flat face of each vertex, -1 on round shapes."""
    face = np.full(len(mesh.vertices_enu_m), -1, dtype=np.int32)
    for index in range(int(mesh.face_count.max(initial=0))):
        has = mesh.face_count > index
        face[mesh.face_first[has] + index] = np.flatnonzero(has)
    return face


def _rings(mesh: WorldMesh) -> list[np.ndarray]:
    return [
        np.arange(first, first + count)
        for first, count in zip(mesh.face_first.tolist(), mesh.face_count.tolist(), strict=True)
    ]


def _middles_and_areas(
    mesh: WorldMesh, rings: list[np.ndarray]
) -> tuple[Float[np.ndarray, "f 3"], Float[np.ndarray, " f"]]:
    """Centres of flat faces, by their corners, and their areas, m^2."""
    n_faces = len(rings)
    face = np.repeat(np.arange(n_faces), mesh.face_count)
    members = np.concatenate(rings) if rings else np.zeros(0, dtype=int)
    points = mesh.vertices_enu_m[members]
    middles = (
        np.stack([np.bincount(face, points[:, k], n_faces) for k in range(3)], axis=1)
        / np.maximum(mesh.face_count, 1)[:, None]
    )
    following = members + 1
    is_last = np.append(face[1:] != face[:-1], True)[: len(members)]
    following[is_last] = mesh.face_first[face[is_last]]
    # Twice the areas of the triangles between the centre and each edge.
    twice = np.cross(points - middles[face], mesh.vertices_enu_m[following] - middles[face])
    areas = np.bincount(face, np.linalg.norm(twice, axis=1), n_faces) / 2
    return middles, areas


def _sky_share(
    mesh: WorldMesh,
    face_of: np.ndarray,
    middles: np.ndarray,
    areas_m2: np.ndarray,
    above_m: np.ndarray,
) -> np.ndarray:
    """Share of the sky not hidden by roofs, (v,): the same for all corners of a flat face.

    `above_m` is the height of the faces' middles above the ground.
    """
    is_roof = (areas_m2 > _ROOF_M2) & (np.abs(mesh.normals_enu[mesh.face_first][:, 2]) > 0.5)
    is_roof &= above_m > 1.5
    face = face_of[mesh.triangles[:, 0]]
    is_cover = face >= 0
    is_cover[is_cover] = is_roof[face[is_cover]]
    roofs = RayScene(mesh.corners_enu_m()[is_cover & ~mesh.is_clear()])
    face_normals = mesh.normals_enu[mesh.face_first]
    of_faces = _free_share(roofs, middles + _UNDER_ROOF_M * face_normals)
    is_round = face_of < 0
    share = np.ones(len(face_of))
    share[~is_round] = of_faces[face_of[~is_round]]
    share[is_round] = _free_share(roofs, mesh.vertices_enu_m[is_round])
    return share


def _free_share(roofs: RayScene, points: np.ndarray) -> np.ndarray:
    free = [~roofs.is_hidden(points, np.broadcast_to(ray, points.shape)) for ray in _SKY_RAYS]
    return np.mean(free, axis=0)


def _sun_at_vertices(mesh: WorldMesh, face_of: np.ndarray, middles: np.ndarray) -> np.ndarray:
    """Visibility of the sun from each vertex, (v,): 0 or 1."""
    points = mesh.vertices_enu_m + _OFF_SURFACE_M * mesh.normals_enu
    is_flat = face_of >= 0
    # Corners lie on edges, where neighbouring faces would hide them: a tenth inwards.
    points[is_flat] += 0.1 * (middles[face_of[is_flat]] - points[is_flat])
    occluders = RayScene(mesh.corners_enu_m()[~mesh.is_clear()])
    sun = np.zeros(len(points))
    ahead = np.flatnonzero(is_sunward(mesh.normals_enu))
    towards = np.broadcast_to(-np.array(SUN_DIRECTION), (len(ahead), 3))
    sun[ahead] = ~occluders.is_hidden(points[ahead], towards)
    return sun


def _mottling(mesh: WorldMesh) -> np.ndarray:
    """Light factor of each vertex: tree crowns have light and dark parts."""
    is_leaves = np.array([paint.texture == "leaves" for paint in mesh.paints], dtype=bool)
    factor = np.ones(len(mesh.vertices_enu_m))
    leafy = is_leaves[mesh.vertex_paint()]
    # A spatial wave: neighbouring crowns differ, and a crown has no visible seam.
    x, y, z = 3.1 * mesh.vertices_enu_m[leafy].T
    factor[leafy] = 0.86 + 0.22 * np.sin(x + 1.7 * np.sin(z)) * np.cos(y - 1.3 * np.sin(x))
    return factor


def _casters(solids: Sequence[Primitive]) -> list[np.ndarray]:
    return [
        _caster_corners(solid)
        for solid in solids
        if max(solid.size_m) >= _LEAST_CASTER_M
        and sorted(solid.size_m)[1] >= _LEAST_CASTER_WIDTH_M
        # Paint on the ground is thinner than this and casts nothing.
        and min(solid.size_m) > 0.011
        and solid.material != "glass"
    ]


def _caster_corners(solid: Primitive) -> np.ndarray:
    """Points whose outline, seen from the sun, is that of the solid."""
    turn, middle = rotation_enu(solid), np.array(solid.position_enu_m)
    half_m = np.array(solid.size_m) / 2
    if solid.kind == "mesh":
        return np.array(solid.vertices_m) @ turn.T + middle
    if solid.kind == "box":
        corners, _, _, _ = unit_box()
        return (2 * corners[:8] * half_m) @ turn.T + middle
    if solid.kind == "cylinder":
        ring = np.stack([np.cos(_DECAGON), np.sin(_DECAGON), np.ones(10)], axis=1)
        both = np.concatenate([ring, ring * (1.0, 1.0, -1.0)])
        return (both * half_m) @ turn.T + middle
    return _terminator(half_m, turn) + middle


def _terminator(half_m: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Terminator on an ellipsoid at the origin, (16, 3): the border between light and shade."""
    # On the unit sphere the terminator is a circle; scaling the sphere turns the sunlight.
    pole = (np.array(SUN_DIRECTION) @ turn) / half_m
    pole /= np.linalg.norm(pole)
    u = np.cross(pole, np.eye(3)[np.abs(pole).argmin()])
    u /= np.linalg.norm(u)
    circle = np.cos(_CIRCLE)[:, None] * u + np.sin(_CIRCLE)[:, None] * np.cross(pole, u)
    return (circle * half_m) @ turn.T


def _overlay(
    mesh: WorldMesh, exact: np.ndarray, face: np.ndarray, corners: np.ndarray, sky: np.ndarray
) -> WorldMesh:
    """Shadows as triangles in the paint of the faces below them."""
    own = exact[face]
    first = mesh.face_first[own]
    normals = mesh.normals_enu[first]
    light = surface_light(normals, np.zeros(len(own)), sky[first])
    n = len(own)
    return WorldMesh(
        mesh.paints,
        corners.reshape(-1, 3),
        np.repeat(normals_for_light(light), 3, axis=0),
        _tiles_on_faces(mesh, first, corners).reshape(-1, 2),
        np.arange(3 * n, dtype=np.int32).reshape(-1, 3),
        mesh.face_paint[own],
        *(np.zeros(0, dtype=np.int32) for _ in range(3)),
    )


def _tiles_on_faces(mesh: WorldMesh, first: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Texture coordinates of points on flat faces, extrapolated from each face's first corners."""
    origin = mesh.vertices_enu_m[first]
    u, v = mesh.vertices_enu_m[first + 1] - origin, mesh.vertices_enu_m[first + 2] - origin
    # Least squares for the weights of both edges: the face's plane is spanned by them.
    uu, uv, vv = (np.einsum("ti,ti->t", a, b)[:, None] for a, b in ((u, u), (u, v), (v, v)))
    away = corners - origin[:, None]
    along_u = np.einsum("tki,ti->tk", away, u)
    along_v = np.einsum("tki,ti->tk", away, v)
    determinant = uu * vv - uv * uv
    s = (vv * along_u - uv * along_v) / determinant
    t = (uu * along_v - uv * along_u) / determinant
    tiles = mesh.texture_tiles
    du, dv = tiles[first + 1] - tiles[first], tiles[first + 2] - tiles[first]
    return tiles[first][:, None] + s[..., None] * du[:, None] + t[..., None] * dv[:, None]
