"""Plots: turned rectangles on the ground that keep a distance from each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aeroscene.scene import Vector3

Place = tuple[float, float, float]
"""East and north of the middle (m), and heading (rad)."""


@dataclass(frozen=True, slots=True)
class Plot:
    """A turned rectangle."""

    x: float
    y: float
    cosine: float
    sine: float
    half_length_m: float
    half_width_m: float
    radius_m: float

    @classmethod
    def at(cls, place: Place, size_m: Vector3) -> Plot:
        """Give the ground that an upright box covers.

        Args:
            place: Middle and heading of the box.
            size_m: Extents of the box; the height does not matter.
        """
        x, y, yaw_rad = place
        half_length_m, half_width_m = size_m[0] / 2, size_m[1] / 2
        radius_m = math.hypot(half_length_m, half_width_m)
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        return cls(x, y, c, s, half_length_m, half_width_m, radius_m)

    @property
    def reach_m(self) -> tuple[float, float]:
        """Greatest distance from the middle towards east and north, m."""
        c, s = abs(self.cosine), abs(self.sine)
        return (
            c * self.half_length_m + s * self.half_width_m,
            s * self.half_length_m + c * self.half_width_m,
        )

    def corners(self) -> list[tuple[float, float]]:
        """Give the four corners, counter-clockwise, east and north, m."""
        u, v = self.half_length_m, self.half_width_m
        return [
            (self.x + a * self.cosine - b * self.sine, self.y + a * self.sine + b * self.cosine)
            for a, b in ((u, v), (-u, v), (-u, -v), (u, -v))
        ]

    def is_apart(self, other: Plot, gap_m: float) -> bool:
        """Return true if two plots keep a distance, along a side of either.

        Args:
            other: The other plot.
            gap_m: Least width of the strip between them.
        """
        dx, dy = other.x - self.x, other.y - self.y
        # Circles around both decide most pairs.
        if math.hypot(dx, dy) >= self.radius_m + other.radius_m + gap_m:
            return True
        return self._is_beyond(other, dx, dy, gap_m) or other._is_beyond(self, dx, dy, gap_m)

    def _is_beyond(self, other: Plot, dx: float, dy: float, gap_m: float) -> bool:
        c, s = self.cosine, self.sine
        # Cosine and sine of the turn between the two.
        turn_c = abs(c * other.cosine + s * other.sine)
        turn_s = abs(c * other.sine - s * other.cosine)
        length_m = turn_c * other.half_length_m + turn_s * other.half_width_m
        width_m = turn_s * other.half_length_m + turn_c * other.half_width_m
        ahead_m = abs(c * dx + s * dy) - self.half_length_m - length_m
        aside_m = abs(c * dy - s * dx) - self.half_width_m - width_m
        return max(ahead_m, aside_m) >= gap_m
