"""Rooms in which people work and meet."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.contents import CARTONS, PAPERS, equip, stock, strew
from aeroscene.corpus.curation.rooms.grid import middle_first
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.lines import stand_pair
from aeroscene.corpus.curation.rooms.tables import seats, stand_table

_DESK_M2 = 9.0
"""Area of an office for each desk."""


def furnish_office(room: Interior) -> Iterator[None]:
    """Stand desks with screens, lamps and chairs, full shelves, a cabinet, a table, a plant."""
    draw = room.draw
    count = max(1, min(3, round(room.area / _DESK_M2)))
    # Each desk has another heading, as people place them.
    for turn in (0.0, pi / 2, pi)[:count]:
        size = (0.84, draw.between(1.7, 1.85), 0.74)
        desk = room.anywhere("desk", size, keep=0.7, turn=turn)
        if desk is None:
            desk = room.against(room.some_side(), "desk", (0.75, 1.4, 0.74))
        equip(room, desk, is_full=draw.chance(0.4))
        yield
    shelf = room.against(room.some_side(), "shelf", (0.36, draw.between(0.9, 1.5), 1.9))
    stock(room, shelf, PAPERS)
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    strew(room, cabinet, PAPERS, 3)
    yield
    stock(room, room.against(room.some_side(), "shelf", (0.36, 0.9, 1.9)), PAPERS)
    yield
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "bin", (0.35, 0.35, 0.7))
    yield
    # Its chairs keep so far from the desks that nobody takes them for theirs.
    table = room.anywhere("table", (0.8, 0.9, 0.74), keep=1.25)
    seats(room, table, 2)
    strew(room, table, ("cup", "book"), 2)
    yield
    strew(room, room.against(room.some_side(), "cabinet"), PAPERS, 3)
    room.against(room.some_side(), "armchair")
    yield


def furnish_open_office(room: Interior) -> Iterator[None]:
    """Stand islands of desks face to face, cabinets along the walls, shelves, armchairs."""
    draw = room.draw
    size = (0.84, draw.between(1.76, 1.9), 0.74)
    spots = room.spots(3.3, size[1] + 0.15, (1.75, size[1] / 2 + 0.35), is_tight=True)
    for index, (u, v) in enumerate(middle_first(spots)):
        # Chairs stand at the outer sides, which are the fronts.
        pair = stand_pair(room, "desk", u, v, size, 0.0)
        # Screens at one end of the island, although the two desks face opposite ways.
        for desk, end in zip(pair, (1.0, -1.0), strict=False):
            equip(room, desk, is_full=draw.chance(0.3), end=end)
            yield
        if index % 3 == 2:
            for cabinet in room.lined(room.some_side(), "cabinet", 2):
                strew(room, cabinet, PAPERS, 2)
            yield
    for _ in range(2):
        stock(room, room.against(room.some_side(), "shelf"), PAPERS)
        room.against(room.some_side(), draw.one_of(("plant", "bin")))
        yield
    table = room.anywhere("coffee_table", (0.85, 1.1, 0.42), keep=0.8)
    seats(room, table, 2, "armchair")
    strew(room, table, ("book", "cup"), 2)
    yield


def furnish_meeting(room: Interior) -> Iterator[None]:
    """Stand a long table with chairs and what people bring, a screen on a cabinet, shelves."""
    draw = room.draw
    x, y, _ = room.room.size
    # 1.3 m to the walls at both ends, for chairs and people behind them.
    long = min(2.6, max(1.6, max(x, y) - 2.6))
    size = (1.15, round(draw.between(0.85, 1.0) * long, 2), 0.74)
    turn = pi / 2 if x > y else 0.0
    table = room.put("table", 0.0, 0.0, size, turn=turn) or stand_table(room, size, turn)
    chairs = seats(room, table, 6)
    yield
    cabinet = room.against(room.some_side(), "cabinet", (0.45, draw.between(1.3, 1.8), 0.85))
    room.on(cabinet, "television", 0.0, 0.0)
    strew(room, cabinet, PAPERS, 2)
    yield
    for chair in chairs:
        _bring(room, table, chair)
    yield
    stock(room, room.against(room.some_side(), "shelf"), PAPERS)
    yield
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "bin", (0.35, 0.35, 0.7))
    yield
    strew(room, room.against(room.some_side(), "cabinet"), PAPERS, 3)
    room.against(room.some_side(), "plant")
    yield


def _bring(room: Interior, table: Placed | None, chair: Placed) -> None:
    """Lay a laptop, a book or a cup before a chair, a laptop's screen towards it."""
    if table is None:
        return
    name = room.draw.one_of(("laptop", "cup", "book"))
    size = room.draw.size_of(name)
    u, v = table.frame.local(chair.frame.x, chair.frame.y)
    sign = 1.0 if u > 0 else -1.0
    at = sign * (table.size[0] / 2 - size[0] / 2 - 0.05)
    room.lie(table, name, at, v, size, 0.0 if sign > 0 else pi)


