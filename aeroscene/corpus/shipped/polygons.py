"""Borders of areas, each vertex told by how it differs from where it should be.

Most borders are regular twelve-gons about the centroid or rectangles with it in their middle
(`aeroscene.areas.spots`), so half of the vertices lie opposite the other half, and of a twelve-gon
each lies 30 degrees on from the last. Guesses are integer arithmetic, the same on every machine;
a border of any other form costs bytes, not vertices.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Int64

from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter

Vertices = Int64[np.ndarray, "m sides 3"]
"""Vertices of borders with equally many sides, from the centroid, in 0.1 mm."""

_ROUND = 12
"""Sides of the borders that stand for circles; the first vertex is at 15 degrees."""
_BITS = 30
_COS_30, _SIN_30, _TAN_15 = (
    round(2**_BITS * factor) for factor in (math.sqrt(0.75), 0.5, 2 - math.sqrt(3))
)


def write_vertices(
    vertices: Vertices, radii: Int64[np.ndarray, " m"], writer: ColumnWriter
) -> None:
    """Append borders with equally many sides; `radii` are of the circles in them, in 0.1 mm."""
    known = np.zeros_like(vertices)
    for index in range(vertices.shape[1]):
        for axis in range(3):
            guess = _guess(known, radii, index, axis)
            writer.add(vertices[:, index, axis] - guess)
            known[:, index, axis] = vertices[:, index, axis]


def read_vertices(sides: int, radii: Int64[np.ndarray, " m"], reader: ColumnReader) -> Vertices:
    """The borders that were appended."""
    known = np.zeros((len(radii), sides, 3), np.int64)
    for index in range(sides):
        for axis in range(3):
            known[:, index, axis] = _guess(known, radii, index, axis) + reader.take()
    return known


def _guess(
    known: Vertices, radii: Int64[np.ndarray, " m"], index: int, axis: int
) -> Int64[np.ndarray, " m"]:
    """Where a coordinate should be, given all vertices and axes before it."""
    sides = known.shape[1]
    if index == 0:
        if sides != _ROUND:
            return np.zeros_like(radii)
        return (radii, _scaled(known[:, 0, 0], _TAN_15), np.zeros_like(radii))[axis]
    if sides % 2 == 0 and index >= sides // 2:
        return -known[:, index - sides // 2, axis]
    x, y, z = known[:, index - 1].T
    if sides == _ROUND:
        turned_x = _scaled(x, _COS_30) - _scaled(y, _SIN_30)
        return (turned_x, _scaled(x, _SIN_30) + _scaled(y, _COS_30), z)[axis]
    return (-x if sides == 4 else x, y, z)[axis]


def _scaled(lengths: Int64[np.ndarray, " m"], factor: int) -> Int64[np.ndarray, " m"]:
    return (lengths * factor + (1 << (_BITS - 1))) >> _BITS
