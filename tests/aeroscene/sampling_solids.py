"""Exact membership of points in primitives: an independent check of voxels and areas."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from aeroscene.solids.shapes import Primitive
from aeroscene.solids.solids import Solids


def holds(primitive: Primitive, points_enu_m: np.ndarray, grow_m: float = 0.0) -> np.ndarray:
    """Which points lie in a primitive whose half extents are grown by a length."""
    turn = Rotation.from_quat(primitive.quat_wxyz, scalar_first=True)
    local = turn.inv().apply(np.asarray(points_enu_m) - primitive.position_enu_m)
    half = np.asarray(primitive.size_m) / 2 + grow_m
    if primitive.kind == "box":
        return np.all(np.abs(local) <= half, axis=1)
    if primitive.kind == "cylinder":
        return (np.hypot(local[:, 0], local[:, 1]) <= half[0]) & (np.abs(local[:, 2]) <= half[2])
    if primitive.kind == "ellipsoid":
        return ((local / half) ** 2).sum(axis=1) <= 1.0
    planes = ConvexHull(np.asarray(primitive.vertices_m)).equations
    return np.all(local @ planes[:, :3].T + planes[:, 3] <= grow_m, axis=1)


def any_holds(primitives: list[Primitive], points_enu_m: np.ndarray) -> np.ndarray:
    """Which points lie in any colliding primitive."""
    taken = np.zeros(len(points_enu_m), dtype=bool)
    for primitive in primitives:
        if primitive.collides:
            taken |= holds(primitive, points_enu_m)
    return taken


def bounds(primitive: Primitive) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of a solid's bounding box along the axes, ENU, m."""
    solids = Solids([primitive])
    return solids.low_m[0], solids.high_m[0]
