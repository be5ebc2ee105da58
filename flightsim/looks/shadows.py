"""Exact shadows of the sun on flat faces, as triangles to lay over them.

Seen from the sun, a solid hides everything that its outline covers and that lies behind it. So
shadows are plane geometry in the two coordinates across the sunlight: outlines of the casters, cut
to the part before the face's plane, united and intersected with the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float, Int

from flightsim.looks.weather.sun import Direction

_TOUCH_M = 0.03
"""Least reach of a caster before a face; with less it stands on the face or belongs to it."""
_LEVEL = 0.9999  # vertical part of a normal from which on a face counts as level
_GROUND_M = 0.35
"""Height up to which level faces are the ground or lie on it."""
_LEAST_AREA_M2 = 0.02  # smaller pieces of shadow are crumbs of rounding
_WHOLE_SHARE = 0.985  # share of a face from which on it counts as wholly in shadow
_LIFT_M = 0.004
"""Height of shadows above their faces: above the face, below paint on roads."""


@dataclass(frozen=True, eq=False)
class Casters:
    """Convex solids by their corners, each row padded with repeats."""

    corners_enu_m: Float[np.ndarray, "n k 3"]
    outlines: np.ndarray
    """Outlines (n,) as polygons across the sunlight."""
    across: Float[np.ndarray, "3 2"]
    """Projection from ENU to the coordinates across the sunlight, seen from the sun."""
    to_sun: Float[np.ndarray, " 3"]


@dataclass(frozen=True, eq=False)
class Shadows:
    """Shadows on some faces."""

    is_whole: np.ndarray
    """True if the whole face is in shadow, apart from crumbs, (f,) bool."""
    face: Int[np.ndarray, " t"]
    """Face of each triangle; faces wholly in shadow have none."""
    corners_enu_m: Float[np.ndarray, "t 3 3"]
    """Corners counter-clockwise from outside."""


def casters(solids: list[np.ndarray], sun_direction: Direction) -> Casters:
    """Prepare solids given by their corners, (k, 3) each, for a direction of sunlight."""
    to_sun = -np.array(sun_direction)
    # North takes the place of up where the sun stands in the zenith.
    east = np.cross((0.0, 1.0, 0.0) if to_sun[2] > 0.999 else (0.0, 0.0, 1.0), to_sun)
    east /= np.linalg.norm(east)
    across = np.stack([east, np.cross(to_sun, east)], axis=1)
    most = max((len(corners) for corners in solids), default=1)
    rows = [np.concatenate([c, np.repeat(c[:1], most - len(c), axis=0)]) for c in solids]
    corners = np.array(rows).reshape(-1, most, 3)
    return Casters(corners, _outlines(corners @ across), across, to_sun)


def cast(
    casters_: Casters,
    corners_enu_m: Float[np.ndarray, "c 3"],
    face_of_corner: Int[np.ndarray, " c"],
    normals_enu: Float[np.ndarray, "f 3"],
    *,
    is_ground_level: bool = True,
) -> Shadows:
    """Return shadows on faces that look towards the sun.

    Args:
        casters_: Solids that cast shadows; they may own some of the faces.
        corners_enu_m: Corners of the faces, ring by ring, counter-clockwise from outside.
        face_of_corner: Face of each corner, 0 to f - 1, ascending.
        normals_enu: Outward normals.
        is_ground_level: True if the ground is the plane z = 0, on which many faces share shadows.
    """
    rings = shapely.linearrings(corners_enu_m @ casters_.across, indices=face_of_corner)
    polygons = np.asarray(shapely.polygons(rings))
    _, first = np.unique(face_of_corner, return_index=True)
    offset = np.einsum("fi,fi->f", normals_enu, corners_enu_m[first])
    is_ground = (normals_enu[:, 2] > _LEVEL) & (offset < _GROUND_M) & is_ground_level
    ground, other = np.flatnonzero(is_ground), np.flatnonzero(~is_ground)
    on_ground, ground_shade = _on_ground(casters_, polygons[ground])
    on_other, other_shade = _on_planes(casters_, polygons[other], normals_enu[other], offset[other])
    face = np.concatenate([ground[on_ground], other[on_other]])
    shade = np.concatenate([ground_shade, other_shade])
    covered_m2 = np.bincount(face, shapely.area(shade), len(polygons))
    is_whole = covered_m2 > _WHOLE_SHARE * shapely.area(polygons)
    is_kept = ~is_whole[face] & (shapely.area(shade) > _LEAST_AREA_M2)
    piece, triangles = _triangles(shade[is_kept])
    of_face = face[is_kept][piece]
    return Shadows(
        is_whole, of_face, _lifted(casters_, triangles, normals_enu[of_face], offset[of_face])
    )


def _on_ground(casters_: Casters, polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shade on the many level faces near the ground, which share the same union of outlines.

    Kerbs and slabs cast none here, and the foot of a caster beside a slab is treated as if it stood
    on the slab: the error is a strip as wide as the slab is high.

    Returns:
        Indices in `polygons`, and the shaded part of each in any number of pieces.
    """
    stands = casters_.corners_enu_m[..., 2].max(axis=1) > _GROUND_M + _TOUCH_M
    parts = shapely.get_parts(shapely.union_all(casters_.outlines[stands]))
    face, part = shapely.STRtree(parts).query(polygons, predicate="intersects")
    return face, shapely.intersection(polygons[face], parts[part])


