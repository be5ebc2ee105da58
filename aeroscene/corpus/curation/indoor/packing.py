"""Division of a row of rooms, so that each is about as large as its use asks for."""

from __future__ import annotations

from collections import deque
from itertools import pairwise

from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.zones import snapped
from aeroscene.corpus.curation.rooms.uses import MOST_ASPECT, USES

LEAST_ROOM_M = 3.1
"""Shortest room along a row: a door of 1.75 m between its jambs, and walls."""
_GIVE = {"bathroom": 0.2, "washroom": 0.3, "store": 0.5}
"""Willingness of a room to grow when a row is filled up; 1 for all other kinds."""


def pack_row(
    draw: Draw, kinds: deque[str], low: float, high: float, depth: float
) -> list[tuple[str, float, float]]:
    """Divide a row into rooms, from its low end to its high one.

    The row takes rooms until the next one would leave it fuller than without it, and stretches them
    all to fill the row.

    Args:
        draw: Areas, each within the range of its use.
        kinds: Kinds of the rooms in turn; rotated to the kind with which the next row begins.
        low: Start of the row, m.
        high: End of the row.
        depth: Width of the row, m.

    Returns:
        Kind, start and end of each room.
    """
    length = high - low
    rooms: list[tuple[str, float]] = []
    taken = 0.0
    while True:
        wanted = _along(draw, kinds[0], depth)
        # Half a room too many is as far from the row's length as half a room too few.
        is_full = length - taken < 0.5 * wanted or (len(rooms) + 1) * LEAST_ROOM_M > length
        if rooms and is_full:
            break
        rooms.append((kinds[0], wanted))
        kinds.rotate(-1)
        taken += wanted
    return _stretched(rooms, low, high)


def _along(draw: Draw, kind: str, depth: float) -> float:
    """Length that a room of a kind takes along a row of a depth."""
    wanted = USES[kind].draw_area(draw) / depth
    return max(LEAST_ROOM_M, depth / MOST_ASPECT, min(wanted, MOST_ASPECT * depth))


def _stretched(
    rooms: list[tuple[str, float]], low: float, high: float
) -> list[tuple[str, float, float]]:
    """Stretch rooms end to end from low to high, their borders in the middles of cells."""
    rest = high - low - sum(along for _, along in rooms)
    if rest > 0:
        weights = [along * _GIVE.get(kind, 1.0) for kind, along in rooms]
    else:
        # Rooms shrink in proportion to the length that they can spare.
        weights = [along - LEAST_ROOM_M + 0.01 for _, along in rooms]
    ends = [low]
    at = low
    for (_, along), weight in zip(rooms[:-1], weights[:-1], strict=True):
        at += along + rest * weight / sum(weights)
        ends.append(snapped(at))
    ends.append(high)
    return [(kind, a, b) for (kind, _), (a, b) in zip(rooms, pairwise(ends), strict=True)]
