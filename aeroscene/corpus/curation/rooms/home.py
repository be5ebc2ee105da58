"""Rooms of a home."""

from __future__ import annotations

from collections.abc import Iterator

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.contents import (
    BOOKS,
    CARTONS,
    HOME,
    KITCHEN,
    equip,
    stock,
    strew,
)
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.lines import Piece, fit_line
from aeroscene.corpus.curation.rooms.tables import lay, lay_all, seats, stand_table

_ENDS = ("left", "right")
_SMALL_M2 = 12.0
"""Area up to which rooms have a bed for one, and a small table."""


def furnish_living(room: Interior) -> Iterator[None]:
    """Stand sofa, coffee table and television in line; then armchairs, shelves, lamps, a table.

    The sofa faces the television across the room.
    """
    draw = room.draw
    # Opposite walls, so that the sofa faces the television.
    side, other = _ENDS if draw.chance(0.5) else _ENDS[::-1]
    sofa = room.against(side, "sofa")
    table = room.in_front(sofa, "coffee_table", gap=0.45)
    yield
    cabinet = room.against(other, "cabinet", (0.45, draw.between(1.4, 1.8), 0.72))
    room.on(cabinet, "television", 0.0, 0.0)
    yield
    # A lamp beside the sofa, at its head.
    if sofa:
        at = sofa.size[1] / 2 + 0.3
        stand = room.beside(sofa, "nightstand", -0.2, at, 0.0, (0.42, 0.5, 0.5))
        strew(room, stand, ("lamp",), 1)
    room.against("back", "armchair")
    yield
    strew(room, table, ("book", "cup", "plate"), 3)
    shelf = room.against(other, "shelf", (0.34, draw.between(0.9, 1.6), draw.between(1.8, 2.2)))
    yield
    stock(room, shelf)
    yield
    dining = stand_table(room, (0.9, draw.between(1.6, 1.8), 0.74))
    chairs = seats(room, dining, 4)
    yield
    yield from lay_all(room, dining, chairs[:2] if draw.chance(0.6) else chairs)
    room.against(side, "plant")
    room.against("front", "lamp", (0.4, 0.4, draw.between(1.5, 1.75)))
    yield
    strew(room, cabinet, HOME, 2)
    room.against(room.some_side(), "armchair")
    yield
    sideboard = room.against(room.some_side(), "cabinet")
    strew(room, sideboard, HOME, 3)
    yield
    room.against(room.some_side(), "plant")
    stock(room, room.against(room.some_side(), "shelf"), BOOKS)
    yield


def furnish_bedroom(room: Interior) -> Iterator[None]:
    """Stand a bed between nightstands with lamps, a wardrobe, a desk, drawers and a shelf."""
    draw = room.draw
    side, other = _ENDS if draw.chance(0.5) else _ENDS[::-1]
    wide = draw.between(0.9, 1.2) if room.area < _SMALL_M2 else draw.between(1.4, 1.8)
    bed = room.against(side, "bed", (2.02, wide, draw.between(0.5, 0.68)))
    stands = _flank(room, bed)
    yield
    wardrobe = room.against(other, "wardrobe")
    yield
    for stand in stands:
        strew(room, stand, ("lamp", "lamp", "book"), 1)
    yield
    desk = room.against(other, "desk", (0.65, draw.between(1.1, 1.4), 0.74))
    equip(room, desk, is_full=False)
    yield
    chest = room.against(room.some_side(), "cabinet", (0.45, draw.between(0.8, 1.3), 0.85))
    if draw.chance(0.44):
        room.on(chest, "television", 0.0, 0.0)
    strew(room, chest, HOME, 2)
    yield
    strew(room, wardrobe, CARTONS, 2)
    room.against("back", "plant")
    yield
    shelf = room.against(room.some_side(), "shelf", (0.3, draw.between(0.7, 1.2), 1.8))
    stock(room, shelf)
    yield
    room.against("front", "armchair")
    room.against(room.some_side(), "box")
    room.against(room.some_side(), "bin", (0.35, 0.35, 0.7))
    yield


def _flank(room: Interior, bed: Placed | None) -> list[Placed]:
    """Nightstands on both sides of a bed's head, as far as they fit."""
    if bed is None:
        return []
    found: list[Placed] = []
    for sign in (-1, 1):
        # At the head, which is at the wall.
        u, v = -bed.size[0] / 2 + 0.21, sign * (bed.size[1] / 2 + 0.28)
        stand = room.beside(bed, "nightstand", u, v, 0.0, (0.42, 0.5, 0.5))
        found += [stand] if stand else []
    return found


def furnish_kitchen(room: Interior) -> Iterator[None]:
    """Stand fridge, worktop, stove and worktop in line, another worktop, and a laid table."""
    draw = room.draw
    line = fit_line(room, _kitchen_line(room), draw.one_of(_ENDS))
    yield
    is_small = room.area < _SMALL_M2
    table = stand_table(room, (0.8 if is_small else 0.9, 1.2 if is_small else 1.6, 0.74))
    chairs = seats(room, table, 2 if is_small else 4)
    yield
    lay(room, table, chairs[:2])
    yield
    for top in (piece for piece in line if piece.name == "counter"):
        strew(room, top, KITCHEN, 2)
    yield
    yield from lay_all(room, table, chairs[2:])
    top = room.against(room.some_side(), "counter", (0.62, draw.between(1.2, 1.8), 0.92))
    strew(room, top, KITCHEN, 3)
    yield
    shelf = room.against(room.some_side(), "shelf", (0.34, draw.between(0.7, 1.1), 1.9))
    stock(room, shelf, ("box", "plate", "cup"))
    room.against("back", "bin", (0.4, 0.4, 0.75))
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    strew(room, cabinet, KITCHEN, 3)
    room.against(room.some_side(), "plant")
    yield


def _kitchen_line(room: Interior) -> list[Piece]:
    """Furniture of a kitchen's wall: two worktops if there is space for both, else one."""
    draw = room.draw
    # Without the fridge and the stove.
    space = max(room.room.size[:2]) - 1.4
    count = 2 if space >= 2.7 else 1
    tops = [
        ("counter", (0.62, draw.between(1.2, max(1.21, min(1.9, space / count))), 0.92))
        for _ in range(count)
    ]
    stove = ("stove", (0.62, 0.6, 0.92))
    fridge = ("fridge", (0.65, draw.between(0.6, 0.7), draw.between(1.7, 1.95)))
    return [fridge, tops[0], stove, *tops[1:]]


def furnish_dining(room: Interior) -> Iterator[None]:
    """Stand a long table laid for all its chairs, a sideboard, and a cabinet of glasses."""
    draw = room.draw
    table = stand_table(room, (1.0, draw.between(1.8, 2.3), 0.75))
    chairs = seats(room, table, 6)
    yield
    yield from lay_all(room, table, chairs)
    cabinet = room.against(room.some_side(), "cabinet")
    strew(room, cabinet, HOME, 3)
    yield
    shelf = room.against(room.some_side(), "shelf")
    stock(room, shelf, ("plate", "cup", "book", "box"))
    yield
    room.against(room.some_side(), "plant")
    other = room.against(room.some_side(), "cabinet")
    strew(room, other, KITCHEN, 3)
    yield
    room.against(room.some_side(), "armchair")
    room.against(room.some_side(), "lamp", (0.4, 0.4, 1.6))
    yield
