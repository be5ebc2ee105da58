"""Faces of a small convex solid from its corners, which drawing needs and MuJoCo omits.

For tens of corners: every plane through three corners is tried (numpy, well under a millisecond
for a roof), which needs no triangulation library at start-up.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

_RELATIVE_TOLERANCE = 1e-7


class HullError(ValueError):
    """The corners span no solid."""


def hull_faces(corners_m: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the faces of a convex hull.

    Args:
        corners_m: Corners (n, 3); points inside the hull are ignored.

    Returns:
        For each face its outward unit normal (3,) and its corners' indices, counter-clockwise seen
        from outside.

    Raises:
        HullError: If all corners lie in one plane.
    """
    corners = np.asarray(corners_m, dtype=float)
    size_m = float(np.ptp(corners, axis=0).max())
    triples = np.array(list(itertools.combinations(range(len(corners)), 3)), dtype=int)
    a, b, c = (corners[triples[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    # Three corners in a line span no plane.
    is_plane = length > _RELATIVE_TOLERANCE * size_m**2
    normals = normals[is_plane] / length[is_plane, None]
    height = normals @ corners.T - np.sum(normals * a[is_plane], axis=1)[:, None]
    # Heights are rounded more than the corners themselves.
    tolerance_m = 10 * _RELATIVE_TOLERANCE * size_m
    is_below, is_above = (height <= tolerance_m).all(axis=1), (height >= -tolerance_m).all(axis=1)
    if not len(normals) or (is_below & is_above).any():
        raise HullError(f"{len(corners)} vertices lie in one plane; valid: vertices of a solid")
    is_face = is_below | is_above
    outward = np.where(is_below[:, None], normals, -normals)[is_face]
    touches = np.abs(height[is_face]) <= tolerance_m
    # Every three corners of a face found it again.
    first = {row.tobytes(): i for i, row in reversed(list(enumerate(touches)))}
    points, least_m2 = corners.tolist(), _RELATIVE_TOLERANCE * size_m**2
    return [
        (outward[i], _counter_clockwise(points, np.flatnonzero(touches[i]), outward[i], least_m2))
        for i in sorted(first.values())
    ]


def face_axes(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return orthonormal axes of a face: horizontal, and up the face (north on a level one)."""
    x, y, z = normal.tolist()
    length = math.hypot(x, y)
    ux, uy = (-y / length, x / length) if length > 1e-6 else (1.0, 0.0)
    return np.array([ux, uy, 0.0]), np.array([-z * uy, z * ux, x * uy - y * ux])


def _counter_clockwise(
    points_m: list[list[float]], members: np.ndarray, normal: np.ndarray, least_m2: float
) -> np.ndarray:
    u, v = (axis.tolist() for axis in face_axes(normal))
    ring = [
        (
            sum(p * q for p, q in zip(points_m[i], u, strict=True)),
            sum(p * q for p, q in zip(points_m[i], v, strict=True)),
        )
        for i in members.tolist()
    ]
    x = sum(point[0] for point in ring) / len(ring)
    y = sum(point[1] for point in ring) / len(ring)
    order = sorted(range(len(ring)), key=lambda k: math.atan2(ring[k][1] - y, ring[k][0] - x))
    # Corners inside a face would break the fan: keep the outer ones.
    kept = _turning_left([ring[k] for k in order], least_m2)
    return members[[order[k] for k in kept]]


def _turning_left(ring_m: list[tuple[float, float]], least_m2: float) -> list[int]:
    """Indices of the plane points at which the outline turns left."""
    kept = list(range(len(ring_m)))
    i = 0
    while len(kept) > 3 and i < len(kept):
        (ax, ay), (bx, by), (cx, cy) = (ring_m[kept[(i + k) % len(kept)]] for k in (-1, 0, 1))
        if (bx - ax) * (cy - by) - (by - ay) * (cx - bx) <= least_m2:
            kept.pop(i)
            # The points before may have stopped turning left: look at them again.
            i = max(0, i - 1)
        else:
            i += 1
    return kept
