"""Buildings wall to wall along a line, as the streets of a town are built up.

A row is drawn as one length and cut into fronts of unequal width. Each front becomes a building of
its own with its own colour and height, because towns grow house by house.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import STREETWARD
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.solids.shapes.materials import WALL_COLOURS


@dataclass(frozen=True, slots=True, kw_only=True)
class Fronts:
    """Look of the buildings of a row, and width of their fronts."""

    category: str = "building"
    width_m: float
    """Typical width of a front."""
    least_m: float = 6.2
    """Narrowest front."""
    storeys: tuple[int, int]
    storey_m: float = 3.2
    forms: Sequence[str] = ("plain",)


def cut_fronts(ground: Ground, length_m: float, fronts: Fronts, *, is_even: bool) -> list[float]:
    """Cut a length into fronts, in whole centimetres.

    Args:
        ground: Parcel, whose randomness is used.
        length_m: Length to be filled.
        fronts: Typical and least width.
        is_even: True for equal widths.

    Returns:
        Widths, m, that add up to `length_m`, or to a little less if all are equal. A length below
        `least_m` gives no front.
    """
    draw = ground.draw
    most = int(length_m / fronts.least_m)
    if most < 1:
        return []
    count = min(most, max(1, round(length_m / fronts.width_m)))
    if is_even:
        # Rounded down, so that equal fronts never exceed the length.
        return [floor(100 * length_m / count) / 100] * count
    # A share of 1 is the narrowest front; what is left over goes to the fronts unevenly.
    spare = length_m - count * fronts.least_m
    shares = [draw.between(0.2, 1.0) for _ in range(count)]
    widths = [round(fronts.least_m + spare * share / sum(shares), 2) for share in shares]
    # The last front takes the rounding of all others.
    widths[-1] = round(length_m - sum(widths[:-1]), 2)
    return widths


def raise_row(
    ground: Ground,
    span: tuple[float, float],
    v: float,
    deep: float,
    fronts: Fronts,
    *,
    is_even: bool = False,
) -> list[Placed]:
    """Raise buildings side by side along the parcel's u axis, their fronts to the street.

    Args:
        ground: Parcel.
        span: Ends of the row along u, m.
        v: Place of the fronts, m from the street.
        deep: Depth of the buildings, m.
        fronts: Look of the buildings.
        is_even: True if all have the same width and height, like houses that were built together.

    Returns:
        Buildings that found space, in the order of u.
    """
    draw, at, row = ground.draw, span[0], []
    # One height for all if the row is even; drawn anew for each front otherwise.
    storeys = draw.count(*fronts.storeys)
    for width in cut_fronts(ground, round(span[1] - span[0], 2), fronts, is_even=is_even):
        if not is_even:
            storeys = draw.count(*fronts.storeys)
        look = {
            "colour": draw.one_of((*WALL_COLOURS, "brick")),
            "storeys": storeys,
            "form": draw.one_of(fronts.forms),
        }
        size = (deep, width, round(storeys * fronts.storey_m, 2))
        placed = ground.erect(
            fronts.category,
            at + width / 2,
            v + deep / 2,
            size,
            # No margin, because neighbours share a wall.
            turn=STREETWARD,
            margin=0.0,
            look=look,
        )
        row += [placed] if placed else []
        at += width
    return row
