"""Lamplight at night: what street lamps and headlights add to the light of points around them.

A lamp is a point that shines downwards. Its light falls with the square of the distance, as that of
any point does, and is softened below two metres so that posts and lamp heads do not burn out. Only
lamps under the open sky count, because rooms have their own light. Walls do not stop lamplight: a
wall between a lamp and a point is rare within the reach of a lamp, and a ray for each pair would
cost more than all shadows of the sun do by day.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from aeroscene.solids.shapes import Primitive

_REACH_M = 15.0
"""Distance beyond which a lamp adds nothing."""
_HIGH_M = 2.5
"""Height above the ground of street lamps and the like; lower ones belong to vehicles."""
_HIGH_BRIGHTNESS, _LOW_BRIGHTNESS = 34.0, 11.0
"""Light at one metre: a lamp 5 m high lights the ground below it nearly as the sun does."""
_SOFT_M2 = 4.0
_LEAST_FACING = 0.15
"""Share of a lamp's light that reaches faces which look away, by way of what is around."""
_RINGS_M = (0.0, 1.5, 3.0, 4.5, 6.5, 9.0, 12.0)
_N_SECTORS = 12
_LIFT_M = 0.004
"""Height of pools above their faces: above the face, below paint on roads."""
_UNDER_M = 12.0
"""Height of a lamp above a face that it still lights."""


class Lamps:
    """Lamps that shine on their surroundings."""

    def __init__(
        self, places_enu_m: Float[np.ndarray, "n 3"], above_m: Float[np.ndarray, " n"]
    ) -> None:
        """Place lamps, whose heights above the ground say how bright they are."""
        self._places_enu_m = places_enu_m
        self._brightness = np.where(above_m > _HIGH_M, _HIGH_BRIGHTNESS, _LOW_BRIGHTNESS)

    def light_at(
        self, points_enu_m: Float[np.ndarray, "n 3"], normals_enu: Float[np.ndarray, "n 3"]
    ) -> Float[np.ndarray, " n"]:
        """Light that all lamps add at points of surfaces."""
        light = np.zeros(len(points_enu_m))
        if not len(self._places_enu_m) or not len(points_enu_m):
            return light
        near = KDTree(points_enu_m).query_ball_point(self._places_enu_m, _REACH_M)
        for place, power, index in zip(self._places_enu_m, self._brightness, near, strict=True):
            to_lamp = place - points_enu_m[index]
            squared = np.einsum("ni,ni->n", to_lamp, to_lamp)
            facing = np.einsum("ni,ni->n", to_lamp, normals_enu[index])
            facing /= np.sqrt(np.maximum(squared, 1e-6))
            edge = np.clip(1.0 - squared / _REACH_M**2, 0.0, 1.0)
            share = np.maximum(facing, _LEAST_FACING)
            light[index] += power * share * edge / (squared + _SOFT_M2)
        return light

    def pools(
        self, faces_enu_m: Sequence[Float[np.ndarray, "k 3"]]
    ) -> tuple[Int[np.ndarray, " t"], Float[np.ndarray, "t 3 3"]]:
        """Triangles about the feet of lamps on level faces, fine enough to show how it fades.

        Args:
            faces_enu_m: Rings of corners, counter-clockwise from above.

        Returns:
            Index of the face of each triangle, and the corners, counter-clockwise from above.
        """
        none = np.zeros(0, dtype=np.int64), np.zeros((0, 3, 3))
        if not len(faces_enu_m) or not len(self._places_enu_m):
            return none
        polygons = np.array([shapely.Polygon(face[:, :2]) for face in faces_enu_m])
        level_m = np.array([face[0, 2] for face in faces_enu_m])
        lamp, cells = _cells(self._places_enu_m)
        cell, face = shapely.STRtree(polygons).query(cells, predicate="intersects")
        above_m = self._places_enu_m[lamp[cell], 2] - level_m[face]
        is_below = (above_m > 0.3) & (above_m < _UNDER_M)
        cell, face = cell[is_below], face[is_below]
        pieces = shapely.intersection(cells[cell], polygons[face])
        filled, piece = shapely.get_parts(
            shapely.constrained_delaunay_triangles(pieces), return_index=True
        )
        if not len(filled):
            return none
        flat = shapely.get_coordinates(filled).reshape(-1, 4, 2)[:, :3]
        u, v = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
        twice_m2 = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        flat[twice_m2 < 0] = flat[twice_m2 < 0][:, ::-1]
        is_kept = np.abs(twice_m2) > 1e-5
        own = face[piece[is_kept]]
        height = np.broadcast_to((level_m[own] + _LIFT_M)[:, None, None], (len(own), 3, 1))
        return own, np.concatenate([flat[is_kept], height], axis=2)


def lamp_places(solids: Sequence[Primitive]) -> Float[np.ndarray, "n 3"]:
    """Middles of all white lamps; coloured ones are signals, which light nothing."""
    lamps = [solid.position_enu_m for solid in solids if solid.material == "light_warm"]
    return np.array(lamps).reshape(-1, 3)


def _cells(places_enu_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sectors of rings about each lamp: the lamp of each, and the polygons."""
    angle = np.linspace(0.0, 2 * np.pi, _N_SECTORS + 1)
    inner, outer = np.array(_RINGS_M[:-1]), np.array(_RINGS_M[1:])
    c, s = np.cos(angle), np.sin(angle)
    corners = []
    for low, high in zip(inner, outer, strict=True):
        for k in range(_N_SECTORS):
            ring = [(low, k), (high, k), (high, k + 1), (low, k + 1)]
            corners.append([(r * c[j], r * s[j]) for r, j in ring])
    shape = np.array(corners)
    rings = places_enu_m[:, None, None, :2] + shape
    cells = np.asarray(shapely.polygons(rings.reshape(-1, 4, 2)))
    lamp = np.repeat(np.arange(len(places_enu_m)), len(shape))
    # Each place belongs to its nearest lamp: two layers of triangles at one height would flicker.
    cells = shapely.intersection(cells, _nearest_regions(places_enu_m[:, :2])[lamp])
    is_left = ~shapely.is_empty(cells)
    return lamp[is_left], cells[is_left]


def _nearest_regions(places_m: np.ndarray) -> np.ndarray:
    """Polygon (n,) of the places that are nearest to each lamp; empty for a lamp above another."""
    regions = np.full(len(places_m), shapely.Polygon(), dtype=object)
    distinct, first = np.unique(places_m.round(2), axis=0, return_index=True)
    around = shapely.box(*(distinct.min(axis=0) - 99.0), *(distinct.max(axis=0) + 99.0))
    if len(distinct) == 1:
        regions[first] = around
        return regions
    parts = shapely.voronoi_polygons(shapely.multipoints(distinct), extend_to=around, ordered=True)
    regions[first] = shapely.get_parts(parts)
    return regions
