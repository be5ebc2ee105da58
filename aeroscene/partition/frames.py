"""Frames: rectangles on the ground with a heading, and the boxes over them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from aeroscene.scene.box import MIN_SIZE_M, OrientedBox, quat_from_yaw

Point2 = tuple[float, float]
Bounds = tuple[float, float, float, float]
"""Rectangle as x0, y0, x1, y1, in m."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A rectangle with a heading.

    Its own coordinates are in m from its south-western corner, along its own axes.
    """

    x_enu_m: float
    """East coordinate of its middle."""
    y_enu_m: float
    """North coordinate of its middle."""
    yaw_rad: float
    length_m: float
    """Extent along its own x axis."""
    width_m: float
    """Extent along its own y axis."""

    def point(self, u: float, v: float) -> Point2:
        """Return the world position of own coordinates."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        du, dv = u - self.length_m / 2, v - self.width_m / 2
        return (self.x_enu_m + c * du - s * dv, self.y_enu_m + s * du + c * dv)

    def local(self, x: float, y: float) -> Point2:
        """Return the own coordinates of a world position."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        dx, dy = x - self.x_enu_m, y - self.y_enu_m
        return (c * dx + s * dy + self.length_m / 2, c * dy - s * dx + self.width_m / 2)

    def inner(self, bounds: Bounds, turn_rad: float = 0.0) -> Frame:
        """Return the frame over a rectangle in own coordinates.

        Args:
            bounds: The rectangle.
            turn_rad: Turn about the rectangle's own middle.
        """
        x0, y0, x1, y1 = bounds
        x, y = self.point((x0 + x1) / 2, (y0 + y1) / 2)
        return Frame(x, y, self.yaw_rad + turn_rad, x1 - x0, y1 - y0)

    def bounds_of(self, other: Frame) -> Bounds:
        """Return the own coordinates of an aligned frame.

        Args:
            other: Frame whose heading differs by quarter turns, up to a small rest that is ignored.
        """
        quarter, _ = nearest_quarter(other.yaw_rad - self.yaw_rad)
        du, dv = other.length_m / 2, other.width_m / 2
        # After a quarter turn length and width are exchanged.
        du, dv = (du, dv) if quarter % 2 == 0 else (dv, du)
        u, v = self.local(other.x_enu_m, other.y_enu_m)
        return (u - du, v - dv, u + du, v + dv)

    def box(self, quarter: int, base_m: float, top_m: float) -> OrientedBox:
        """Return the box over all of the frame.

        Args:
            quarter: Quarter turns of the box's x axis from the frame's.
            base_m: Height of its underside.
            top_m: Height of its upper face. Sides that are too short for a box become longer.
        """
        sides = (self.length_m, self.width_m, top_m - base_m)
        x_m, y_m, z_m = (max(side, MIN_SIZE_M) for side in sides)
        return OrientedBox(
            p=(self.x_enu_m, self.y_enu_m, (base_m + top_m) / 2),
            q=quat_from_yaw(self.yaw_rad + quarter * math.pi / 2),
            # After an odd number of quarter turns length and width are exchanged.
            s=(x_m, y_m, z_m) if quarter % 2 == 0 else (y_m, x_m, z_m),
        )


def frame_of(box: OrientedBox, yaw_rad: float | None = None) -> Frame:
    """Return the frame over a box.

    Args:
        box: The box; its tilt is ignored.
        yaw_rad: Heading of the frame, off the box's by quarter turns; None takes the box's own.
    """
    found = Frame(box.p[0], box.p[1], box.yaw_rad, box.s[0], box.s[1])
    if yaw_rad is None:
        return found
    # An empty frame at the origin serves as a coordinate system.
    plane = Frame(0.0, 0.0, yaw_rad, 0.0, 0.0)
    return plane.inner(plane.bounds_of(found))


def nearest_quarter(angle_rad: float) -> tuple[int, float]:
    """Return the nearest number of quarter turns, 0 to 3, and the remainder, rad."""
    quarter = round(angle_rad / (math.pi / 2))
    return quarter % 4, angle_rad - quarter * math.pi / 2


def hull_of(all_bounds: Iterable[Bounds]) -> Bounds:
    """Return the smallest rectangle around others."""
    x0, y0, x1, y1 = zip(*all_bounds, strict=True)
    return (min(x0), min(y0), max(x1), max(y1))