def furnish_workshop(room: Interior) -> Iterator[None]:
    """Stand work benches along the walls, a table with tools, full shelves, bins and crates."""
    draw = room.draw
    for side in ("left", "right"):
        bench = room.against(side, "counter", (0.75, draw.between(1.8, 2.8), 0.92))
        strew(room, bench, ("box", "lamp", "laptop", "box"), 3)
        yield
    table = stand_table(room, (1.2, 2.0, 0.8))
    strew(room, table, CARTONS, 2)
    yield
    for shelf in room.lined(room.some_side(), "shelf", 3, (0.4, 1.0, 1.9)):
        stock(room, shelf, CARTONS)
        yield
    room.lined(room.some_side(), "bin", 3)
    yield
    for name in ("crate", "pallet", "crate", "bin"):
        room.against(room.some_side(), name)
    yield
    strew(room, room.against(room.some_side(), "cabinet"), ("box", "book"), 3)
    yield


def furnish_classroom(room: Interior) -> Iterator[None]:
    """Stand rows of pupils' tables that face the teacher's desk at the back (-x) wall; shelves."""
    draw = room.draw
    x, _, _ = room.room.size
    desk = room.put("desk", -x / 2 + 1.5, draw.between(-1.0, 1.0), (0.8, 1.6, 0.75))
    room.behind(desk, "chair")
    # Turned to the teacher, who sits behind the desk.
    room.on(desk, "laptop", 0.0, 0.7, turn=pi)
    strew(room, room.against("back", "cabinet", (0.4, 1.8, 1.0)), PAPERS, 2)
    yield
    size = (0.82, 1.4, 0.74)
    # The tables begin behind the teacher's desk and its chair.
    spots = [(u, v) for u, v in room.spots(1.9, 1.9, 1.25, is_tight=True) if u > -x / 2 + 2.9]
    for u, v in spots[:15]:
        table = room.put("table", u, v, size, turn=pi)
        if table:
            for side in (-0.34, 0.34):
                seat = (0.45, 0.42, 0.82)
                room.beside(table, "chair", -(0.5 * size[0] + 0.28), side, 0.0, seat)
            if draw.chance(0.4):
                room.on(table, draw.one_of(("book", "laptop")), -0.3, 0.7, turn=pi)
        yield
    for shelf in room.lined("right", "shelf", 2, (0.36, draw.between(0.9, 1.3), 1.8)):
        stock(room, shelf)
        yield
    strew(room, room.against(room.some_side(), "cabinet"), PAPERS, 3)
    yield
    room.against(room.some_side(), "plant")
    room.against(room.some_side(), "bin")
    yield


def furnish_library(room: Interior) -> Iterator[None]:
    """Stand rows of full shelves back to back, reading tables with lamps, armchairs, a desk."""
    draw = room.draw
    size = (0.34, 1.8, draw.between(1.9, 2.15))
    spots = room.spots(2.3, 1.85, (1.5, 1.6), is_tight=True)
    # Six tenths of the floor for shelves, the rest for readers.
    stacks = spots[: max(2, round(0.6 * len(spots)))]
    shelves: list[Placed] = []
    for u, v in stacks:
        shelves += stand_pair(room, "shelf", u, v, size, 0.0)
        yield
    # Every other shelf first, so that a scene that fills up has books in all rows.
    for shelf in shelves[::2]:
        stock(room, shelf, ("book",))
        yield
    for _ in range(3):
        table = room.anywhere("table", (1.1, 1.8, 0.74), keep=0.75)
        seats(room, table, 4)
        strew(room, table, ("book", "lamp", "book"), 2)
        yield
    for shelf in shelves[1::2]:
        stock(room, shelf, ("book",))
        yield
    for side in room.sides:
        for shelf in room.lined(side, "shelf", 2, (0.34, 1.2, 2.0)):
            stock(room, shelf)
            yield
    for _ in range(2):
        chair = room.against(room.some_side(), "armchair")
        if chair:
            room.beside(chair, "lamp", 0.0, chair.size[1] / 2 + 0.35, 0.0, (0.4, 0.4, 1.5))
        yield
    desk = room.against(room.some_side(), "desk")
    equip(room, desk)
    yield
    for _ in range(3):
        room.against(room.some_side(), draw.one_of(("plant", "armchair", "bin")))
    yield
