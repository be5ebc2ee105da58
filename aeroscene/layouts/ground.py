"""Floors as rectangles: ours are boxes, those of layouts are outlines of any form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.document import Point2

Rectangle = tuple[float, float, float, float]
"""Lower and upper corner along the axes: x, y, x, y, m."""

_SIMPLIFY_M = 0.02
_LEAST_M = 0.02
"""Width up to which a strip is rounding."""
_MAX_STRIPS = 40


def cover(outline: Sequence[Point2] | BaseGeometry, longest_m: float) -> list[Rectangle]:
    """Cover an outline by rectangles along the axes that do not overlap.

    The cover is exact if the outline runs along the axes, otherwise a little too large at slanting
    edges.

    Args:
        outline: Corners, or a polygon.
        longest_m: Length from which rectangles are divided evenly.
    """
    shape = outline if isinstance(outline, BaseGeometry) else shapely.Polygon(outline)
    shape = shapely.simplify(shape, _SIMPLIFY_M)
    rectangles = _merge(_strips(shape))
    return [tile for rectangle in rectangles for tile in _tiles(rectangle, longest_m)]


def _strips(shape: BaseGeometry) -> list[Rectangle]:
    """Cut along y at every corner, if corners are far enough apart; each piece by its bounds."""
    left, bottom, right, top = shape.bounds
    cuts = [bottom]
    # Curved outlines have hundreds of corners, hence at most 40 strips.
    least = max(_LEAST_M, (top - bottom) / _MAX_STRIPS)
    for y in sorted({float(y) for y in shapely.get_coordinates(shape)[:, 1]}):
        if y - cuts[-1] >= least or y == top:
            cuts.append(y)
    strips: list[Rectangle] = []
    for low, high in pairwise(cuts):
        if high - low < _LEAST_M:
            continue
        pieces = shapely.intersection(shape, shapely.box(left, low, right, high))
        for piece in shapely.get_parts(shapely.union_all([pieces])):
            # Thinner pieces are left by rounding at slanting edges.
            if piece.area > _LEAST_M**2:
                x0, _, x1, _ = piece.bounds
                strips.append((x0, low, x1, high))
    return strips


def _merge(strips: list[Rectangle]) -> list[Rectangle]:
    """Join strips of equal width above each other."""
    merged: list[Rectangle] = []
    for x0, low, x1, high in strips:
        for index, (u0, v0, u1, v1) in enumerate(merged):
            if abs(v1 - low) < 1e-6 and abs(u0 - x0) < _LEAST_M and abs(u1 - x1) < _LEAST_M:
                merged[index] = (u0, v0, u1, high)
                break
        else:
            merged.append((x0, low, x1, high))
    return merged


def _tiles(rectangle: Rectangle, longest_m: float) -> list[Rectangle]:
    x0, y0, x1, y1 = rectangle
    # A length that is a whole number of tiles must not get one more by rounding.
    nx = max(1, math.ceil((x1 - x0) / longest_m - 1e-9))
    ny = max(1, math.ceil((y1 - y0) / longest_m - 1e-9))
    dx, dy = (x1 - x0) / nx, (y1 - y0) / ny
    return [
        (x0 + i * dx, y0 + j * dy, x0 + (i + 1) * dx, y0 + (j + 1) * dy)
        for j in range(ny)
        for i in range(nx)
    ]
