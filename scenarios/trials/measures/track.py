"""Paths as a table of trials keeps them: few points, centimetres.

A flight has thousands of positions, a table thousands of flights. A simplified line is enough to
draw the path and to measure its length.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

TRACK_STEP_S = 0.2
"""Time between two points of a path before it is simplified."""
_TOLERANCE_M = 0.05
"""Greatest distance of a dropped point from the line that takes its place."""

Track = list[list[float]]
"""Points of a path, ENU, m."""


def track_of(points_enu_m: ArrayLike) -> Track:
    """Return a path as plain data: simplified to 5 cm, rounded to 1 cm.

    Args:
        points_enu_m: Points of the path, shape (n, 3).

    Raises:
        ValueError: If they are no points, or not finite.
    """
    points = np.asarray(points_enu_m, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ValueError(f"way of shape {points.shape} is none; valid: finite, shape (n, 3)")
    return np.round(simplified(points, _TOLERANCE_M), 2).tolist()


def simplified(points: Float[np.ndarray, "n 3"], tolerance: float) -> Float[np.ndarray, "m 3"]:
    """Return few of some points, so that no dropped one is farther than a tolerance from the line.

    Halving finds them; both ends are kept. The result is not the smallest possible set.

    Source: Douglas and Peucker 1973, "Algorithms for the reduction of the number of points required
    to represent a digitized line or its caricature".
    """
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1] if len(points) else []] = True
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        away = _from_segment(points[first + 1 : last], points[first], points[last])
        farthest = int(np.argmax(away))
        if away[farthest] > tolerance:
            middle = first + 1 + farthest
            keep[middle] = True
            spans += [(first, middle), (middle, last)]
    return points[keep]


def _from_segment(
    points: Float[np.ndarray, "n 3"], begin: Float[np.ndarray, 3], end: Float[np.ndarray, 3]
) -> Float[np.ndarray, " n"]:
    """Return the distance of points from the segment between two others."""
    way = end - begin
    # The tiny number only matters if both ends are the same point.
    share = (points - begin) @ way / max(float(way @ way), np.finfo(float).tiny)
    nearest = begin + np.clip(share, 0.0, 1.0)[:, None] * way
    return np.linalg.norm(points - nearest, axis=1)
