"""The widest places of a free outline: whole small rectangles, else the largest circles.

An area is a circle with a polygon around it. A small rectangular face, such as a table top, becomes
an area as a whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

MAX_RADIUS_M = 3.0
"""Greatest radius of a circle: an area is a spot, not a field."""
# Corners of the polygon around a circle.
_VERTICES = 12
_CIRCLE = tuple(
    (cos(2 * pi * (i + 0.5) / _VERTICES), sin(2 * pi * (i + 0.5) / _VERTICES))
    for i in range(_VERTICES)
)
_TOLERANCE = 0.02
"""Tolerance of the largest circle's radius, as a share of the outline's size."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A circle to stand in, and the polygon around it."""

    centre: shapely.Point
    radius_m: float
    """Radius of the circle inside the outline."""
    free_m: float
    """Radius of a free circle around the centre, at least as wide as the spot's."""
    outline: tuple[tuple[float, float], ...]

    def cut(self, radius_m: float) -> Spot:
        """Return the same place with a radius of at most this."""
        if radius_m >= self.radius_m:
            return self
        return _round_spot(self.centre, min(radius_m / cos(pi / _VERTICES), self.free_m))


class FreeOutline:
    """The free part of a face, and the spots in it, widest first.

    Args:
        free: Outline of the free part.
        least_m: Radius below which no spot matters.
    """

    def __init__(self, free: BaseGeometry, least_m: float) -> None:
        self._least_m = least_m
        self._spots: list[tuple[Spot, BaseGeometry]] = []
        parts = shapely.get_parts(free)
        whole = _whole_rectangle(parts[0]) if len(parts) == 1 else None
        if whole is not None:
            self._spots.append((whole, parts[0]))
        else:
            self._add(parts)

    def _add(self, parts: np.ndarray) -> None:
        # A part with a smaller area than the least circle cannot contain it.
        for part in parts[shapely.area(parts) > pi * self._least_m**2]:
            tolerance_m = min(0.2, _TOLERANCE * part.area**0.5)
            circle = shapely.maximum_inscribed_circle(part, tolerance_m)
            x, y = circle.coords[0]
            self._spots.append(
                (_round_spot(shapely.Point(x, y), min(circle.length, MAX_RADIUS_M)), part)
            )

    def widest(self) -> Spot | None:
        """Return the widest spot that is left; None if all are too narrow."""
        if not self._spots:
            return None
        spot = max(self._spots, key=lambda entry: entry[0].radius_m)[0]
        return spot if spot.radius_m >= self._least_m else None

    def take(self, spot: Spot, spacing_m: float) -> None:
        """Remove a spot and its surroundings from the free part.

        Args:
            spot: The spot.
            spacing_m: Distance around it that is removed, too.
        """
        zone = spot.centre.buffer(spot.radius_m + spacing_m, quad_segs=4)
        # Only the parts that the spot touches are searched again.
        touched = [part for _, part in self._spots if shapely.intersects(part, zone)]
        self._spots = [entry for entry in self._spots if entry[1] not in touched]
        for part in touched:
            self._add(shapely.get_parts(shapely.difference(part, zone)))


def _round_spot(centre: shapely.Point, outer_m: float) -> Spot:
    x, y = centre.x, centre.y
    outline = tuple((x + outer_m * u, y + outer_m * v) for u, v in _CIRCLE)
    # The radius is that of the circle inside of the polygon.
    return Spot(centre, outer_m * cos(pi / _VERTICES), outer_m, outline)


def _whole_rectangle(part: BaseGeometry) -> Spot | None:
    """Return a rectangle as one spot, if it is at most as long as twice the largest circle."""
    if shapely.get_num_coordinates(part) != 5:
        return None
    corners = shapely.get_coordinates(shapely.normalize(part))[:4]
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    is_rectangle = abs(part.area - sides[0] * sides[1]) < 1e-3 * part.area
    # Long and narrow rectangles give several circles instead.
    if not is_rectangle or max(sides) > 2 * MAX_RADIUS_M or max(sides) > 3.2 * min(sides):
        return None
    ring = shapely.get_coordinates(shapely.orient_polygons(part))[:-1]
    outline = tuple((float(x), float(y)) for x, y in ring.tolist())
    half_m = float(min(sides)) / 2
    return Spot(part.centroid, half_m, half_m, outline)
