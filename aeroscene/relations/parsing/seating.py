"""Chairs at their tables: all chairs of a table are one group, with one gap and even pitches."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from aeroscene.relations.parsing import fits
from aeroscene.relations.placement import residual_of
from aeroscene.relations.plane import Rectangle
from aeroscene.relations.relation import (
    MAX_SEATS,
    SEAT_GAPS_M,
    Align,
    Array,
    Gap,
    Kind,
    Relation,
    Residual,
)

_PITCH_SHARES = (0.6, 1.15)
"""Distance of neighbouring seats, over that of equally many seats along the whole side."""
# Least distance of two seats, and number of pitches that are tried.
_MIN_PITCH_M = 0.35
_N_PITCHES = 12


@dataclass(frozen=True, slots=True)
class Seating:
    """Chairs of one table."""

    table_id: int
    members: tuple[int, ...]
    """Ids in the order of the array's places."""
    relation: Relation
    array: Array | None
    """None for a chair that stands at no regular place of the side."""
    residual: Residual


@dataclass(frozen=True, slots=True)
class _Chair:
    id: int
    outline: Rectangle
    side: int
    along_m: float
    gap_m: float


def find_seats(
    tables: Mapping[int, Rectangle], chairs: Mapping[int, Rectangle]
) -> Iterator[Seating]:
    """Yield the chairs that stand at tables, table by table.

    A chair that could belong to several tables belongs to the one with the smallest gap.

    Args:
        tables: Outlines of tables by id.
        chairs: Outlines of chairs by id.
    """
    drawn_up: defaultdict[int, list[_Chair]] = defaultdict(list)
    for chair_id, outline in chairs.items():
        options: list[tuple[float, int, _Chair]] = []
        for table_id, table in tables.items():
            found = fits.seat(table, outline)
            if found is not None:
                chair = _Chair(chair_id, outline, *found)
                options.append((abs(chair.gap_m), table_id, chair))
        if options:
            _, table_id, chair = min(options, key=lambda option: option[:2])
            drawn_up[table_id].append(chair)
    for table_id, table in tables.items():
        if table_id in drawn_up:
            yield from _seated(table_id, table, drawn_up[table_id])


def _seated(table_id: int, table: Rectangle, chairs: list[_Chair]) -> list[Seating]:
    """Return one group of all chairs that share a gap and stand evenly, and the others alone."""
    middle_m = median(chair.gap_m for chair in chairs)
    # Chairs that are pulled out of the row are described by themselves.
    even = [chair for chair in chairs if abs(chair.gap_m - middle_m) <= fits.TOLERANCE_M]
    seats: dict[tuple[int, int], _Chair] = {}
    counts, pitch_m = [0, 0], [0.0, 0.0]
    for axis in (0, 1):
        pair = [chair for chair in even if chair.side % 2 == axis]
        # On the far side seats count in the other direction, but the places are the same.
        along_m = [(chair.side // 2, chair.along_m) for chair in pair]
        fitted = _fit_seats(along_m, 2 * table.reach_m(axis)[1]) if pair else None
        if fitted is not None:
            counts[axis], pitch_m[axis], numbers = fitted
            seats |= {(c.side, n): c for c, n in zip(pair, numbers, strict=True)}
    alone = [_by_itself(table_id, table, c) for c in chairs if c not in seats.values()]
    if not seats:
        return alone
    array = Array(
        rows=max(1, counts[0]), columns=max(1, counts[1]), pitch_m=(pitch_m[0], pitch_m[1])
    )
    places = array.cells(Kind.SEAT)
    holes = tuple(index for index, place in enumerate(places) if place not in seats)
    array = Array(rows=array.rows, columns=array.columns, pitch_m=array.pitch_m, holes=holes)
    gap = fits.gap_class(middle_m, 2 * fits.TOLERANCE_M, SEAT_GAPS_M)
    relation = Relation(kind=Kind.SEAT, gap=gap, align=Align.SLOT, quadrant=2)
    residual = Residual(u_m=middle_m - SEAT_GAPS_M[gap])
    members = tuple(seats[place].id for place in places if place in seats)
    return [Seating(table_id, members, relation, array, residual), *alone]


def _by_itself(table_id: int, table: Rectangle, chair: _Chair) -> Seating:
    gap = fits.gap_class(chair.gap_m, 2 * fits.TOLERANCE_M, SEAT_GAPS_M)
    relation = Relation(kind=Kind.SEAT, side=chair.side, gap=Gap(gap), quadrant=2)
    residual = residual_of(relation, table, chair.outline)
    return Seating(table_id, (chair.id,), relation, None, residual)


def _fit_seats(
    along_m: Sequence[tuple[int, float]], length_m: float
) -> tuple[int, float, list[int]] | None:
    """Fit evenly spaced seats along two opposite sides of a table.

    Args:
        along_m: Side (0 or 1 of the pair) and place from its middle of each chair.
        length_m: Length of the sides.

    Returns:
        Seats of a side, their pitch in m, and each chair's seat; None if chairs stand unevenly.
    """
    places = np.array([place for _, place in along_m])
    # The fewest seats that explain the chairs.
    for count in range(1, MAX_SEATS + 1):
        low_m, high_m = (share * length_m / count for share in _PITCH_SHARES)
        if count > 1 and high_m < _MIN_PITCH_M:
            return None
        for pitch_m in np.linspace(max(low_m, _MIN_PITCH_M), max(high_m, _MIN_PITCH_M), _N_PITCHES):
            seats = np.rint(places / pitch_m + (count - 1) / 2).clip(0, count - 1)
            at = seats - (count - 1) / 2
            # Least-squares pitch for these seats.
            best_m = float(at @ places / (at @ at)) if at.any() else float(pitch_m)
            off_m = np.abs(places - at * best_m).max()
            taken = {(side, seat) for (side, _), seat in zip(along_m, seats, strict=True)}
            if off_m <= fits.TOLERANCE_M and len(taken) == len(along_m) and best_m > 0:
                pitch = best_m if count > 1 else 0.0
                return count, pitch, seats.astype(int).tolist()
    return None
