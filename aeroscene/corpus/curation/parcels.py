"""Rectangles, blocks and parcels: how the ground of a site is divided."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import Frame

Side = str
"""south, east, north or west."""


@dataclass(frozen=True, slots=True)
class Land:
    """What a part of the site lies on: the flat ground, or a raised bank."""

    level: float = 0.0
    bearer: Placed | None = None
    """The terrain that carries it."""


FLAT = Land()


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle along the axes of the plan, m."""

    x0: float
    y0: float
    x1: float
    y1: float

    def side_frame(self, side: Side) -> tuple[Frame, float, float]:
        """Frame in the middle of a side with v inwards, the side's length, and the depth."""
        x, y = (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2
        width, depth = self.x1 - self.x0, self.y1 - self.y0
        return {
            "south": (Frame(x, self.y0, 0.0), width, depth),
            "east": (Frame(self.x1, y, math.pi / 2), depth, width),
            "north": (Frame(x, self.y1, math.pi), width, depth),
            "west": (Frame(self.x0, y, -math.pi / 2), depth, width),
        }[side]

    def without(self, side: Side, strip: float) -> Rectangle:
        """What is left when a strip along one side is taken away."""
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
    """Kinds of places of which one should fill it."""


@dataclass(frozen=True, slots=True)
class Parcel:
    """Ground for one place: u along the street, v from the street (0) to the back (depth)."""

    frame: Frame
    width: float
    depth: float
    level: float = 0.0
    """Height of the ground that the place starts from."""
    rise: float = 0.0
    """Climb of the ground from the street to the back, m."""
    bearer: Placed | None = None
    """Terrain that carries the parcel."""
    uses: tuple[str, ...] = ()
    """Kinds of places of which the plan wants one here; any where empty."""

    def middle(self) -> Frame:
        """The same frame moved to the middle of the parcel."""
        return self.frame.moved(0.0, self.depth / 2)


_WHOLE_M = 40.0
"""Fronts up to this length stay whole."""
_PARCEL_M = 28.0
"""About the width of the parcels that a longer front is cut into."""


def cut_unequal(
    width: float, rng: np.random.Generator, piece_m: float = _PARCEL_M
) -> Sequence[tuple[float, float]]:
    """Intervals about zero that fill a width, each its own length, about `piece_m` on average."""
    if width < _WHOLE_M:
        return [(-width / 2, width / 2)]
    count = max(2, round(width / piece_m + float(rng.uniform(-0.8, 0.3))))
    shares = rng.uniform(0.75, 1.35, count)
    borders = np.concatenate([[0.0], np.cumsum(shares / shares.sum())]) * width - width / 2
    cuts = [round(float(border), 2) for border in borders[1:-1]]
    return list(zip([-width / 2, *cuts], [*cuts, width / 2], strict=True))
