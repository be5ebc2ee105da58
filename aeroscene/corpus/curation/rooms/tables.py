"""Chairs around tables, and the plates and cups before them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.scene import Vector3

_SEAT_PITCH_M = 0.75
"""Distance between the middles of chairs side by side."""
_BESIDE_M = 0.04
"""Gap between a plate and the cup beside it."""
_KEEPS_M = (0.8, 0.55)
"""Distance of a free-standing table from everything, at first and if that finds no place."""
LAID_AT_ONCE = 2
"""Number of places that are laid in one step."""


def stand_table(room: Interior, size: Vector3, turn: float | None = None) -> Placed | None:
    """Stand a table in the open if there is space, or else against a wall.

    Args:
        room: Room to furnish.
        size: Extents.
        turn: Turn to try first, 0 or pi / 2, rad; drawn by default.
    """
    turn = (0.0 if room.draw.chance(0.5) else pi / 2) if turn is None else turn
    for keep in _KEEPS_M:
        for heading in (turn, pi / 2 - turn):
            table = room.anywhere("table", size, keep=keep, turn=heading)
            if table:
                return table
    return room.against(room.some_side(), "table", size)


def seats(room: Interior, table: Placed | None, count: int, name: str = "chair") -> list[Placed]:
    """Stand chairs along the long sides of a table, facing it.

    Args:
        room: Room of the table.
        table: Table; None gives no chairs.
        count: Most chairs.
        name: Category of the seats.

    Returns:
        The chairs that found space.
    """
    if table is None:
        return []
    x, y, _ = table.size
    found: list[Placed] = []
    per_side = max(1, int(y // _SEAT_PITCH_M))
    size = room.draw.size_of(name)
    # In turn on both sides, so that two chairs face each other.
    for index in range(min(count, 2 * per_side)):
        sign = 1 if index % 2 else -1
        v = (index // 2 - (per_side - 1) / 2) * _SEAT_PITCH_M
        turn = pi if sign > 0 else 0.0
        chair = room.beside(table, name, sign * (x / 2 + size[0] / 2 + 0.08), v, turn, size)
        if chair:
            found.append(chair)
    return found


def lay(room: Interior, table: Placed | None, chairs: Sequence[Placed]) -> None:
    """Lay a plate with a cup beside it before each chair of a table.

    Args:
        room: Room of the table.
        table: Table; None does nothing.
        chairs: Chairs at the table; a place that is too narrow stays empty.
    """
    if table is None:
        return
    x = table.size[0] / 2
    plate, cup = (room.draw.size_of(name) for name in ("plate", "cup"))
    for chair in chairs:
        u, v = table.frame.local(chair.frame.x, chair.frame.y)
        sign = 1.0 if u > 0 else -1.0
        turn = pi if sign > 0 else 0.0
        at = sign * (x - plate[0] / 2 - 0.03)
        # No plate, no cup: the place is too narrow.
        if room.lie(table, "plate", at, v, plate, turn) is None:
            continue
        across = sign * (plate[1] / 2 + _BESIDE_M + cup[1] / 2)
        room.lie(table, "cup", at, v - across, cup, turn)


def lay_all(room: Interior, table: Placed | None, chairs: Sequence[Placed]) -> Iterator[None]:
    """Lay places for all chairs, `LAID_AT_ONCE` in each step."""
    for first in range(0, len(chairs), LAID_AT_ONCE):
        lay(room, table, chairs[first : first + LAID_AT_ONCE])
        yield
