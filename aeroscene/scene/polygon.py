"""Polygons in the plane with numpy alone, because opening a scene should not load shapely."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

Point = tuple[float, float]
_MANY = 64
"""Number of edges from which numpy rows are faster than loops over single numbers."""


def _edges(outline: Sequence[Point]) -> list[tuple[Point, Point]]:
    return [*pairwise(outline), (outline[-1], outline[0])]


def signed_area(outline: Sequence[Point]) -> float:
    """Signed area of an outline in m2: positive if it runs counter-clockwise."""
    return 0.5 * sum(a[0] * b[1] - b[0] * a[1] for a, b in _edges(outline))


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def is_simple(outline: Sequence[Point]) -> bool:
    """True if no two edges cross that are not neighbours, and no corner is repeated.

    A convex outline is recognised in linear time; all others compare every pair of edges.
    """
    edges = _edges(outline)
    turns = [_turn(a, b, d) for (a, b), (_, d) in zip(edges, edges[1:] + edges[:1], strict=True)]
    # All turns to the left and one full turn in all: convex. A star turns left as well, but more
    # than once around.
    if min(turns) >= 0 and _winding_turns(edges) == 1:
        return True
    count = len(edges)
    if count > _MANY:
        return not _any_cross(edges) and len(set(outline)) == count
    for i, (a, b) in enumerate(edges):
        # The last edge is a neighbour of the first, so that pair is left out.
        for c, d in edges[i + 2 : count - (i == 0)]:
            if _turn(a, b, c) * _turn(a, b, d) < 0 and _turn(c, d, a) * _turn(c, d, b) < 0:
                return False
    return len(set(outline)) == count


def _any_cross(edges: Sequence[tuple[Point, Point]]) -> bool:
    """Do the same comparison of pairs as `is_simple`, one numpy row an edge."""
    ax, ay, bx, by = np.array(edges).reshape(-1, 4).T
    count = len(edges)
    for i in range(count - 2):
        others = slice(i + 2, count - (i == 0))
        cx, cy, dx, dy = ax[others], ay[others], bx[others], by[others]
        x, y, ex, ey = bx[i] - ax[i], by[i] - ay[i], dx - cx, dy - cy
        apart = (x * (cy - ay[i]) - y * (cx - ax[i])) * (x * (dy - ay[i]) - y * (dx - ax[i]))
        across = (ex * (ay[i] - cy) - ey * (ax[i] - cx)) * (ex * (by[i] - cy) - ey * (bx[i] - cx))
        if ((apart < 0) & (across < 0)).any():
            return True
    return False


def _winding_turns(edges: Sequence[tuple[Point, Point]]) -> int:
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in edges]
    total = sum((second - first) % (2 * math.pi) for first, second in pairwise(headings))
    total += (headings[0] - headings[-1]) % (2 * math.pi)
    return round(total / (2 * math.pi))


def distance_inside(outline: Sequence[Point], x: float, y: float) -> float:
    """Distance in m from a point to the border of an outline, negative outside."""
    nearest, is_inside = math.inf, False
    for (ax, ay), (bx, by) in _edges(outline):
        dx, dy = bx - ax, by - ay
        length_squared = dx * dx + dy * dy
        t = 0.0 if length_squared == 0 else ((x - ax) * dx + (y - ay) * dy) / length_squared
        t = min(1.0, max(0.0, t))
        nearest = min(nearest, math.hypot(ax + t * dx - x, ay + t * dy - y))
        # Even-odd rule: count the edges to the right of the point that cross its height.
        if (ay > y) != (by > y) and x < ax + (y - ay) * dx / dy:
            is_inside = not is_inside
    return nearest if is_inside else -nearest
