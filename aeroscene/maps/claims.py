"""Claimed ground: later claims get the rest.

Features of a map overlap everywhere: streets cross squares, paths cross lawns. Covers of a scene
must lie beside each other. The modules therefore claim ground in the order of what people would
see, and each builds on the ground that earlier ones have left.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

GRID_M = 0.01
"""Grid of corners, m: neighbours share corners exactly, so that unions leave no slivers."""
SIMPLIFY_M = 0.1
"""Greatest distance by which an outline may move when corners are left out."""
_THIN_M = 0.15
"""Half the width of slivers that are removed."""
# Larger pieces are halved: outlines of scenes have bounded corners, and boxes bounded sides.
_MOST_SIDE_M = 80.0
_MOST_CORNERS = 300


def areal_parts(shape: BaseGeometry, least_m2: float) -> Iterator[shapely.Polygon]:
    """Yield the polygons of a shape that have at least some area.

    Args:
        shape: Shape, m.
        least_m2: Area below which a polygon is left out.
    """
    for part in shapely.get_parts(shape):
        if isinstance(part, shapely.Polygon) and part.area >= least_m2:
            yield part


def areal(shape: BaseGeometry) -> BaseGeometry:
    """The areal part of a shape; unions and cuts leave lines and points beside it."""
    parts = [p for p in shapely.get_parts(shape) if shapely.get_dimensions(p) == 2]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def opened(shape: BaseGeometry, half_width_m: float = _THIN_M) -> BaseGeometry:
    """Remove slivers and spikes from a shape.

    Args:
        shape: Shape, m.
        half_width_m: Half the width below which a part is removed.

    Returns:
        The shape; its corners stay sharp, except acute ones.
    """
    # Shrinking removes narrow parts, growing restores the rest.
    inner = shapely.buffer(shape, -half_width_m, join_style="mitre")
    return shapely.buffer(inner, half_width_m, join_style="mitre", mitre_limit=3.0)


def on_grid(shape: BaseGeometry) -> BaseGeometry:
    """An area with corners on the grid, without corners that hardly turn."""
    return areal(shapely.set_precision(shapely.simplify(shape, SIMPLIFY_M), GRID_M))


def split(shape: BaseGeometry, least_m2: float) -> Iterator[shapely.Polygon]:
    """The polygons of a shape, halved until none is long or has many corners.

    Args:
        shape: Shape, m.
        least_m2: Area below which a piece is left out.
    """
    for part in areal_parts(shape, least_m2):
        x0, y0, x1, y1 = part.bounds
        side = max(x1 - x0, y1 - y0)
        n_corners = shapely.get_num_coordinates(part)
        # A piece of less than a metre is never halved, so that the recursion ends.
        if (side <= _MOST_SIDE_M and n_corners <= _MOST_CORNERS) or side < 1.0:
            yield part
            continue
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        halves = (
            (shapely.box(x0, y0, x, y1), shapely.box(x, y0, x1, y1))
            if x1 - x0 >= y1 - y0
            else (shapely.box(x0, y0, x1, y), shapely.box(x0, y, x1, y1))
        )
        for half in halves:
            yield from split(shapely.intersection(part, half, grid_size=GRID_M), least_m2)


class Claims:
    """A part of the plane, claimed piece by piece."""

    def __init__(self) -> None:
        self.shapes: list[BaseGeometry] = []
        self._bounds: list[tuple[float, ...]] = []

    def pieces_near(self, shape: BaseGeometry) -> list[BaseGeometry]:
        """Find the pieces whose bounds meet those of a shape."""
        if not self._bounds or shape.is_empty:
            return []
        x0, y0, x1, y1 = shape.bounds
        b = np.array(self._bounds)
        is_near = (b[:, 0] <= x1) & (b[:, 2] >= x0) & (b[:, 1] <= y1) & (b[:, 3] >= y0)
        return [self.shapes[k] for k in np.flatnonzero(is_near)]

    def unclaimed_part(self, shape: BaseGeometry) -> BaseGeometry:
        """Return the part of a shape that nobody has claimed.

        Args:
            shape: Shape, m.
        """
        near = self.pieces_near(shape)
        # Most shapes meet nothing, and the union below is slow.
        if not near or not shapely.intersects(near, shape).any():
            return shape
        taken = shapely.union_all(near, grid_size=GRID_M)
        return areal(shapely.difference(areal(shape), areal(taken), grid_size=GRID_M))

    def add(self, shape: BaseGeometry) -> None:
        """Claim a shape, whether or not others have claimed parts of it."""
        if not shape.is_empty:
            self.shapes.append(shape)
            self._bounds.append(shape.bounds)
