"""Baked light in the skins, for renderers that only multiply: sun, shadows, sky and lamps.

The static world and the sun never change, so light is computed once when a world is drawn first.
Large flat faces get shadows with exact edges, laid over them as triangles; small and round ones are
shaded by vertex.

The triangles laid over faces are layers of light. They lie 4 mm above their faces, so that cameras
take colours from them, but depth from the surfaces below: depth is the same in every light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Relief
from aeroscene.scene.relief import ground_m
from aeroscene.solids.shapes import Primitive
from flightsim.looks.lamps import Lamps, lamp_places
from flightsim.looks.light import AFTERNOON, Light
from flightsim.looks.mesh import WorldMesh
from flightsim.looks.rays import RayScene
from flightsim.looks.shadows import Shadows, cast, casters
from flightsim.looks.surfaces import rotation_enu
from flightsim.looks.tessellation import unit_box
from flightsim.looks.weather.sun import Direction

_LARGE_FACE_M2 = 4.0
"""Area above which faces get shadows with edges; smaller ones are shaded per corner."""
# Smaller or thinner solids cast no shadow that a camera would show.
_LEAST_CASTER_M = 0.5
_LEAST_CASTER_WIDTH_M = 0.04
_OFF_SURFACE_M = 0.02  # start of rays before a surface, so that it does not hide itself
_LEVEL = 0.999  # upward part of a level face's normal, at least
_POOL_FACE_M2 = 25.0
"""Area of level faces above which lamps have pools; markings may lie on smaller ones."""
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


@dataclass(frozen=True, eq=False)
class LitMesh:
    """A world in some light."""

    surfaces: WorldMesh
    """The mesh with light in its normals; every vertex is where it was."""
    layers: WorldMesh
    """Shadows and pools of lamplight, just above the surfaces; they have colours but no depth."""


def lit(
    mesh: WorldMesh,
    solids: Sequence[Primitive],
    relief: Relief | None = None,
    light: Light = AFTERNOON,
) -> LitMesh:
    """Return the mesh with light in its normals, and the layers of light over it.

    Args:
        mesh: Mesh of the whole world, with true normals.
        solids: Solids that cast shadows.
        relief: Height of the ground; without it the ground is the plane z = 0.
        light: Sun and sky.
    """
    face_of = _face_of_vertex(mesh)
    rings = _rings(mesh)
    normals = mesh.normals_enu
    middles, areas_m2 = _middles_and_areas(mesh, rings)
    face_normals = normals[mesh.face_first]
    above_m = middles[:, 2] - ground_m(relief, middles[:, 0], middles[:, 1])
    sky = _sky_share(mesh, face_of, middles, areas_m2, above_m)
    is_exact = (areas_m2 > _LARGE_FACE_M2) & light.is_sunward(face_normals)
    is_shown = ~np.array([paint.is_clear for paint in mesh.paints], dtype=bool)[mesh.face_paint]
    exact = np.flatnonzero(is_exact & is_shown)
    corners = np.concatenate([np.zeros(0, dtype=int), *(rings[f] for f in exact)])
    shadows = cast(
        casters(_casters(solids, light.sun_direction), light.sun_direction),
        mesh.vertices_enu_m[corners],
        np.repeat(np.arange(len(exact)), mesh.face_count[exact]),
        face_normals[exact],
        is_ground_level=relief is None,
    )
    sun = _sun_at_vertices(mesh, face_of, middles, light)
    is_of_exact = np.isin(face_of, exact)
    whole = exact[shadows.is_whole]
    # Faces with exact shadows are lit wholly here; the layer darkens parts of them.
    sun[is_of_exact] = 1.0
    sun[np.isin(face_of, whole)] = 0.0
    number = light.surface(normals, sun, sky) * _mottling(mesh)
    lamps = open_lamps(mesh, solids, relief) if light.is_dark else None
    if lamps is not None:
        number = np.minimum(1.0, number + lamps.light_at(mesh.vertices_enu_m, normals))
    number[mesh.triangles[mesh.is_lamp()]] = _LAMP_LIGHT
    base = replace(mesh, normals_enu=light.normals(number))
    if lamps is not None:
        return LitMesh(base, _pools(mesh, areas_m2, sky, lamps, light))
    return LitMesh(base, _shadow_layer(mesh, exact, shadows, sky, light))


def open_lamps(mesh: WorldMesh, solids: Sequence[Primitive], relief: Relief | None = None) -> Lamps:
    """Return the lamps that have no roof above them.

    Args:
        mesh: Mesh of the whole world, with true normals.
        solids: Solids, of which some are lamps.
        relief: Height of the ground; without it the ground is the plane z = 0.
    """
    places = lamp_places(solids)
    middles, areas_m2 = _middles_and_areas(mesh, _rings(mesh))
    above_m = middles[:, 2] - ground_m(relief, middles[:, 0], middles[:, 1])
    roofs = _roofs(mesh, _face_of_vertex(mesh), areas_m2, above_m)
    places = places[_free_share(roofs, places) > 0.5]
    return Lamps(places, places[:, 2] - ground_m(relief, places[:, 0], places[:, 1]))


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
    roofs = _roofs(mesh, face_of, areas_m2, above_m)
    face_normals = mesh.normals_enu[mesh.face_first]
    of_faces = _free_share(roofs, middles + _UNDER_ROOF_M * face_normals)
    is_round = face_of < 0
    share = np.ones(len(face_of))
    share[~is_round] = of_faces[face_of[~is_round]]
    share[is_round] = _free_share(roofs, mesh.vertices_enu_m[is_round])
    return share


def _roofs(
    mesh: WorldMesh, face_of: np.ndarray, areas_m2: np.ndarray, above_m: np.ndarray
) -> RayScene:
    """Large faces high above the ground that are not upright."""
    is_roof = (areas_m2 > _ROOF_M2) & (np.abs(mesh.normals_enu[mesh.face_first][:, 2]) > 0.5)
    is_roof &= above_m > 1.5
    face = face_of[mesh.triangles[:, 0]]
    is_cover = face >= 0
    is_cover[is_cover] = is_roof[face[is_cover]]
    return RayScene(mesh.corners_enu_m()[is_cover & ~mesh.is_clear()])


def _free_share(roofs: RayScene, points: np.ndarray) -> np.ndarray:
    free = [~roofs.is_hidden(points, np.broadcast_to(ray, points.shape)) for ray in _SKY_RAYS]
    return np.mean(free, axis=0)


def _sun_at_vertices(
    mesh: WorldMesh, face_of: np.ndarray, middles: np.ndarray, light: Light
) -> np.ndarray:
    """Visibility of the sun from each vertex, (v,): 0 or 1."""
    points = mesh.vertices_enu_m + _OFF_SURFACE_M * mesh.normals_enu
    is_flat = face_of >= 0
    # Corners lie on edges, where neighbouring faces would hide them: a tenth inwards.
    points[is_flat] += 0.1 * (middles[face_of[is_flat]] - points[is_flat])
    occluders = RayScene(mesh.corners_enu_m()[~mesh.is_clear()])
    sun = np.zeros(len(points))
    ahead = np.flatnonzero(light.is_sunward(mesh.normals_enu))
    towards = np.broadcast_to(light.to_sun, (len(ahead), 3))
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


def _casters(solids: Sequence[Primitive], sun_direction: Direction) -> list[np.ndarray]:
    return [
        _caster_corners(solid, sun_direction)
        for solid in solids
        if max(solid.size_m) >= _LEAST_CASTER_M
        and sorted(solid.size_m)[1] >= _LEAST_CASTER_WIDTH_M
        # Paint on the ground is thinner than this and casts nothing.
        and min(solid.size_m) > 0.011
        and solid.material != "glass"
    ]


def _caster_corners(solid: Primitive, sun_direction: Direction) -> np.ndarray:
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
    return _terminator(half_m, turn, sun_direction) + middle


def _terminator(half_m: np.ndarray, turn: np.ndarray, sun_direction: Direction) -> np.ndarray:
    """Terminator on an ellipsoid at the origin, (16, 3): the border between light and shade."""
    # On the unit sphere the terminator is a circle; scaling the sphere turns the sunlight.
    pole = (np.array(sun_direction) @ turn) / half_m
    pole /= np.linalg.norm(pole)
    u = np.cross(pole, np.eye(3)[np.abs(pole).argmin()])
    u /= np.linalg.norm(u)
    circle = np.cos(_CIRCLE)[:, None] * u + np.sin(_CIRCLE)[:, None] * np.cross(pole, u)
    return (circle * half_m) @ turn.T


def _shadow_layer(
    mesh: WorldMesh, exact: np.ndarray, shadows: Shadows, sky: np.ndarray, light: Light
) -> WorldMesh:
    """Shadows as triangles in the paint of the faces below them."""
    own, corners = exact[shadows.face], shadows.corners_enu_m
    first = mesh.face_first[own]
    normals = mesh.normals_enu[first]
    number = light.surface(normals, np.zeros(len(own)), sky[first])
    return _laid_over(mesh, own, corners, np.repeat(light.normals(number), 3, axis=0))


def _pools(
    mesh: WorldMesh, areas_m2: np.ndarray, sky: np.ndarray, lamps: Lamps, light: Light
) -> WorldMesh:
    """Return pools of lamplight on large level faces.

    The corners of such a face are too far apart to show a pool.
    """
    is_level = mesh.normals_enu[mesh.face_first][:, 2] > _LEVEL
    large = np.flatnonzero(is_level & (areas_m2 > _POOL_FACE_M2))
    rings = _rings(mesh)
    face, corners = lamps.pools([mesh.vertices_enu_m[rings[f]] for f in large])
    own = large[face]
    first = mesh.face_first[own]
    normals = np.repeat(mesh.normals_enu[first], 3, axis=0)
    flat = corners.reshape(-1, 3)
    dark = light.surface(normals, np.zeros(len(flat)), np.repeat(sky[first], 3))
    number = np.minimum(1.0, dark + lamps.light_at(flat, normals))
    return _laid_over(mesh, own, corners, light.normals(number))


def _laid_over(
    mesh: WorldMesh, faces: np.ndarray, corners: np.ndarray, normals: np.ndarray
) -> WorldMesh:
    """Return triangles (t, 3, 3) in the paint of the faces below them, (t,)."""
    n = len(faces)
    return WorldMesh(
        mesh.paints,
        corners.reshape(-1, 3),
        normals,
        _tiles_on_faces(mesh, mesh.face_first[faces], corners).reshape(-1, 2),
        np.arange(3 * n, dtype=np.int32).reshape(-1, 3),
        mesh.face_paint[faces],
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
