"""Rectangles in the plane: places, sides of a host, reach of a turned rectangle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from aeroscene.scene.box import OrientedBox

QUARTER = math.pi / 2
Half = tuple[float, float]
"""Half extents along a rectangle's own x and y, m."""


@dataclass(frozen=True, slots=True)
class Place:
    """Middle and heading of a rectangle, ENU."""

    x_m: float
    y_m: float
    yaw_rad: float

    def moved(self, u_m: float, v_m: float, turn_rad: float = 0.0) -> Place:
        """Return the place at coordinates of this one's frame.

        Args:
            u_m: Coordinate along its heading.
            v_m: Coordinate to its left.
            turn_rad: Heading relative to its own.
        """
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x_m = self.x_m + cos * u_m - sin * v_m
        y_m = self.y_m + sin * u_m + cos * v_m
        return Place(x_m, y_m, self.yaw_rad + turn_rad)

    def local(self, other: Place) -> tuple[float, float, float]:
        """Return u and v in m and the turn in rad, within half a turn, of another place."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x_m, y_m = other.x_m - self.x_m, other.y_m - self.y_m
        # The remainder lies within half a turn, so small deviations stay small.
        turn_rad = math.remainder(other.yaw_rad - self.yaw_rad, 2.0 * math.pi)
        return cos * x_m + sin * y_m, cos * y_m - sin * x_m, turn_rad


@dataclass(frozen=True, slots=True)
class Rectangle:
    """Footprint of an object."""

    place: Place
    half_m: Half

    def from_side(self, side: int) -> Place:
        """Return the middle, headed along the outward normal of a side.

        Sides 0 to 3 are those towards +x, +y, -x and -y.
        """
        return Place(self.place.x_m, self.place.y_m, self.place.yaw_rad + side * QUARTER)

    def reach_m(self, side: int) -> Half:
        """Return the half extents along a side's normal and along the side.

        Args:
            side: Side 0 to 3, see `from_side`.
        """
        return self.half_m if side % 2 == 0 else (self.half_m[1], self.half_m[0])


WORLD = Rectangle(Place(0.0, 0.0, 0.0), (0.0, 0.0))
"""Host of objects without a parent."""


def footprint(box: OrientedBox) -> Rectangle:
    """Return a box as seen from above; a tilted one has its own extents, not its shadow's."""
    return Rectangle(Place(box.p[0], box.p[1], box.yaw_rad), (box.s[0] / 2, box.s[1] / 2))


def turned_reach_m(half_m: Half, turn_rad: float) -> Half:
    """Return the half extents of a turned rectangle along the axes before the turn.

    Args:
        half_m: Half extents along its own axes.
        turn_rad: Its turn.
    """
    cos, sin = abs(math.cos(turn_rad)), abs(math.sin(turn_rad))
    return cos * half_m[0] + sin * half_m[1], sin * half_m[0] + cos * half_m[1]


def hull(rectangles: Sequence[Rectangle]) -> Rectangle:
    """Return the smallest rectangle around others, along the axes of the first."""
    place = rectangles[0].place
    low, high = [math.inf, math.inf], [-math.inf, -math.inf]
    for each in rectangles:
        u_m, v_m, turn_rad = place.local(each.place)
        reach_m = turned_reach_m(each.half_m, turn_rad)
        for axis, at_m in enumerate((u_m, v_m)):
            low[axis] = min(low[axis], at_m - reach_m[axis])
            high[axis] = max(high[axis], at_m + reach_m[axis])
    # Back from the first rectangle's frame to the world.
    middle = place.moved((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    return Rectangle(middle, ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2))


def nearest_quadrant(turn_rad: float) -> tuple[int, float]:
    """Return the nearest number of quarter turns, 0 to 3, and the remainder, rad."""
    count = round(turn_rad / QUARTER)
    return count % 4, turn_rad - count * QUARTER
