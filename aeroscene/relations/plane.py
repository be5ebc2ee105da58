"""Rectangles in the plane: places, the sides of a host, how far a turned rectangle reaches."""

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
        """The place at coordinates of this one's frame."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x_m = self.x_m + cos * u_m - sin * v_m
        y_m = self.y_m + sin * u_m + cos * v_m
        return Place(x_m, y_m, self.yaw_rad + turn_rad)

    def local(self, other: Place) -> tuple[float, float, float]:
        """Coordinates of another place in this one's frame: m, m, and rad within a half turn."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x_m, y_m = other.x_m - self.x_m, other.y_m - self.y_m
        turn_rad = math.remainder(other.yaw_rad - self.yaw_rad, 2.0 * math.pi)
        return cos * x_m + sin * y_m, cos * y_m - sin * x_m, turn_rad


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A footprint."""

    place: Place
    half_m: Half

    def from_side(self, side: int) -> Place:
        """The middle, headed along the outward normal of a side."""
        return Place(self.place.x_m, self.place.y_m, self.place.yaw_rad + side * QUARTER)

    def reach_m(self, side: int) -> Half:
        """Half extents along a side's normal and along the side."""
        return self.half_m if side % 2 == 0 else (self.half_m[1], self.half_m[0])


WORLD = Rectangle(Place(0.0, 0.0, 0.0), (0.0, 0.0))
"""The host of what has no parent."""


def footprint(box: OrientedBox) -> Rectangle:
    """A box seen from above; of a tilted one its own extents, not their shadow."""
    return Rectangle(Place(box.p[0], box.p[1], box.yaw_rad), (box.s[0] / 2, box.s[1] / 2))


def turned_reach_m(half_m: Half, turn_rad: float) -> Half:
    """How far a turned rectangle reaches along the axes it is turned against."""
    cos, sin = abs(math.cos(turn_rad)), abs(math.sin(turn_rad))
    return cos * half_m[0] + sin * half_m[1], sin * half_m[0] + cos * half_m[1]


def hull(rectangles: Sequence[Rectangle]) -> Rectangle:
    """The least rectangle about some, along the axes of the first."""
    place = rectangles[0].place
    low, high = [math.inf, math.inf], [-math.inf, -math.inf]
    for each in rectangles:
        u_m, v_m, turn_rad = place.local(each.place)
        reach_m = turned_reach_m(each.half_m, turn_rad)
        for axis, at_m in enumerate((u_m, v_m)):
            low[axis] = min(low[axis], at_m - reach_m[axis])
            high[axis] = max(high[axis], at_m + reach_m[axis])
    middle = place.moved((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    return Rectangle(middle, ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2))


def nearest_quadrant(turn_rad: float) -> tuple[int, float]:
    """Quarter turns nearest to a turn, 0 to 3, and what is left."""
    count = round(turn_rad / QUARTER)
    return count % 4, turn_rad - count * QUARTER
