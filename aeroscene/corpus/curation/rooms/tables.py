"""Chairs around tables and what is laid before them."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.interior import Interior

_SEAT_PITCH_M = 0.75
"""Distance between the middles of chairs side by side."""


def seats(room: Interior, table: Placed | None, count: int, name: str = "chair") -> list[Placed]:
    """Chairs along the long sides of a table, facing it."""
    if table is None:
        return []
    x, y, _ = table.size
    found: list[Placed] = []
    per_side = max(1, int(y // _SEAT_PITCH_M))
    for index in range(min(count, 2 * per_side)):
        sign = 1 if index % 2 else -1
        size = room.draw.size_of(name)
        v = (index // 2 - (per_side - 1) / 2) * _SEAT_PITCH_M
        turn = pi if sign > 0 else 0.0
        chair = room.beside(table, name, sign * (x / 2 + size[0] / 2 + 0.08), v, turn, size)
        if chair:
            found.append(chair)
    return found


def lay(room: Interior, table: Placed | None, chairs: Sequence[Placed]) -> None:
    """A plate with a cup and cutlery before each chair of a table."""
    if table is None:
        return
    x = table.size[0] / 2
    for chair in chairs:
        u, v = table.frame.local(chair.frame.x, chair.frame.y)
        sign = 1.0 if u > 0 else -1.0
        for name, inward, across in (
            ("plate", 0.17, 0.0),
            ("cutlery", 0.17, 0.22),
            ("cup", 0.36, -0.2),
        ):
            size = room.draw.size_of(name)
            turn = pi if sign > 0 else 0.0
            room.lie(table, name, sign * (x - inward), v + sign * across, size, turn)
