"""Rooms in which people work and meet."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import seats


def furnish_office(room: Interior) -> Iterator[None]:
    """Desks with screens and chairs, shelves, a cabinet, a plant."""
    draw = room.draw
    for turn in (0.0, pi / 2, pi):
        size = (0.88, draw.between(1.6, 1.9), 0.74)
        desk = room.anywhere("desk", size, keep=0.75, turn=turn)
        if desk is None:
            desk = room.against(room.some_side(), "desk")
        room.in_front(desk, "chair")
        _equip(room, desk, draw.one_of(_ENDS))
        yield
    room.against(draw.one_of(("left", "right")), draw.one_of(("shelf", "cabinet")))
    yield
    table = room.anywhere("table", (0.9, 0.9, 0.74), keep=0.7)
    seats(room, table, 2)
    yield
    room.against(room.some_side(), draw.one_of(("plant", "bin")))
    room.against(room.some_side(), "cabinet")
    yield


_BOOKCASE = {"form": "bookcase"}
_ENDS = ("left", "right")


def _equip(room: Interior, desk: Placed | None, end: str) -> None:
    """A screen at one end of a desk, perhaps a cup or a book, the other end free."""
    draw = room.draw
    at = 1.0 if end == "left" else -1.0
    if draw.chance(0.65):
        room.on(desk, "monitor", -0.5, at)
    else:
        room.on(desk, "laptop", 0.1, at)
    if draw.chance(0.4):
        room.on(desk, draw.one_of(("book", "cup")), 0.7, at)


def furnish_open_office(room: Interior) -> Iterator[None]:
    """Islands of desks face to face, cabinets along the walls, a round of armchairs."""
    draw = room.draw
    size = (0.88, draw.between(1.7, 1.95), 0.74)
    spots = room.spots(3.6, 2.2, 1.7, is_tight=True)
    half = size[0] / 2 + 0.02
    for index, (u, v) in enumerate(spots):
        pair = [room.put("desk", u + half, v, size), room.put("desk", u - half, v, size, turn=pi)]
        for desk, end in zip(pair, _ENDS, strict=True):
            room.in_front(desk, "chair")
            _equip(room, desk, end)
        yield
        if index % 3 == 2:
            room.lined(room.some_side(), "cabinet", 2)
            yield
    for _ in range(3):
        room.against(room.some_side(), draw.one_of(("plant", "shelf", "bin")))
    yield
    table = room.anywhere("coffee_table", (0.85, 1.1, 0.42), keep=1.0)
    seats(room, table, 2, "armchair")
    yield


def furnish_meeting(room: Interior) -> Iterator[None]:
    """A long table with chairs, a screen on a cabinet."""
    draw = room.draw
    size = (1.2, draw.between(2.0, 2.6), 0.74)
    x, y, _ = room.room.size
    turn = pi / 2 if x > y else 0.0
    table = room.put("table", 0.0, 0.0, size, turn=turn) or room.anywhere("table", size, keep=0.9)
    seats(room, table, draw.count(4, 6))
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    room.on(cabinet, "television", 0.0, 0.0)
    yield
    room.on(table, "laptop", 0.5, 0.8)
    room.on(table, "cup", -0.6, 0.9)
    yield
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "shelf")
    yield


def furnish_workshop(room: Interior) -> Iterator[None]:
    """Work benches along the walls, a table with tools, barrels and crates."""
    draw = room.draw
    for side in ("left", "right"):
        bench = room.against(side, "counter", (0.75, draw.between(2.0, 3.2), 0.92))
        room.on(bench, "box", 0.0, draw.between(-0.8, 0.8))
        yield
    table = room.anywhere("table", (1.2, 2.2, 0.8), keep=1.0)
    room.on(table, "box", 0.5, 0.85)
    yield
    room.lined(room.some_side(), "shelf", 3)
    yield
    room.lined(room.some_side(), "barrel", 3)
    yield
    for name in ("crate", "pallet", "crate"):
        room.against(room.some_side(), name)
    yield
    for bearer in room.bearers[:4]:
        room.on(bearer, draw.one_of(("box", "laptop", "lamp")), 0.0, draw.between(-0.9, 0.9))
    yield


def furnish_classroom(room: Interior) -> Iterator[None]:
    """Rows of pupils' tables that face the teacher's desk at the back (-x) wall."""
    draw = room.draw
    x, _, _ = room.room.size
    desk = room.put("desk", -x / 2 + 1.6, draw.between(-1.0, 1.0), (0.8, 1.6, 0.75))
    room.behind(desk, "chair")
    room.on(desk, "laptop", 0.0, 0.7, turn=pi)
    room.against("back", "cabinet", (0.4, 1.8, 1.0))
    yield
    size = (0.85, 1.4, 0.74)
    spots = [(u, v) for u, v in room.spots(2.3, 2.3, 1.4, is_tight=True) if u > -x / 2 + 3.0]
    for u, v in spots[:12]:
        table = room.put("table", u, v, size, turn=pi)
        if table:
            for side in (-0.34, 0.34):
                seat = (0.45, 0.42, 0.82)
                room.beside(table, "chair", -(0.5 * size[0] + 0.28), side, 0.0, seat)
        yield
    room.lined("right", "shelf", 3)
    yield
    for bearer in room.bearers[2:10]:
        room.on(bearer, draw.one_of(("book", "laptop")), 0.2, 0.9)
        yield
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "bin")
    yield


def furnish_library(room: Interior) -> Iterator[None]:
    """Rows of shelves back to back, reading tables, armchairs with lamps."""
    draw = room.draw
    size = (0.4, 1.8, 2.1)
    spots = room.spots(2.6, 2.0, 1.6, is_tight=True)
    for index in range(0, min(len(spots), 10), 2):
        for u, v in spots[index : index + 2]:
            room.put("shelf", u + 0.21, v, size, look=_BOOKCASE)
            room.put("shelf", u - 0.21, v, size, turn=pi, look=_BOOKCASE)
        yield
    for _ in range(3):
        table = room.anywhere("table", (1.1, 1.8, 0.74), keep=0.8)
        seats(room, table, 4)
        room.on(table, "book", 0.3, 0.8)
        yield
    for _ in range(2):
        chair = room.against(room.some_side(), "armchair")
        if chair:
            room.beside(chair, "lamp", 0.0, chair.size[1] / 2 + 0.35, 0.0, (0.4, 0.4, 1.5))
        yield
    desk = room.against(room.some_side(), "desk")
    room.in_front(desk, "chair")
    room.on(desk, "monitor", -0.4, 0.8)
    yield
    for _ in range(3):
        room.against(room.some_side(), draw.one_of(("plant", "shelf")))
    yield
