"""Polygons as convex pieces, because colliders have to be convex.

A polygon whose edges all run along the axes becomes rectangles, which are the cheapest colliders.
Any other polygon is triangulated, and neighbouring triangles are joined as long as they stay convex
(Hertel and Mehlhorn 1983, "Fast triangulation of simple polygons"). That leaves at most four times
the least possible number of pieces, without the cost of finding the least.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import shapely

Point2 = tuple[float, float]
Ring = tuple[Point2, ...]
"""Corners of a convex polygon, counter-clockwise, not closed, m."""
_ALONG_AXIS_M = 0.005
"""Deviation up to which an edge runs along an axis."""
# Pieces below this area, and corners nearer than this to a straight edge, are rounding.
_LEAST_M2 = 1e-4
_LEAST_M = 0.002
_CONVEX_M2 = 1e-6
"""Twice the area by which a corner of a piece may turn inwards, for rounding."""


@lru_cache(maxsize=4096)
def convex_pieces(polygon: shapely.Polygon) -> tuple[Ring, ...]:
    """Convex polygons that tile a polygon, holes left out.

    Args:
        polygon: Simple polygon, in m.

    Returns:
        Rings that run counter-clockwise, each with at least three corners.
    """
    rectangles = _rectangles(polygon)
    pieces = _joined(_triangles(polygon)) if rectangles is None else rectangles
    return tuple(piece for piece in pieces if abs(_doubled_area(piece)) > 2 * _LEAST_M2)


def is_along_axes(polygon: shapely.Polygon) -> bool:
    """True if every edge runs along x or y."""
    rings = [polygon.exterior, *polygon.interiors]
    return all(
        min(abs(bx - ax), abs(by - ay)) < _ALONG_AXIS_M
        for ring in rings
        for (ax, ay), (bx, by) in pairwise(ring.coords)
    )


def _rectangles(polygon: shapely.Polygon) -> list[Ring] | None:
    """Cut along every level of corners into strips, then join equal strips above each other.

    Returns None for a polygon with slanted edges.
    """
    import shapely

    if not is_along_axes(polygon):
        return None
    left, _, right, _ = polygon.bounds
    levels = _levels([y for _, y in shapely.get_coordinates(polygon).tolist()])
    open_strips: dict[tuple[float, float], float] = {}
    done: list[Ring] = []
    for low, high in pairwise(levels):
        middle = (low + high) / 2
        # Beyond both sides, so that the line crosses the whole polygon.
        line = shapely.LineString([(left - 1, middle), (right + 1, middle)])
        parts = shapely.get_parts(shapely.intersection(polygon, line))
        # Millimetres make spans of neighbouring strips comparable.
        spans = {(round(p.bounds[0], 3), round(p.bounds[2], 3)) for p in parts if p.length}
        ended = [span for span in open_strips if span not in spans]
        done += [_rectangle(span, open_strips.pop(span), low) for span in ended]
        for span in sorted(spans):
            open_strips.setdefault(span, low)
    return done + [_rectangle(span, low, levels[-1]) for span, low in open_strips.items()]


def _levels(values: Sequence[float]) -> list[float]:
    """Distinct values in ascending order; values that differ only by rounding are one."""
    levels: list[float] = []
    for value in sorted(values):
        if not levels or value - levels[-1] > _ALONG_AXIS_M:
            levels.append(value)
    return levels


def _rectangle(x: Point2, low: float, high: float) -> Ring:
    return ((x[0], low), (x[1], low), (x[1], high), (x[0], high))


def _triangles(polygon: shapely.Polygon) -> list[Ring]:
    import shapely

    found = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = shapely.get_coordinates(found).reshape(-1, 4, 2)[:, :3].tolist()
    rings = [tuple((x, y) for x, y in ring) for ring in corners]
    return [ring if _doubled_area(ring) > 0 else ring[::-1] for ring in rings]


def _doubled_area(ring: Sequence[Point2]) -> float:
    return sum(
        ax * by - bx * ay for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True)
    )


def _joined(triangles: Sequence[Ring]) -> list[Ring]:
    """Join triangles: each inner edge goes if the corners at its ends stay convex without it."""
    pieces: dict[int, Ring] = dict(enumerate(triangles))
    owner: dict[tuple[Point2, Point2], int] = {
        edge: number for number, ring in pieces.items() for edge in _edges(ring)
    }
    inner = [(a, b) for a, b in owner if a < b and (b, a) in owner]
    # Longest first: pieces become compact rather than long and thin.
    for edge in sorted(inner, key=lambda e: -_length2(e)):
        first, second = owner[edge], owner[edge[1], edge[0]]
        if first == second or (ring := _union(pieces[first], pieces[second], edge)) is None:
            continue
        del pieces[second]
        pieces[first] = ring
        # Only outer edges of the new ring need their owner: the inner one is gone.
        owner |= dict.fromkeys(_edges(ring), first)
    return [_without_straight(ring) for ring in pieces.values()]


def _edges(ring: Ring) -> list[tuple[Point2, Point2]]:
    return list(zip(ring, (*ring[1:], ring[0]), strict=True))


def _length2(edge: tuple[Point2, Point2]) -> float:
    (ax, ay), (bx, by) = edge
    return (bx - ax) ** 2 + (by - ay) ** 2


def _union(first: Ring, second: Ring, edge: tuple[Point2, Point2]) -> Ring | None:
    """Two rings on both sides of an edge as one; None if that would not be convex."""
    a, b = edge
    i, j = first.index(b), second.index(a)
    # From b around the first ring to a, then from a around the second to b.
    ring = first[i:] + first[:i] + (second[j:] + second[:j])[1:-1]
    n = len(ring)
    # Only the two ends of the removed edge have new angles.
    corners = (0, ring.index(a))
    if all(_turn(ring[k - 1], ring[k], ring[(k + 1) % n]) >= -_CONVEX_M2 for k in corners):
        return ring
    return None


def _turn(a: Point2, b: Point2, c: Point2) -> float:
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def _without_straight(ring: Ring) -> Ring:
    """A ring without the corners at which it continues straight."""
    n = len(ring)
    kept = []
    for k in range(n):
        a, b, c = ring[k - 1], ring[k], ring[(k + 1) % n]
        base = _length2((a, c)) ** 0.5
        if base == 0 or abs(_turn(a, b, c)) / base > _LEAST_M:
            kept.append(b)
    return tuple(kept) if len(kept) >= 3 else ring
