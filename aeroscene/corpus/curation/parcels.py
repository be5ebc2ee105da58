"""Rectangles, blocks and parcels: the division of a site's ground.

Streets cut a site into blocks, and blocks are cut into parcels, one for each place. All of them are
rectangles, so that a place can be written once and turned to any street.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import Frame

Side = str
"""One of south, east, north and west."""


@dataclass(frozen=True, slots=True)
class Land:
    """Base of a part of the site: the flat ground, or a raised bank."""

    level: float = 0.0
    bearer: Placed | None = None
    """Terrain object that carries it; None for the flat ground."""


FLAT = Land()


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle along the axes of the plan, m."""

    x0: float
    y0: float
    x1: float
    y1: float

    def side_frame(self, side: Side) -> tuple[Frame, float, float]:
        """Give a side's frame and sizes.

        Returns:
            Frame in the middle of the side with v inwards, the side's length, and the depth, m.
        """
        x, y = (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2
        width, depth = self.x1 - self.x0, self.y1 - self.y0
        return {
            "south": (Frame(x, self.y0, 0.0), width, depth),
            "east": (Frame(self.x1, y, math.pi / 2), depth, width),
            "north": (Frame(x, self.y1, math.pi), width, depth),
            "west": (Frame(self.x0, y, -math.pi / 2), depth, width),
        }[side]

    def without(self, side: Side, strip: float) -> Rectangle:
        """Give the rectangle without a strip along one side.

        Args:
            side: Side.
            strip: Width of the strip, m; less than the rectangle has there.
        """
        x0, y0, x1, y1 = self.x0, self.y0, self.x1, self.y1
        return {
            "south": Rectangle(x0, y0 + strip, x1, y1),
            "east": Rectangle(x0, y0, x1 - strip, y1),
            "north": Rectangle(x0, y0, x1, y1 - strip),
            "west": Rectangle(x0 + strip, y0, x1, y1),
        }[side]


@dataclass(frozen=True, slots=True)
class Block:
    """Ground between streets and the border of the site."""

    area: Rectangle
    street_sides: tuple[Side, ...]
    land: Land = FLAT
    uses: tuple[str, ...] = ()
    """Kinds of places, one of which should fill it."""


@dataclass(frozen=True, slots=True)
class Parcel:
    """Ground for one place: u along the street, v from the street (0) to the back (depth)."""

    frame: Frame
    width: float
    depth: float
    level: float = 0.0
    """Height of the ground at the street."""
    rise: float = 0.0
    """Climb of the ground from the street to the back, m."""
    bearer: Placed | None = None
    """Terrain that carries the parcel."""
    uses: tuple[str, ...] = ()
    """Kinds of places of which the plan wants one here; empty for any."""

    def middle(self) -> Frame:
        """The same frame moved to the middle of the parcel."""
        return self.frame.moved(0.0, self.depth / 2)


_WHOLE_M = 40.0
"""Length up to which a front stays whole."""
_PARCEL_M = 28.0
"""Typical width of the parcels into which a longer front is cut."""


def cut_unequal(
    width: float, rng: np.random.Generator, piece_m: float = _PARCEL_M
) -> Sequence[tuple[float, float]]:
    """Cut a width into intervals about zero, each with its own length.

    Args:
        width: Length to be filled, m.
        rng: Randomness.
        piece_m: Typical length of an interval.
    """
    if width < _WHOLE_M:
        return [(-width / 2, width / 2)]
    # Drawn to be rather fewer than would fit.
    count = max(2, round(width / piece_m + float(rng.uniform(-0.8, 0.3))))
    shares = rng.uniform(0.75, 1.35, count)
    borders = np.concatenate([[0.0], np.cumsum(shares / shares.sum())]) * width - width / 2
    # Centimetres, because parcels become objects and files have no more digits than they need.
    cuts = [round(float(border), 2) for border in borders[1:-1]]
    return list(zip([-width / 2, *cuts], [*cuts, width / 2], strict=True))
