"""Faces of a small convex solid, given by its corners: what drawing needs and MuJoCo leaves out.

Fit for tens of corners: every plane through three corners is tried (numpy, well under a millisecond
for a roof), which needs no triangulation library at start-up.
"""

from __future__ import annotations

import itertools

import numpy as np

_RELATIVE_TOLERANCE = 1e-7


class HullError(ValueError):
    """Corners that span no solid."""


def hull_faces(corners_m: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The faces of a convex hull.

    Args:
        corners_m: (n, 3); points inside the hull are left out.

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
    is_plane = length > _RELATIVE_TOLERANCE * size_m**2
    normals = normals[is_plane] / length[is_plane, None]
    height = normals @ corners.T - np.sum(normals * a[is_plane], axis=1)[:, None]
    tolerance_m = 10 * _RELATIVE_TOLERANCE * size_m
    is_below, is_above = (height <= tolerance_m).all(axis=1), (height >= -tolerance_m).all(axis=1)
    if not len(normals) or (is_below & is_above).any():
        raise HullError(f"{len(corners)} vertices lie in one plane, valid: vertices of a solid")
    is_face = is_below | is_above
    outward = np.where(is_below[:, None], normals, -normals)[is_face]
    # Every three corners of a face found it once more.
    members, first = np.unique(np.abs(height[is_face]) <= tolerance_m, axis=0, return_index=True)
    return [
        (outward[i], _counter_clockwise(corners, np.flatnonzero(row), outward[i]))
        for row, i in zip(members, first, strict=True)
    ]


def face_axes(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal axes of a face: level, and up the face (north on a level one)."""
    u = np.array([-normal[1], normal[0], 0.0])
    length = float(np.linalg.norm(u))
    u = u / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])
    return u, np.cross(normal, u)


def _counter_clockwise(corners: np.ndarray, members: np.ndarray, normal: np.ndarray) -> np.ndarray:
    u, v = face_axes(normal)
    spokes = corners[members] - corners[members].mean(axis=0)
    angle = np.arctan2(spokes @ v, spokes @ u)
    # Corners inside a face, on none of its edges, would break the fan: keep the outer ones.
    order = members[np.argsort(angle, kind="stable")]
    return _without_inner(corners, order, normal)


def _without_inner(corners: np.ndarray, ring: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Drop ring members where the outline does not turn left."""
    kept = ring.tolist()
    i = 0
    while len(kept) > 3 and i < len(kept):
        before, here, after = (corners[kept[(i + k) % len(kept)]] for k in (-1, 0, 1))
        turn = float(np.cross(here - before, after - here) @ normal)
        if turn <= _RELATIVE_TOLERANCE * float(np.ptp(corners, axis=0).max()) ** 2:
            kept.pop(i)
            i = max(0, i - 1)
        else:
            i += 1
    return np.array(kept)
