"""Obstacles on a face or over it, seen along the vertical.

A drone comes down vertically, so the outlines of obstacles from above and their heights over the
face are enough. Outlines may be larger than the truth and never smaller, so an area is never found
where an obstacle is.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np
import shapely
from jaxtyping import Float, Int
from shapely.geometry.base import BaseGeometry

from aeroscene.areas.faces import Face
from aeroscene.scene.geometry import layer
from aeroscene.solids.outlines import outline_of
from aeroscene.solids.solids import Solids

_ROUND = 12
"""Corners of a circle's outline."""
_GRID_M = 1e-6
"""Grid on which outlines are united: GEOS fails on edges that coincide up to rounding."""


@dataclass(frozen=True, slots=True)
class Obstructions:
    """Solids that rise above a face, within a region."""

    outlines: np.ndarray
    """Polygons (k,), seen from above."""
    base_m: Float[np.ndarray, " k"]
    """Height of their lower ends above the face."""
    top_m: Float[np.ndarray, " k"]
    """Height of their upper ends above the face."""

    def below(self, clearance_m: float) -> Obstructions:
        """Return the solids whose lower end is lower than a height."""
        keep = self.base_m < clearance_m
        return Obstructions(self.outlines[keep], self.base_m[keep], self.top_m[keep])

    def subtracted_from(self, outline: BaseGeometry) -> BaseGeometry:
        """Return an outline without these solids."""
        return _without(outline, self.outlines)

    def cleared_from(
        self, outline: BaseGeometry, above_m: float, distance_m: float
    ) -> BaseGeometry:
        """Return an outline without these solids, at a distance from the high ones.

        Args:
            outline: The outline.
            above_m: Solids that rise above this height keep the distance.
            distance_m: The distance.
        """
        walls = shapely.buffer(self.outlines[self.top_m > above_m], distance_m)
        return _without(outline, np.concatenate([self.outlines, walls]))

    def distance_m(self, point: shapely.Point, above_m: float) -> float:
        """Return the distance to the nearest solid above a height; infinite without one."""
        outlines = self.outlines[self.top_m > above_m]
        return float(shapely.distance(outlines, point).min(initial=np.inf))


def _without(outline: BaseGeometry, taken: np.ndarray) -> BaseGeometry:
    outline = _areal(outline)
    touching = taken[shapely.intersects(taken, outline)]
    if not len(touching):
        return outline
    if shapely.covers(touching, outline).any():
        return shapely.Polygon()
    united = _areal(shapely.union_all(_outermost(touching), grid_size=_GRID_M))
    return shapely.difference(outline, united, grid_size=_GRID_M)


def _outermost(outlines: np.ndarray) -> np.ndarray:
    """Return the outlines that lie in no other; uniting all takes longer than finding them."""
    inner, outer = shapely.STRtree(outlines).query(outlines, predicate="within")
    within = np.zeros((len(outlines), len(outlines)), dtype=bool)
    within[inner, outer] = True
    # Of equal outlines, each of which lies within the other, the first stays.
    is_inner = (within & (~within.T | np.tri(len(outlines), k=-1, dtype=bool))).any(axis=1)
    return outlines[~is_inner]


def _areal(shape: BaseGeometry) -> BaseGeometry:
    """Return the parts of a shape that have an area; GEOS cannot subtract edges and points."""
    parts = shapely.get_parts(shape)
    areal = parts[shapely.get_dimensions(parts) == 2]
    return shape if len(areal) == len(parts) else shapely.MultiPolygon(areal.tolist())


