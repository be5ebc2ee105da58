"""Furniture that touches: in line along a wall, or in pairs in the open."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from aeroscene.corpus.curation.builder import Attributes, Placed
from aeroscene.corpus.curation.frame import QUARTER
from aeroscene.corpus.curation.rooms.interior import GAP_M, Interior
from aeroscene.scene import Vector3

Piece = tuple[str, Vector3]


def fit_line(room: Interior, pieces: Sequence[Piece], side: str | None = None) -> list[Placed]:
    """Stand furniture end to end with its backs to a wall: in a corner, or in the middle.

    Tries the walls in a random order, a named one first, and then again without the last piece.

    Args:
        room: Room to furnish.
        pieces: Categories and sizes, in order along the wall.
        side: Wall to try first.

    Returns:
        The pieces that stand.
    """
    walls = [room.sides[i] for i in room.draw.shuffled(range(len(room.sides)))]
    walls.sort(key=lambda wall: wall != side)
    for count in range(len(pieces), 0, -1):
        for wall in walls:
            start = _free_start(room, pieces[:count], wall)
            if start is not None:
                return _stand_line(room, pieces[:count], wall, start)
    return []


def _free_start(room: Interior, pieces: Sequence[Piece], wall: str) -> float | None:
    """Start of the line along a wall at which all its pieces have space; None if there is none."""
    frame, length = room.wall(wall)
    total = sum(size[1] for _, size in pieces)
    play = length - total - 2 * GAP_M
    if play < 0:
        return None
    low = -length / 2 + GAP_M
    # The corners first, then the middle, then the quarters.
    for start in (low, low + play, low + play / 2, low + play / 4, low + 3 * play / 4):
        at, is_free = start, True
        for _, (deep, wide, high) in pieces:
            spot = frame.moved(at + wide / 2, deep / 2 + GAP_M, QUARTER)
            # Two gaps, because a piece between others touches them without one.
            is_free = is_free and room.is_free(spot, (deep + 2 * GAP_M, wide + 2 * GAP_M, high))
            at += wide
        if is_free:
            return start
    return None


def _stand_line(room: Interior, pieces: Sequence[Piece], wall: str, start: float) -> list[Placed]:
    frame, _ = room.wall(wall)
    found: list[Placed] = []
    at = start
    for name, size in pieces:
        spot = frame.moved(at + size[1] / 2, size[0] / 2 + GAP_M, QUARTER)
        # No margin: pieces of a line touch.
        placed = room.stand(name, spot, size, 0.0)
        found += [placed] if placed else []
        at += size[1]
    return found


def stand_pair(
    room: Interior,
    name: str,
    u: float,
    v: float,
    size: Vector3,
    turn: float,
    look: Attributes | None = None,
) -> list[Placed]:
    """Stand two equal objects back to back in the open, if there is space for both.

    Args:
        room: Room to furnish.
        name: Category.
        u: Middle of the pair along the room's x axis, m.
        v: Middle of the pair along its y axis, m.
        size: Extents of one object.
        turn: Turn of the first object in the room's frame, rad.
        look: Attributes of each.

    Returns:
        The objects that stand.
    """
    middle = room.room.frame.moved(u, v, turn)
    envelope = (2 * size[0] + 2 * GAP_M, size[1] + 2 * GAP_M, size[2])
    if not room.is_free(middle, envelope):
        return []
    found = (
        room.stand(name, middle.moved(sign * size[0] / 2, 0.0, heading), size, 0.0, look)
        for sign, heading in ((1, 0.0), (-1, pi))
    )
    return [placed for placed in found if placed]
