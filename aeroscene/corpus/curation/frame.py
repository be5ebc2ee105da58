"""Plane frames in which the grammar of a place is written: u along, v across, a heading.

Places are written as if their street ran along x. Frames then turn them to any street.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

QUARTER = math.pi / 2
STREETWARD = -QUARTER
"""Turn of an object that faces the street, if the frame's v axis leads away from the street."""
INWARD = QUARTER
"""Turn of an object that faces away from the street."""


@dataclass(frozen=True, slots=True)
class Frame:
    """An origin and a heading in the world's horizontal plane; the heading turns from east, rad."""

    x: float
    y: float
    yaw: float

    def point(self, u: float, v: float) -> tuple[float, float]:
        """World position of local coordinates, m."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return (self.x + c * u - s * v, self.y + s * u + c * v)

    def moved(self, u: float, v: float, turn: float = 0.0) -> Frame:
        """Give the frame at a local place.

        Args:
            u: Place along the frame's x axis, m.
            v: Place along its y axis, m.
            turn: Angle by which the new frame is turned, rad, counter-clockwise.
        """
        x, y = self.point(u, v)
        return Frame(x, y, self.yaw + turn)

    def local(self, x: float, y: float) -> tuple[float, float]:
        """Local coordinates of a world position, m: the inverse of `point`."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        dx, dy = x - self.x, y - self.y
        return (c * dx + s * dy, c * dy - s * dx)
