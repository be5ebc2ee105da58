"""Streets of a district, and the blocks between them.

Streets lead from border to border. Those to the east are laid in one piece, those to the north from
one of these to the next, so that all ends meet. A piece is left out here and there: two blocks
become one, and streets end at others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Rectangle, Side
from aeroscene.corpus.curation.site import PARKING_LANE_M, Site
from aeroscene.solids.shapes.forms import FORMS

_BLOCK_M = 54.0
"""Typical side of a block, with half of the streets around it."""
_UNEVEN = 0.14
"""Share by which a street lies off its even place."""
_CARRIAGEWAYS_M = (5.6, 6.0, 6.4, 7.0)
_PARKED_CHANCE = 0.5
"""Probability that vehicles are parked along a street on both sides."""
_JOINED_CHANCE = 0.2


@dataclass(frozen=True, slots=True)
class Block:
    """Ground between streets, which is to be filled with places."""

    area: Rectangle
    street_sides: tuple[Side, ...]
    """Sides along which a street runs; the district ends at the others."""


@dataclass(frozen=True, slots=True)
class Network:
    """Streets of a district, and the ground between them."""

    site: Site
    """Site of the carriageways."""
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True)
class _Street:
    middle: float
    """Place across the street, m."""
    width: float
    parking: tuple[int, ...]


def lay_network(sides_m: tuple[float, float], rng: np.random.Generator) -> Network:
    """Lay the streets of a district about the origin.

    Args:
        sides_m: Sides along east and north.
        rng: Draws places and widths of the streets.

    Returns:
        The carriageways, in a builder of their own, and the blocks between them.
    """
    half_x, half_y = sides_m[0] / 2, sides_m[1] / 2
    builder = Builder("streets")
    builder.enclose((-half_x, -half_y), (half_x, half_y))
    style = {name: str(rng.choice(list(FORMS[name]))) for name in ("road", "sidewalk")}
    # One width of sidewalk and one form of street for all, as a town has.
    walk_m = round(float(rng.uniform(2.0, 2.8)), 2)
    site = Site(builder, Frame(0.0, 0.0, 0.0), half_x, half_y, 6.0, walk_m, style=style)
    columns, rows = _streets(sides_m[0], rng), _streets(sides_m[1], rng)
    for street in rows:
        _lay(site, street, Frame(0.0, street.middle, 0.0), sides_m[0], 0)
    blocks: list[Block] = []
    for low, high, sides in _spans(rows, half_y, ("south", "north")):
        # Drawn anew for each row of blocks, so that streets to the north end at others.
        kept = _kept(columns, rng)
        for street in kept:
            middle = Frame(street.middle, (low + high) / 2, pi / 2)
            # People cross at the end that meets another street.
            _lay(site, street, middle, high - low, 1 if "north" in sides else -1)
        for west, east, flanks in _spans(kept, half_x, ("west", "east")):
            blocks.append(Block(Rectangle(west, low, east, high), (*sides, *flanks)))
    return Network(site, tuple(blocks))


def _lay(site: Site, street: _Street, frame: Frame, length: float, zebra_end: int) -> None:
    site.road_m, site.parking = street.width, street.parking
    site.lay_road(frame, round(length, 3), zebra_end=zebra_end)


def _streets(side_m: float, rng: np.random.Generator) -> list[_Street]:
    """Draw streets across one direction, at uneven distances."""
    # Two blocks at least, so that there is a street.
    n_blocks = max(2, round(side_m / _BLOCK_M))
    even = side_m / n_blocks
    found: list[_Street] = []
    for number in range(1, n_blocks):
        middle = number * even - side_m / 2 + float(rng.uniform(-_UNEVEN, _UNEVEN)) * even
        parking = (-1, 1) if rng.random() < _PARKED_CHANCE else ()
        width = float(rng.choice(_CARRIAGEWAYS_M)) + PARKING_LANE_M * len(parking)
        # Centimetres, because carriageways become objects.
        found.append(_Street(round(middle, 2), round(width, 2), parking))
    return found


def _kept(streets: Sequence[_Street], rng: np.random.Generator) -> list[_Street]:
    """Leave some streets of a row of blocks out, never two side by side, and never all."""
    kept: list[_Street] = []
    was_left_out = False
    for street in streets:
        was_left_out = not was_left_out and len(streets) > 2 and rng.random() < _JOINED_CHANCE
        if not was_left_out:
            kept.append(street)
    return kept


def _spans(
    streets: Sequence[_Street], half: float, sides: tuple[Side, Side]
) -> list[tuple[float, float, tuple[Side, ...]]]:
    """Intervals between streets and borders, each with its ends at which a street runs."""
    found: list[tuple[float, float, tuple[Side, ...]]] = []
    low, low_sides = -half, ()
    for street in streets:
        found.append((low, round(street.middle - street.width / 2, 3), (*low_sides, sides[1])))
        low, low_sides = round(street.middle + street.width / 2, 3), (sides[0],)
    found.append((low, half, low_sides))
    return found
