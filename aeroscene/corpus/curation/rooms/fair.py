"""Exhibition halls: the stands of a fair."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import seats

_BOOTH_M = (2.7, 3.4)
"""Depth of a stand, and its share of the aisle."""
_AISLE_M = 3.2


def furnish_booths(room: Interior) -> Iterator[None]:
    """A fair: stands back to back in rows with aisles between."""
    x, y, _ = room.room.size
    along_y = y >= x
    deep, wide = _BOOTH_M
    # Two stands back to back and an aisle across, one stand along.
    pitch = (2 * deep + _AISLE_M, wide) if along_y else (wide, 2 * deep + _AISLE_M)
    across, along = deep + 0.3, wide / 2 + 0.2
    rims = (across, along) if along_y else (along, across)
    for u, v in room.spots(*pitch, rims, is_tight=True):
        # Two stands stand back to back at each place, and face opposite aisles.
        for turn in (0.0, pi) if along_y else (pi / 2, -pi / 2):
            yield from _booth(room, u, v, turn)
    yield from room.line_walls(("plant", "planter", "bench", "bin"), 6)


def _booth(room: Interior, u: float, v: float, turn: float) -> Iterator[None]:
    """Boards behind a desk with a chair, a table for guests, a plant; the aisle is ahead."""
    draw = room.draw
    origin = Frame(u, v, turn)
    for side in (-1, 1):
        at = origin.point(0.15, side * 0.7)
        room.put("sign", *at, (0.2, 1.3, 2.3), turn)
    desk = room.put("desk", *origin.point(1.9, -0.6), (0.8, 1.6, 0.75), turn)
    room.behind(desk, "chair")
    room.on(desk, "laptop", 0.0, 0.7, turn=pi)
    yield
    table = room.put("table", *origin.point(1.6, 0.95), (0.8, 0.9, 0.76), turn)
    seats(room, table, 2)
    if draw.chance(0.5):
        room.on(table, "book", 0.2, 0.6)
    room.put("plant", *origin.point(0.6, -1.3), (0.6, 0.6, 1.4), turn)
    yield