def _on_planes(
    casters_: Casters, polygons: np.ndarray, normals_enu: np.ndarray, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Shade on faces of any plane, as `_on_ground`."""
    # The tree finds pairs whose outlines overlap; most pairs are far apart.
    face, caster = shapely.STRtree(casters_.outlines).query(polygons, predicate="intersects")
    ahead_m = np.einsum("pki,pi->pk", casters_.corners_enu_m[caster], normals_enu[face])
    ahead_m -= offset[face][:, None]
    is_before = ahead_m.max(axis=1) > _TOUCH_M
    face, caster, ahead_m = face[is_before], caster[is_before], ahead_m[is_before]
    outlines = casters_.outlines[caster]
    is_cut = ahead_m.min(axis=1) < -_TOUCH_M
    outlines[is_cut] = _before_plane(casters_, caster[is_cut], ahead_m[is_cut])
    order = np.argsort(face, kind="stable")
    faces, starts = np.unique(face[order], return_index=True)
    groups = np.split(outlines[order], starts[1:]) if len(faces) else []
    united = [group[0] if len(group) == 1 else shapely.union_all(group) for group in groups]
    return faces, shapely.intersection(polygons[faces], np.array(united, dtype=object))


def _outlines(points: np.ndarray) -> np.ndarray:
    """Convex outlines of rows of points (n, k, 2)."""
    return np.asarray(shapely.convex_hull(shapely.linestrings(points)))


def _before_plane(casters_: Casters, some: np.ndarray, ahead_m: np.ndarray) -> np.ndarray:
    """Outlines of the parts of some casters before a plane, given their corners' distances.

    The cut passes through a point between each corner before the plane and each behind it.
    """
    if not len(some):
        return np.zeros(0, dtype=object)
    corners = casters_.corners_enu_m[some]
    across = corners @ casters_.across
    is_new = np.ones(ahead_m.shape, dtype=bool)
    is_new[:, 1:] = (corners[:, 1:] != corners[:, :1]).any(axis=2)
    is_before, is_behind = is_new & (ahead_m > 0), is_new & (ahead_m <= 0)
    row, i, j = np.nonzero(is_before[:, :, None] & is_behind[:, None, :])
    share = ahead_m[row, i] / (ahead_m[row, i] - ahead_m[row, j])
    cuts = across[row, i] + share[:, None] * (across[row, j] - across[row, i])
    own_row, own = np.nonzero(is_before)
    rows = np.concatenate([row, own_row])
    points = np.concatenate([cuts, across[own_row, own]])
    order = np.argsort(rows, kind="stable")
    return np.asarray(shapely.convex_hull(shapely.linestrings(points[order], indices=rows[order])))


def _triangles(shade: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles that fill polygons: the polygon's index, and corners (t, 3, 2)."""
    filled = shapely.constrained_delaunay_triangles(shade)
    parts, index = shapely.get_parts(filled, return_index=True)
    if not len(parts):
        return np.zeros(0, dtype=int), np.zeros((0, 3, 2))
    # A polygon repeats its first point at the end.
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area2 = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    corners[area2 < 0] = corners[area2 < 0][:, ::-1]
    # Slivers of rounding have no area.
    is_kept = np.abs(area2) > 1e-6
    return index[is_kept], corners[is_kept]


def _lifted(
    casters_: Casters, triangles: np.ndarray, normals: np.ndarray, offset: np.ndarray
) -> np.ndarray:
    """Corners across the sunlight projected back onto their faces, (t, 3, 3)."""
    aside = triangles @ casters_.across.T
    depth = offset[:, None] - np.einsum("tki,ti->tk", aside, normals)
    along = depth / (normals @ casters_.to_sun)[:, None]
    return aside + along[..., None] * casters_.to_sun + _LIFT_M * normals[:, None]
