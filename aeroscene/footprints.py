"""Solids seen from above: outlines, level faces, and what stands between two heights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float
from shapely.geometry.base import BaseGeometry

from aeroscene.geometry import rotation_matrix
from aeroscene.shapes import Primitive
from aeroscene.voxels import bounds

_LEVEL = 1 - 1e-6
"""Least cosine of a level face's tilt."""
_ROUND = 16
"""Corners of a circle's outline."""
_MERGE_M = 0.002
"""Faces of one object whose heights differ by less are one face."""


@dataclass(frozen=True, slots=True)
class Face:
    """A level upward face of an object."""

    object_id: int
    height_m: float
    outline: BaseGeometry


def upward_faces(primitives: Sequence[Primitive]) -> list[Face]:
    """Level upper faces of boxes and upright cylinders, those of one object and height united."""
    groups: dict[tuple[int, int], list[Primitive]] = {}
    for primitive in primitives:
        if primitive.collides and primitive.kind in {"box", "cylinder"} and _is_level(primitive):
            key = (primitive.object_id, round(_top(primitive) / _MERGE_M))
            groups.setdefault(key, []).append(primitive)
    return [
        Face(
            object_id,
            max(_top(primitive) for primitive in group),
            shapely.union_all([footprint(primitive) for primitive in group]),
        )
        for (object_id, _), group in groups.items()
    ]


def footprint(primitive: Primitive) -> BaseGeometry:
    """Outline from above; circles by a polygon that lies outside them."""
    return shapely.Polygon(_outline(primitive))


def _outline(primitive: Primitive) -> Float[np.ndarray, "n 2"]:
    rotation = rotation_matrix(primitive.quat_wxyz)
    centre = np.asarray(primitive.position_enu_m[:2])
    half = np.asarray(primitive.size_m) / 2
    if primitive.kind == "box" and abs(rotation[2, 2]) > _LEVEL:
        corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * half[:2]
        return centre + corners @ rotation[:2, :2].T
    angles = 2 * np.pi * np.arange(_ROUND) / _ROUND
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1) / np.cos(np.pi / _ROUND)
    if primitive.kind == "cylinder" and abs(rotation[2, 2]) > _LEVEL:
        return centre + half[0] * circle
    if primitive.kind == "ellipsoid":
        # The shadow of an ellipsoid is an ellipse with this matrix.
        shadow = (rotation * half**2) @ rotation.T
        return centre + circle @ np.linalg.cholesky(shadow[:2, :2]).T
    points = _surface_points(primitive, half) @ rotation.T
    hull = shapely.convex_hull(shapely.MultiPoint(points[:, :2] + centre))
    return shapely.get_coordinates(hull)


def _surface_points(primitive: Primitive, half: np.ndarray) -> Float[np.ndarray, "n 3"]:
    """Points whose hull holds a tilted box, a lying cylinder or a mesh; local."""
    if primitive.kind == "mesh":
        return np.asarray(primitive.vertices_m)
    signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
    return signs * half


def _is_level(primitive: Primitive) -> bool:
    return abs(rotation_matrix(primitive.quat_wxyz)[2, 2]) > _LEVEL


def _top(primitive: Primitive) -> float:
    return primitive.position_enu_m[2] + primitive.size_m[2] / 2


class Footprints:
    """Outlines of all solids of a scene with their heights, for questions from above."""

    def __init__(self, primitives: Sequence[Primitive]) -> None:
        solids = [primitive for primitive in primitives if primitive.collides]
        corners = [bounds(primitive) for primitive in solids]
        self._low = np.array([low[2] for low, _ in corners])
        self._high = np.array([high[2] for _, high in corners])
        self._outlines = np.array([footprint(primitive) for primitive in solids], dtype=object)
        self._tree = shapely.STRtree(self._outlines)

    def between(self, region: BaseGeometry, low_m: float, high_m: float) -> BaseGeometry:
        """Union of the outlines in a region of solids that reach between two heights."""
        hits = self._tree.query(region)
        hits = hits[(self._low[hits] < high_m) & (self._high[hits] > low_m)]
        return shapely.union_all(self._outlines[hits])

    def lowest_above(self, region: BaseGeometry, height_m: float) -> float:
        """Lowest underside above a height over a region; infinite under open sky."""
        hits = self._tree.query(region, predicate="intersects")
        undersides = self._low[hits]
        undersides = undersides[undersides > height_m]
        return float(undersides.min()) if len(undersides) else np.inf
