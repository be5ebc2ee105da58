"""Rooms for goods: stores, racks, docks, shops."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.contents import CARTONS, stock, strew
from aeroscene.corpus.curation.rooms.grid import middle_first
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.lines import stand_pair
from aeroscene.corpus.curation.rooms.tables import lay, seats

_RACK = {"form": "rack"}


def furnish_store(room: Interior) -> Iterator[None]:
    """Stand full shelves along the walls, crates, pallets and boxes on the floor, a worktop."""
    draw = room.draw
    size = (0.42, draw.between(1.0, 1.4), 1.95)
    for side in (room.long_side(), room.some_side()):
        for shelf in room.lined(side, "shelf", 2, size):
            stock(room, shelf, CARTONS)
            yield
    for name in ("crate", "pallet", "box"):
        room.against(room.some_side(), name)
    yield
    counter = room.against(room.some_side(), "counter", (0.7, draw.between(1.3, 1.8), 0.95))
    strew(room, counter, CARTONS, 3)
    yield
    for _ in range(2):
        for name in ("bin", "crate", "box"):
            room.against(room.some_side(), name)
        yield


def furnish_racks(room: Interior) -> Iterator[None]:
    """Stand long rows of racks with aisles between, pallets in rows along the walls."""
    draw = room.draw
    x, y, _ = room.room.size
    # Rows run along the longer side.
    turn = 0.0 if y >= x else pi / 2
    pitch = (3.6, 2.1) if turn == 0.0 else (2.1, 3.6)
    spots = room.spots(*pitch, 1.7, is_tight=True)
    for u, v in middle_first(spots, along=1 if turn == 0.0 else 0):
        for shelf in stand_pair(room, "shelf", u, v, (0.5, 2.0, 2.2), turn, _RACK):
            if draw.chance(0.4):
                room.on(shelf, "box", 0.0, draw.between(-0.9, 0.9))
        yield
    for side in room.sides:
        room.lined(side, "shelf", 3, (0.5, 2.0, 2.2))
        yield
    for _ in range(6):
        room.lined(room.some_side(), "pallet", 4, (1.25, 1.15, draw.between(0.5, 1.3)), gap=0.25)
        yield


def furnish_goods(room: Interior) -> Iterator[None]:
    """Stand blocks of pallets with lanes between, a van, a packing table, crates and bins."""
    draw = room.draw
    # Every fifth pallet is bare, with a box on it.
    for number, (u, v) in enumerate(room.spots(3.9, 1.4, 1.6, is_tight=True)):
        height = 0.15 if draw.chance(0.2) else draw.between(0.5, 1.3)
        for shift in (-0.66, 0.66):
            pallet = room.put("pallet", u + shift, v, (1.25, 1.15, height))
            # Two pallets side by side make a block; a lane follows.
            if pallet and height < 0.2:
                room.on(pallet, "box", 0.5, 0.5)
        if number % 2:
            yield
    room.against(room.some_side(), "van", (5.2, 2.0, 2.3), turn=pi / 2)
    table = room.against(room.some_side(), "table", (1.2, 2.2, 0.78))
    room.on(table, "laptop", 0.6, 0.85)
    room.on(table, "box", -0.4, 0.85)
    yield
    for name, size in (("crate", (1.1, 1.1, 0.9)), ("bin", (0.6, 0.7, 1.0))) * 3:
        room.lined(room.some_side(), name, 4, size, gap=0.1)
        yield


def furnish_storage(room: Interior) -> Iterator[None]:
    """Fill a deck with goods: shelves along the walls, crates and boxes between them."""
    draw = room.draw
    for side in ("left", "right", "back", "front"):
        for shelf in room.lined(side, "shelf", 3):
            stock(room, shelf, CARTONS)
            yield
    for u, v in room.spots(2.6, 1.3, 1.6, is_tight=True):
        room.put("crate", u, v, (1.1, 1.1, draw.between(0.6, 1.0)))
        yield
    for name in ("bin", "pallet"):
        room.lined(room.some_side(), name, 3)
        yield


def _aisle_rims(turn: float) -> tuple[float, float]:
    """Distance of shop shelves from the walls, across their rows and along them."""
    return (1.5, 1.6) if turn == 0.0 else (1.6, 1.5)


def furnish_aisles(room: Interior) -> Iterator[None]:
    """Stand shop shelves in rows, then cool cabinets and bargains on pallets along the walls."""
    draw = room.draw
    x, y, _ = room.room.size
    turn = 0.0 if y >= x else pi / 2
    pitch = (2.7, 2.05) if turn == 0.0 else (2.05, 2.7)
    shelves: list[Placed] = []
    spots = room.spots(*pitch, _aisle_rims(turn), is_tight=True)
    for u, v in middle_first(spots, along=1 if turn == 0.0 else 0):
        size = (0.45, 2.0, 1.7)
        shelves += stand_pair(room, "shelf", u, v, size, turn)
        yield
    # After all shelves: a scene that is full too early has empty shelves rather than none.
    for shelf in shelves:
        stock(room, shelf, CARTONS)
        yield
    for _ in range(3):
        room.lined(room.some_side(), "fridge", 4, (0.7, 0.9, 1.95))
        yield
        room.lined(room.some_side(), "pallet", 2, (1.25, 1.15, draw.between(0.6, 1.0)))
        yield


def furnish_produce(room: Interior) -> Iterator[None]:
    """Stand rows of tables, pallets and crates of fruit, cool cabinets along the walls."""
    sizes = {"table": (1.3, 2.0, 0.78), "pallet": (1.25, 1.15, 0.8), "crate": (1.2, 1.2, 0.7)}
    kinds = tuple(sizes)
    ranks: dict[float, str] = {}
    for u, v in room.spots(2.5, 2.2, (1.5, 1.5)):
        # One kind a row.
        name = ranks.setdefault(u, kinds[len(ranks) % len(kinds)])
        bearer = room.put(name, u, v, sizes[name])
        if name == "table":
            strew(room, bearer, CARTONS, 3)
        yield
    for _ in range(3):
        room.lined(room.some_side(), "fridge", 4, (0.7, 0.9, 1.95))
        room.lined(room.some_side(), "planter", 2, (0.7, 1.6, 1.0))
        yield


def furnish_checkout(room: Interior) -> Iterator[None]:
    """Stand a row of tills with a screen each, a cafe corner, trolleys of boxes."""
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
            # The cashier sits behind the till.
            room.beside(till, "chair", -0.75, 0.6, 0.0)
        yield
    # The corner lies two metres off one long wall.
    along = (0.0, 1.0) if x >= y else (1.0, 0.0)
    for index in range(4):
        at, across = (index - 1.5) * 2.9, min(x, y) / 2 - 2.0
        spot = (at, across) if along[1] else (across, at)
        table = room.put("table", *spot, (0.95, 1.8, 0.74))
        chairs = seats(room, table, 4)
        lay(room, table, chairs[2:3])
        yield
    for _ in range(2):
        till = room.against(room.some_side(), "counter", (0.8, 2.0, 0.9))
        room.on(till, "monitor", 0.0, 0.8)
        strew(room, till, CARTONS, 2)
        stock(room, room.against(room.some_side(), "shelf"), CARTONS)
        yield
    yield from room.line_walls(("plant", "bin", "sign", "bench", "box"), 5)
