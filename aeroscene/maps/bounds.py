"""Bounds of the part of a map that becomes a scene: west, south, east, north in degrees."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aeroscene.scene import SceneError
from aeroscene.scene.errors import shown
from aeroscene.scene.origin import metres_per_degree

MAX_SIDE_M = 400.0
"""Longest side of a place; a longer one takes gigabytes for the free space between buildings."""
MIN_SIDE_M = 20.0
"""Shortest side: a drone needs some room to take off and to land elsewhere."""
ALTITUDE_M = 0.0
"""Height of the ground above the sea; maps do not state it."""
_VALID = (
    "W,S,E,N in degrees, west below east and south below north, such as "
    "13.4000,52.5100,13.4020,52.5115"
)
_ROUNDING = 1.0 + 1e-6
"""Factor by which bounds may exceed the limit: seven decimals round them."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """A rectangle on the globe, in degrees."""

    west: float
    south: float
    east: float
    north: float

    @property
    def latitude_deg(self) -> float:
        """Latitude of the middle, degrees."""
        return round((self.south + self.north) / 2, 7)

    @property
    def longitude_deg(self) -> float:
        """Longitude of the middle, degrees."""
        return round((self.west + self.east) / 2, 7)

    @property
    def size_m(self) -> tuple[float, float]:
        """Lengths from west to east and from south to north, m."""
        north_m, east_m = metres_per_degree(self.latitude_deg, ALTITUDE_M)
        return ((self.east - self.west) * east_m, (self.north - self.south) * north_m)

    def __str__(self) -> str:
        """Text as users write bounds."""
        return ",".join(f"{value:.7f}".rstrip("0").rstrip(".") for value in self.values)

    @property
    def values(self) -> tuple[float, float, float, float]:
        """West, south, east, north, degrees."""
        return (self.west, self.south, self.east, self.north)

    def grown(self, margin_m: float) -> Bounds:
        """The same rectangle with a margin on all sides.

        Args:
            margin_m: Width of the margin, m; a negative one shrinks the rectangle.
        """
        north_m, east_m = metres_per_degree(self.latitude_deg, ALTITUDE_M)
        x, y = margin_m / east_m, margin_m / north_m
        return Bounds(self.west - x, self.south - y, self.east + x, self.north + y)


def parse_bounds(text: str) -> Bounds:
    """Parse the bounds that a user names.

    Args:
        text: W,S,E,N in degrees.

    Raises:
        SceneError: If the text states no bounds, or they are too large or too small for a scene.
    """
    parts = text.split(",")
    try:
        values = [float(part) for part in parts]
    except ValueError:
        values = []
    if len(values) != 4 or not _is_rectangle(*values):
        raise SceneError(f"bounds are {shown(text)}; valid: {_VALID}")
    bounds = Bounds(*values)
    require_size(bounds, "bounds are")
    return bounds


def is_rectangle(bounds: Bounds) -> bool:
    """Return true if bounds are a rectangle on the globe."""
    return _is_rectangle(*bounds.values)


def _is_rectangle(west: float, south: float, east: float, north: float) -> bool:
    if not all(map(math.isfinite, (west, south, east, north))):
        return False
    # Near the poles a degree of longitude has hardly any length.
    return -180 <= west < east <= 180 and -85 <= south < north <= 85


def require_size(bounds: Bounds, subject: str) -> None:
    """Refuse bounds that are too large or too small; the message proposes some of a valid size.

    Args:
        bounds: Bounds.
        subject: Beginning of the message, such as `bounds are`.

    Raises:
        SceneError: If a side is out of range.
    """
    x_m, y_m = bounds.size_m
    if min(x_m, y_m) >= MIN_SIDE_M and max(x_m, y_m) <= MAX_SIDE_M * _ROUNDING:
        return
    raise SceneError(
        f"{subject} {x_m:.0f} x {y_m:.0f} m; valid: {MIN_SIDE_M:g} to {MAX_SIDE_M:g} m a side, "
        f"such as {middle_of(bounds)}"
    )


def middle_of(bounds: Bounds, side_m: float = 200.0) -> Bounds:
    """A square in the middle of some bounds, rounded to five decimals, which are about a metre.

    Args:
        bounds: Bounds.
        side_m: Length of its sides, m.
    """
    # Bounds of no size, which grow to all sides.
    point = Bounds(*(2 * (bounds.longitude_deg, bounds.latitude_deg)))
    grown = point.grown(side_m / 2)
    return Bounds(*(round(value, 5) for value in grown.values))
