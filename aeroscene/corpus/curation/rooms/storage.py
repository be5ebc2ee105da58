"""Rooms for goods: stores, racks, docks, shops."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import lay, seats

_RACK = {"form": "rack"}


def furnish_store(room: Interior) -> Iterator[None]:
    """Shelves along the walls, crates and boxes on the floor."""
    draw = room.draw
    for side in ("left", "right"):
        room.lined(side, "shelf", 2)
        yield
    for name in ("crate", "pallet", "box"):
        room.against(draw.one_of(("left", "right", "back")), name)
    yield
    counter = room.anywhere("counter", (0.85, 2.0, 0.95), keep=0.8)
    room.on(counter, "box", 0.0, 0.85)
    yield
    for bearer in room.bearers[:4]:
        room.on(bearer, "box", 0.0, draw.between(-0.9, 0.9))
    yield
    for _ in range(3):
        room.against(room.some_side(), draw.one_of(("barrel", "crate", "box")))
    yield


def _rack(room: Interior, u: float, v: float, turn: float) -> list[Placed]:
    """Two shelves back to back."""
    size, form = (0.5, 2.0, 2.2), _RACK
    shift_u, shift_v = (0.26, 0.0) if turn == 0.0 else (0.0, 0.26)
    pair = (
        room.put("shelf", u + shift_u, v + shift_v, size, turn, look=form),
        room.put("shelf", u - shift_u, v - shift_v, size, turn + pi, look=form),
    )
    return [shelf for shelf in pair if shelf]


def furnish_racks(room: Interior) -> Iterator[None]:
    """Long rows of racks with aisles between, loaded pallets at their ends."""
    draw = room.draw
    x, y, _ = room.room.size
    turn = 0.0 if y >= x else pi / 2
    pitch = (3.6, 2.1) if turn == 0.0 else (2.1, 3.6)
    for number, (u, v) in enumerate(room.spots(*pitch, 1.7, is_tight=True)):
        for shelf in _rack(room, u, v, turn):
            if draw.chance(0.4):
                room.on(shelf, "box", 0.0, draw.between(-0.9, 0.9))
        yield
        if number < 4:
            continue
        _pallet(room)
        yield
        if number % 2:
            room.anywhere("crate", (1.1, 1.1, draw.between(0.6, 1.1)), keep=0.6)
            yield
    for _ in range(8):
        _pallet(room)
        yield


def _pallet(room: Interior) -> None:
    """A pallet somewhere, bare or loaded."""
    height = 0.144 if room.draw.chance(0.3) else room.draw.between(0.5, 1.3)
    room.anywhere("pallet", (1.25, 1.15, height), keep=0.6)


def furnish_goods(room: Interior) -> Iterator[None]:
    """Pallets in rows, crates and barrels beside them, a van, a packing table."""
    draw = room.draw
    spots = room.spots(2.6, 2.4, 1.6)
    order = draw.shuffled(range(len(spots)))
    for index in order[:9]:
        u, v = spots[index]
        height = 0.144 if draw.chance(0.3) else draw.between(0.5, 1.3)
        pallet = room.put("pallet", u, v, (1.25, 1.15, height), keep=0.3)
        if pallet and height < 0.2 and draw.chance(0.5):
            room.on(pallet, "box", 0.5, 0.5)
        yield
    room.anywhere("van", (5.2, 2.0, 2.3), keep=0.8)
    table = room.anywhere("table", (1.2, 2.2, 0.78), keep=0.8)
    room.on(table, "laptop", 0.6, 0.85)
    room.on(table, "box", -0.4, 0.85)
    yield
    for _ in range(4):
        room.anywhere("crate", (draw.between(0.95, 1.3), draw.between(0.95, 1.3), 0.9), keep=0.7)
        yield
    for _ in range(3):
        room.lined(room.some_side(), draw.one_of(("barrel", "crate")), 3)
        yield
    yield from room.strew(("box", "crate", "pallet", "barrel"), 10, keep=0.7)


def furnish_storage(room: Interior) -> Iterator[None]:
    """A deck with goods: shelves along the walls, crates and boxes between them."""
    draw = room.draw
    for side in ("left", "right", "back", "front"):
        room.lined(side, "shelf", 3)
        yield
    for _ in range(6):
        room.anywhere("crate", (1.1, 1.1, draw.between(0.6, 1.0)), keep=0.8)
        yield
    yield from room.strew(("pallet", "barrel", "box"), 4, keep=0.8)


def furnish_aisles(room: Interior) -> Iterator[None]:
    """Shop shelves back to back in rows, bargains on pallets between them."""
    draw = room.draw
    x, y, _ = room.room.size
    turn = 0.0 if y >= x else pi / 2
    pitch = (3.2, 2.05) if turn == 0.0 else (2.05, 3.2)
    for number, (u, v) in enumerate(room.spots(*pitch, 1.9, is_tight=True)):
        size = (0.45, 2.0, 1.7)
        shift_u, shift_v = (0.24, 0.0) if turn == 0.0 else (0.0, 0.24)
        room.put("shelf", u + shift_u, v + shift_v, size, turn, look=_RACK)
        room.put("shelf", u - shift_u, v - shift_v, size, turn + pi, look=_RACK)
        yield
        if number % 2:
            room.anywhere("pallet", (1.25, 1.15, draw.between(0.6, 1.0)), keep=0.6)
            yield
    for _ in range(3):
        room.lined(room.some_side(), "fridge", 3, (0.7, 0.9, 1.95))
        yield


def furnish_produce(room: Interior) -> Iterator[None]:
    """Tables and crates of fruit, cool cabinets along the walls."""
    draw = room.draw
    spots = room.spots(3.0, 2.8, 2.0)
    for index in draw.shuffled(range(len(spots)))[:9]:
        u, v = spots[index]
        name = draw.one_of(("table", "crate", "pallet"))
        size = {"table": (1.3, 2.0, 0.78), "crate": (1.2, 1.2, 0.7), "pallet": (1.25, 1.15, 0.8)}
        bearer = room.put(name, u, v, size[name], keep=0.4)
        if name == "table":
            room.on(bearer, "box", 0.6, 0.85)
            room.on(bearer, "box", -0.6, 0.85)
        yield
    for _ in range(3):
        room.lined(room.some_side(), "fridge", 3, (0.7, 0.9, 1.95))
        yield
    yield from room.strew(("planter", "plant", "sign"), 3, keep=0.8)


def furnish_checkout(room: Interior) -> Iterator[None]:
    """A row of tills with a screen each, a cafe corner, trolleys of boxes."""
    draw = room.draw
    x, y, _ = room.room.size
    turn = 0.0 if x >= y else pi / 2
    n_tills = max(2, int(max(x, y) // 3.0))
    for number in range(min(n_tills, 7)):
        at = (number - (min(n_tills, 7) - 1) / 2) * 2.8
        u, v = (at, 0.0) if x >= y else (0.0, at)
        till = room.put("counter", u, v, (0.85, 2.6, 0.9), turn=turn)
        room.on(till, "monitor", 0.0, 0.9)
        if draw.chance(0.5):
            room.on(till, "box", 0.0, 0.3)
        if till:
            room.beside(till, "chair", -0.75, 0.6, 0.0)
        yield
    for _ in range(3):
        table = room.anywhere("table", (0.95, 1.8, 0.74), keep=0.9)
        chairs = seats(room, table, 4)
        lay(room, table, chairs[2:3])
        yield
    yield from room.line_walls(("plant", "bin", "sign", "bench", "box"), 5)


def furnish_booths(room: Interior) -> Iterator[None]:
    """Stands of a fair: a counter, a screen, a table with chairs, plants, exhibits on crates."""
    draw = room.draw
    spots = room.spots(4.4, 4.4, 2.4)
    for index in draw.shuffled(range(len(spots)))[:8]:
        u, v = spots[index]
        counter = room.put("counter", u, v, (0.7, 1.8, 1.05), turn=draw.count(0, 3) * pi / 2)
        room.on(counter, "laptop", 0.0, 0.7)
        room.on(counter, "book", 0.0, -0.7)
        yield
        exhibit = draw.one_of(("crate", "table", "pallet"))
        room.anywhere(exhibit, (1.2, 1.2, 0.75), keep=0.8)
        cabinet = room.anywhere("cabinet", (0.5, 1.4, 0.9), keep=0.6)
        room.on(cabinet, "television", 0.0, 0.0)
        yield
    for _ in range(4):
        table = room.anywhere("table", (0.9, 0.9, 0.76), keep=0.8)
        seats(room, table, 2)
        yield
    yield from room.strew(("plant", "sign", "planter", "bin"), 6, keep=0.8)
