"""Smooth paths: uniform cubic B-splines over points at equal distances.

A spline lies within the hull of any four neighbouring points, so it cuts corners by less than the
spacing and otherwise stays on the polyline; velocity and acceleration along it are continuous.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3

_SPACING_M = 0.5


@dataclass(frozen=True, eq=False)
class SplinePath:
    """A path: its control points, and positions by distance along it."""

    points_enu_m: Float[np.ndarray, "n 3"]
    """Control points; an open path has one more beyond each end."""
    spacing_m: float
    is_loop: bool

    @property
    def length_m(self) -> float:
        """Length from end to end, or once around, m."""
        n = len(self.points_enu_m)
        return (n if self.is_loop else n - 3) * self.spacing_m

    def sample(self, distance_m: Float[np.ndarray, " k"]) -> Float[np.ndarray, "k 3"]:
        """Return positions at distances from the start (m); a loop goes round and round."""
        u = np.asarray(distance_m, dtype=float) / self.spacing_m
        n = len(self.points_enu_m)
        # Open paths stay in their first and last piece.
        i = np.floor(u).astype(int)
        if not self.is_loop:
            i = np.clip(i, 0, n - 4)
        t = (u - i)[:, None]
        weights = (
            (1 - t) ** 3 / 6,
            (3 * t**3 - 6 * t**2 + 4) / 6,
            (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6,
            t**3 / 6,
        )
        points = self.points_enu_m
        return sum((w * points[(i + k) % n] for k, w in enumerate(weights)), np.zeros((len(u), 3)))


def smooth_path(corners_enu_m: Sequence[Vector3], *, is_loop: bool) -> SplinePath:
    """Return a smooth path along a polyline.

    Args:
        corners_enu_m: Two points or more.
        is_loop: True joins the last point to the first.
    """
    corners = np.array(corners_enu_m, dtype=float)
    if is_loop:
        corners = np.vstack([corners, corners[:1]])
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    # A closed cubic spline needs four points.
    n_pieces = max(4 if is_loop else 1, math.ceil(along[-1] / _SPACING_M))
    at = np.linspace(0.0, along[-1], n_pieces + 1)
    points = np.column_stack([np.interp(at, along, corners[:, axis]) for axis in range(3)])
    if is_loop:
        # Piece i depends on points i to i + 3 and lies between the middle two.
        points = np.roll(points[:-1], 1, axis=0)
    else:
        # One point more at each end, mirrored, lets the spline begin and end at the corners.
        points = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    return SplinePath(points, float(along[-1]) / n_pieces, is_loop)
