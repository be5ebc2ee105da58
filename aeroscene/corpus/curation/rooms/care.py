"""Rooms of a clinic."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.rooms.contents import CARTONS, PAPERS, equip, stock, strew
from aeroscene.corpus.curation.rooms.interior import GAP_M, Interior
from aeroscene.corpus.curation.rooms.tables import seats

_BED_M = (2.05, 0.95, 0.62)
_BED_PITCH_M = 2.4
"""Distance between the middles of beds side by side, with a nightstand, a chair and a passage."""


def furnish_ward(room: Interior) -> Iterator[None]:
    """Stand beds side by side with a nightstand and a chair each, wardrobes, a table, a screen."""
    draw = room.draw
    frame, length = room.wall(room.long_side())
    count = max(1, int((length - 0.4) // _BED_PITCH_M))
    beds = []
    for index in range(count):
        at = (index - (count - 1) / 2) * _BED_PITCH_M
        spot = frame.moved(at, _BED_M[0] / 2 + GAP_M, pi / 2)
        bed = room.stand("bed", spot, _BED_M, look={"form": "posts"})
        beds += [bed] if bed else []
    # A ward too small for a row has one bed at any wall.
    if not beds:
        bed = room.against(room.some_side(), "bed", _BED_M)
        beds += [bed] if bed else []
    yield
    for bed in beds:
        u, v = -_BED_M[0] / 2 + 0.21, _BED_M[1] / 2 + 0.28
        stand = room.beside(bed, "nightstand", u, v, 0.0, (0.42, 0.5, 0.6))
        strew(room, stand, ("lamp", "cup", "lamp"), 1)
        room.beside(bed, "chair", -0.2, -v - 0.06, pi / 2, (0.5, 0.5, 0.85))
        yield
    for wardrobe in room.lined(room.some_side(), "wardrobe", len(beds), (0.55, 0.8, 1.9)):
        # On the other side of the bed than the nightstand, and facing it.
        strew(room, wardrobe, CARTONS, 1)
    yield
    cabinet = room.against(room.some_side(), "cabinet", (0.45, 1.2, 0.9))
    room.on(cabinet, "television", 0.0, 0.0)
    strew(room, cabinet, ("box", "plant", "cup"), 2)
    yield
    table = room.anywhere("table", (0.8, 0.9, 0.74), keep=0.6)
    seats(room, table, 2)
    strew(room, table, ("cup", "book"), 2)
    yield
    shelf = room.against(room.some_side(), "shelf", (0.34, draw.between(0.8, 1.2), 1.8))
    stock(room, shelf, CARTONS)
    yield
    room.against(room.some_side(), "bin", (0.4, 0.4, 0.75))
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "armchair")
    yield


def furnish_practice(room: Interior) -> Iterator[None]:
    """Stand a doctor's desk with a chair, a couch, worktops and shelves, and an armchair."""
    draw = room.draw
    desk = room.anywhere("desk", (0.8, 1.6, 0.74), keep=0.75) or room.against(
        room.some_side(), "desk", (0.8, 1.5, 0.74)
    )
    equip(room, desk, is_full=False)
    yield
    room.against(room.some_side(), "bed", (1.95, 0.9, 0.6), look={"form": "divan"})
    yield
    counter = room.against(room.some_side(), "counter", (0.6, draw.between(1.4, 2.0), 0.9))
    strew(room, counter, ("box", "cup", "box", "book"), 3)
    yield
    for _ in range(2):
        stock(room, room.against(room.some_side(), "shelf", (0.34, 0.9, 1.9)), PAPERS)
        yield
    cabinet = room.against(room.some_side(), "cabinet")
    strew(room, cabinet, PAPERS, 3)
    yield
    room.against(room.some_side(), "bin", (0.4, 0.4, 0.75))
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "armchair")
    yield


def furnish_waiting(room: Interior) -> Iterator[None]:
    """Stand chairs in rows along the walls, low tables with books, a screen, plants."""
    size = (0.52, 0.52, 0.84)
    for number, side in enumerate(room.sides):
        # Corners stay free, where two rows would meet.
        count = max(1, int((room.wall(side)[1] - 1.6) // 0.6))
        room.lined(side, "chair", min(count, 6), size, gap=0.06)
        yield
        if number % 2:
            table = room.anywhere("coffee_table", (0.7, 1.1, 0.42), keep=0.6)
            strew(room, table, ("book", "book", "cup"), 2)
            yield
    cabinet = room.against(room.some_side(), "cabinet", (0.45, 1.2, 0.9))
    room.on(cabinet, "television", 0.0, 0.0)
    yield
    stock(room, room.against(room.some_side(), "shelf"))
    yield
    for name in ("plant", "bin", "plant", "sign"):
        room.against(room.some_side(), name)
    yield