class Obstacles:
    """Outlines of all solids of a scene, with their heights over any plane.

    Outlines are supersets of the truth: circles lie within their polygons.
    """

    def __init__(self, solids: Solids) -> None:
        self._solids = solids
        self._outlines = _outlines(solids)
        self._tree = shapely.STRtree(self._outlines)
        self._is_straight = solids.is_upright & ~solids.is_mesh

    def above(
        self, face: Face, bounds: tuple[float, float, float, float], step_m: float
    ) -> Obstructions:
        """Return the solids near a rectangle that rise by more than a step above a face.

        Args:
            face: The face.
            bounds: The rectangle.
            step_m: Height of the step.
        """
        hits = np.sort(self._tree.query(shapely.box(*bounds)))
        base, top = self._heights(face, hits)
        hits, base, top = (values[top > step_m] for values in (hits, base, top))
        outlines = self._outlines[hits]
        # Only solids that pass through the face are cut. Round and straight
        # ones keep their outline.
        is_whole = (base >= step_m) | self._solids.is_round[hits]
        if face.is_level:
            is_whole |= self._is_straight[hits]
        for k in np.flatnonzero(~is_whole):
            outlines[k] = self._cut_outline(face, int(hits[k]), step_m)
        return Obstructions(outlines, base, top)

    def lowest_above(self, face: Face, disc: BaseGeometry, height_m: float) -> float:
        """Return a height above a face below which nothing hangs; infinite under open sky.

        Args:
            face: The face.
            disc: Part of the face over which to look.
            height_m: Solids that begin lower stand on the face and do not count.
        """
        hits = np.sort(self._tree.query(disc, predicate="intersects"))
        base, _ = self._heights(face, hits)
        if not face.is_level:
            x0, y0, x1, y1 = disc.bounds
            rise_m = hypot(*face.gradient) * (x1 - x0) / 2
            highest_m = face.height_m((x0 + x1) / 2, (y0 + y1) / 2) + rise_m
            # Both are lower bounds: one of the whole solid, the other of its
            # underside over the disc.
            base = np.maximum(base, self._solids.low_m[hits, 2] - highest_m)
        return float(base[base > height_m].min(initial=np.inf))

    def _heights(
        self, face: Face, hits: Int[np.ndarray, " k"]
    ) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, " k"]]:
        """Return lower and upper ends of solids above a face's plane."""
        if face.is_level:
            height = face.height_at_origin_m
            return self._solids.low_m[hits, 2] - height, self._solids.high_m[hits, 2] - height
        normal, offset = _plane(face)
        middle = self._solids.centre_m[hits] @ normal - offset
        reach = self._solids.reach_along(normal[None], hits)[:, 0]
        return middle - reach[:, 0], middle + reach[:, 1]

    def _cut_outline(self, face: Face, index: int, step_m: float) -> BaseGeometry:
        """Return the outline of the part of a solid that rises above a face."""
        normal, offset = _plane(face)
        points = layer(self._solids.points(index), normal, offset + step_m, np.inf)
        return outline_of(points)


def _plane(face: Face) -> tuple[Float[np.ndarray, " 3"], float]:
    """Return a normal and an offset: `normal @ x - offset` is the height of x above the plane."""
    return np.array([-face.gradient[0], -face.gradient[1], 1.0]), face.height_at_origin_m


def _outlines(solids: Solids) -> np.ndarray:
    """Return outlines from above; boxes with a vertical axis are computed all at once."""
    outlines = np.empty(len(solids), dtype=object)
    signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    is_plain = solids.is_box & solids.is_upright
    corners = signs * solids.half_m[is_plain, None, :2]
    turned = corners @ np.swapaxes(solids.rotation[is_plain, :2, :2], 1, 2)
    outlines[is_plain] = shapely.polygons(turned + solids.centre_m[is_plain, None, :2])
    for i in np.flatnonzero(~is_plain):
        outlines[i] = outline_of(_shadow(solids, int(i)))
    return outlines


def _shadow(solids: Solids, index: int) -> Float[np.ndarray, "k 2"]:
    """Return points in the plane whose hull contains a solid's shadow."""
    rotation, half = solids.rotation[index], solids.half_m[index]
    centre = solids.centre_m[index, :2]
    if not solids.is_round[index]:
        return solids.points(index)[:, :2]
    turns = 2 * np.pi * np.arange(_ROUND) / _ROUND
    # Divided by the cosine, the polygon's sides touch the circle from outside.
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1) / np.cos(np.pi / _ROUND)
    if solids.is_cylinder[index]:
        caps = circle @ (rotation[:2, :2] * half[:2]).T
        along = half[2] * rotation[:2, 2]
        return np.vstack([caps + along, caps - along]) + centre
    # The shadow of an ellipsoid is an ellipse with this matrix; its
    # Cholesky factor maps the circle.
    shadow = (rotation * half**2) @ rotation.T
    return centre + circle @ np.linalg.cholesky(shadow[:2, :2]).T
