"""Landing faces of the bare ground of a relief, and the parts of other faces that ground buries.

The ground of a relief is no object, so it has no upper faces. Instead discs on a lattice are tried:
a plane is fitted to the heights in each, and the disc is a face if the ground follows the plane
closely and the slope is gentle.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import tan

import numpy as np
import shapely
from jaxtyping import Bool, Float
from shapely.geometry.base import BaseGeometry

from aeroscene.areas.faces import Face
from aeroscene.areas.needs import MAX_SLOPE_RAD, NEEDS, STEP_M
from aeroscene.areas.spots import MAX_RADIUS_M
from aeroscene.scene import Relief, Scene
from aeroscene.scene.catalogue import GROUND
from aeroscene.scene.footprint import footprint
from aeroscene.scene.relief import ground_m

APART_M = 12.0
"""Least distance between the middles of two faces: a meadow needs no area at every step."""
_LATTICE_M = 2.0
"""Spacing of the places that are tried."""
_TOLERANCE_M = 0.004
"""Greatest distance of the ground from the plane of an even disc."""
_RIM_M = 0.05
"""Added to the radius of a face, because its circle is a polygon."""
# Points around each ring of the test disc, and radii of the rings.
_TURNS = 16
_RINGS = (0.33, 0.67, 1.0)
_ANGLES = 2 * np.pi * np.arange(_TURNS) / _TURNS
_CIRCLE = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
_DISC: Float[np.ndarray, "k 2"] = np.vstack([np.zeros((1, 2)), *(r * _CIRCLE for r in _RINGS)])
"""Points of a disc of radius 1."""
_RADII_M = tuple(
    max(needs.surface_radius_m, needs.body_radius_m) + _RIM_M for needs in NEEDS.values()
)


def ground_faces(scene: Scene) -> list[Face]:
    """Return even and gentle discs of the ground of a relief, the widest first.

    A scene without a relief has none.
    """
    if scene.relief is None:
        return []
    faces: list[Face] = []
    taken = np.zeros((0, 2))
    covers = _Covers(scene)
    # The widest first, so that a large drone's place is not taken by small ones.
    for radius_m in sorted({*_RADII_M, MAX_RADIUS_M + _RIM_M}, reverse=True):
        for x, y, *plane in _even_discs(scene, scene.relief, covers, radius_m):
            if len(taken) and np.hypot(*(taken - (x, y)).T).min() < APART_M:
                continue
            taken = np.vstack([taken, (x, y)])
            outline = shapely.Point(x, y).buffer(radius_m)
            faces.append(Face(None, outline, (plane[0], plane[1]), plane[2]))
    return faces


def _even_discs(
    scene: Scene, relief: Relief, covers: _Covers, radius_m: float
) -> Iterator[tuple[float, ...]]:
    """Yield uncovered discs of a radius on a lattice: middle, gradient, height at the origin."""
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    x, y = (np.arange(low[i] + radius_m, high[i] - radius_m, _LATTICE_M) for i in range(2))
    middles = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    disc = radius_m * _DISC
    points = middles[:, None] + disc
    heights = relief.height_m(points[..., 0], points[..., 1])
    basis = np.column_stack([disc, np.ones(len(disc))])
    # The same disc everywhere, so one pseudo-inverse fits all planes.
    planes = heights @ np.linalg.pinv(basis).T
    off_m = np.abs(heights - planes @ basis.T).max(axis=1)
    slope = np.hypot(planes[:, 0], planes[:, 1])
    is_even = (off_m <= _TOLERANCE_M) & (slope <= tan(MAX_SLOPE_RAD))
    # Planes are fitted about the middles; a face states its height over the origin.
    at_origin = planes[:, 2] - np.einsum("ij,ij->i", planes[:, :2], middles)
    even = np.flatnonzero(is_even)
    for chosen in (slice(1), slice(None)):  # Most covered ones have a covered middle.
        shown = covers.leave(points[even, chosen], heights[even, chosen])
        even = even[shown.all(axis=1)]
    found = np.column_stack([middles, planes[:, :2], at_origin])[even]
    yield from map(tuple, found.tolist())


class _Covers:
    """Covers of the ground, and raised land."""

    def __init__(self, scene: Scene) -> None:
        covers = [obj for obj in scene.objects if obj.category in GROUND]
        self._tree = shapely.STRtree([footprint(obj) for obj in covers])
        self._top_m = np.array([obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in covers])

    def leave(
        self, points: Float[np.ndarray, "n k 2"], height_m: Float[np.ndarray, "n k"]
    ) -> Bool[np.ndarray, "n k"]:
        """Return True for points at which the ground is above all covers."""
        is_bare = np.ones(height_m.size, dtype=bool)
        if len(self._top_m):
            point, cover = self._tree.query(shapely.points(points.reshape(-1, 2)), "intersects")
            is_below = height_m.ravel()[point] < self._top_m[cover] - STEP_M
            is_bare[point[is_below]] = False
        return is_bare.reshape(height_m.shape)


def above_ground(scene: Scene, outline: BaseGeometry, top_m: float) -> BaseGeometry:
    """Return the part of a level outline that the ground of a relief does not bury.

    Cells of the relief count as a whole, so up to one cell at the edge may be missing.

    Args:
        scene: The scene.
        outline: Outline from above, ENU.
        top_m: Its height.
    """
    relief = scene.relief
    if relief is None or outline.is_empty or relief.max_m <= top_m + STEP_M:
        return outline
    heights, spacing_m = relief.heights_m, relief.spacing_m
    # A cell buries the outline if its highest corner does.
    highest = np.maximum(heights[:-1], heights[1:])
    highest = np.maximum(highest[:, :-1], highest[:, 1:])
    rows, columns = np.nonzero(highest > top_m + STEP_M)
    east, north = relief.origin_enu_m
    x, y = east + spacing_m * columns, north + spacing_m * rows
    x0, y0, x1, y1 = outline.bounds
    is_near = (x < x1) & (x > x0 - spacing_m) & (y < y1) & (y > y0 - spacing_m)
    x, y = x[is_near], y[is_near]
    if not len(x):
        return outline
    buried = shapely.union_all(shapely.box(x, y, x + spacing_m, y + spacing_m))
    return shapely.difference(outline, buried)


def ground_rise_m(scene: Scene, face: Face, centre: shapely.Point, radius_m: float) -> float:
    """Return the greatest height of the ground above a face's plane, within a circle.

    Args:
        scene: The scene.
        face: The face.
        centre: Middle of the circle.
        radius_m: Its radius.
    """
    points = np.array([centre.x, centre.y]) + radius_m * _DISC
    plane_m = face.height_at_origin_m + points @ np.array(face.gradient)
    return float((ground_m(scene.relief, *points.T) - plane_m).max())
