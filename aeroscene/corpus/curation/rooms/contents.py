"""Contents of furniture: objects on desks, worktops and cabinets, and on the boards of shelves."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.interior import GAP_M, Interior
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.storage import shelf_boards

_SLOT_M = 0.44
"""Length of furniture for one object."""
_SIDE_M = 0.03
"""Thickness of a shelf's sides."""
_RIM_M = 0.02
"""Distance of objects on furniture from its edges."""
_BETWEEN_M = 0.11
"""Thickness of a shelf's board and the air below it."""

HOME = ("book", "lamp", "plant", "box", "cup", "book")
KITCHEN = ("cup", "plate", "box", "cup", "plant", "plate")
PAPERS = ("book", "box", "book", "plant", "cup")
BOOKS = ("book", "book", "book", "box")
CARTONS = ("box",)


def strew(room: Interior, bearer: Placed | None, names: Sequence[str], count: int) -> None:
    """Lay objects along a piece of furniture, each at a place of its own.

    Objects that are too large for the furniture, or in the way of others, are left out.

    Args:
        room: Room of the furniture.
        bearer: Furniture; None does nothing, which saves callers a test.
        names: Categories, drawn for each object.
        count: Most objects.
    """
    if bearer is None:
        return
    slots = max(1, int(bearer.size[1] / _SLOT_M))
    for slot in room.draw.shuffled(range(slots))[:count]:
        name = room.draw.one_of(names)
        _lay_in_slot(room, bearer, name, _size_on_top(room, name), slot, slots)


def stock(room: Interior, shelf: Placed | None, names: Sequence[str] = BOOKS) -> None:
    """Fill the boards of an open shelf that its own shape leaves empty: every other one.

    Args:
        room: Room of the shelf.
        shelf: Open shelf; None does nothing.
        names: Categories, drawn for each object.
    """
    if shelf is None:
        return
    boards = shelf_boards(shelf.size[2])
    # All boards have the height of the uppermost.
    height = (shelf.size[2] - boards[-1]) - _BETWEEN_M
    slots = max(1, int((shelf.size[1] - 2 * _SIDE_M) / _SLOT_M))
    for rise in boards[1::2]:
        # One slot of each board stays empty, unless it is the only one.
        for slot in room.draw.shuffled(range(slots))[: max(1, slots - 1)]:
            name = room.draw.one_of(names)
            size = _size_on_board(room, name, shelf.size[0], height)
            if size[2] <= height:
                _lay_in_slot(room, shelf, name, size, slot, slots, rise)


def equip(
    room: Interior, desk: Placed | None, *, is_full: bool = True, end: float | None = None
) -> None:
    """Equip a desk with a chair, a screen and a cup, and, if full, a lamp and a book.

    A desk without space for a chair carries papers alone: nobody would look at its screen.

    Args:
        room: Room of the desk.
        desk: Desk; None does nothing.
        is_full: Use the other end of the desk as well.
        end: End of the screen along y, -1 or 1; drawn by default.
    """
    if desk is None:
        return
    draw = room.draw
    if room.in_front(desk, "chair") is None:
        strew(room, desk, PAPERS, 2)
        return
    if end is None:
        end = 1.0 if draw.chance(0.5) else -1.0
    if draw.chance(0.65):
        room.on(desk, "monitor", -0.5, end)
    else:
        room.on(desk, "laptop", 0.1, end)
    _lay_at(room, desk, draw.one_of(("cup", "book")), 0.9, 0.95 * end)
    if is_full:
        _lay_at(room, desk, draw.one_of(("lamp", "plant", "lamp")), -0.9, -end)
        _lay_at(room, desk, draw.one_of(("book", "cup")), 0.3, -0.6 * end)


def _lay_at(room: Interior, bearer: Placed, name: str, u: float, v: float) -> None:
    """Lay an object at fractions of the way from the middle of furniture to its edges."""
    size = _size_on_top(room, name)
    reach_u, reach_v = ((bearer.size[i] - size[i]) / 2 - _RIM_M for i in (0, 1))
    if min(reach_u, reach_v) >= 0:
        # Millimetres, like all places of objects.
        room.lie(bearer, name, round(u * reach_u, 3), round(v * reach_v, 3), size)


def _lay_in_slot(
    room: Interior,
    bearer: Placed,
    name: str,
    size: Vector3,
    slot: int,
    slots: int,
    rise: float | None = None,
) -> None:
    """Lay an object into one of the equal parts of furniture, on top or on a board.

    On a board it stands at the back, which another shelf may touch.
    """
    wide = (bearer.size[1] - 2 * _SIDE_M) / slots
    reach, play = (bearer.size[0] - size[0]) / 2 - _RIM_M, (wide - size[1]) / 2
    if reach < 0 or play < 0:
        return
    v = (slot - (slots - 1) / 2) * wide + room.draw.between(-1.0, 1.0) * play
    u = room.draw.between(-0.8, 0.4) * reach if rise is None else min(0.0, GAP_M - _RIM_M - reach)
    room.lie(bearer, name, round(u, 3), round(v, 3), size, rise=rise)


def _size_on_top(room: Interior, name: str) -> Vector3:
    """A size that suits the top of furniture, also for categories that stand on the floor."""
    draw = room.draw
    if name == "lamp":
        wide = draw.between(0.25, 0.3)
        return (wide, wide, draw.between(0.38, 0.52))
    if name == "plant":
        wide = draw.between(0.3, 0.36)
        return (wide, wide, draw.between(0.4, 0.6))
    if name == "box":
        return (draw.between(0.22, 0.32), draw.between(0.24, 0.38), draw.between(0.16, 0.3))
    return draw.size_of(name)


def _size_on_board(room: Interior, name: str, deep: float, high: float) -> Vector3:
    """Size for a shelf's board: a row of upright books, a box of the free height, or as on top."""
    x, y, z = _size_on_top(room, name)
    if name == "book":
        return (round(min(0.2, deep - 0.06), 2), room.draw.between(0.28, 0.38), 0.26)
    if name == "box":
        return (round(min(x, deep - 0.06), 2), y, min(z, floor(100 * high) / 100))
    return (x, y, z)
