"""Rooms in which people come together: cafes, lobbies, gardens, gyms, courts."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import lay, seats


def furnish_cafe(room: Interior) -> Iterator[None]:
    """A bar along one wall and small tables with chairs."""
    draw = room.draw
    side = draw.one_of(("left", "right"))
    bar = room.against(side, "counter", (0.7, draw.between(2.4, 3.6), 1.05))
    for at in (-0.6, 0.5):
        room.on(bar, draw.one_of(("cup", "plate", "box")), 0.0, at)
    yield
    for number in range(8 if room.area > 60 else 3):
        table = room.anywhere("table", (0.95, 1.8 if number % 2 == 0 else 0.95, 0.74), keep=0.8)
        chairs = seats(room, table, 2 + 2 * (number % 2 == 0))
        if number % 2 == 0:
            lay(room, table, chairs[2:3])
        yield
    room.against(side, "fridge")
    room.against("back", "plant")
    yield
    room.against(room.some_side(), "bin")
    room.against(room.some_side(), "plant")
    yield


def furnish_lobby(room: Interior) -> Iterator[None]:
    """A reception desk, sofas around low tables, plants, a sign."""
    draw = room.draw
    side = room.some_side()
    desk = room.against(side, "counter", (0.75, draw.between(2.4, 3.4), 1.05))
    room.on(desk, "monitor", 0.0, 0.7)
    room.on(desk, "laptop", 0.0, -0.7)
    yield
    for _ in range(2):
        sofa = room.against(room.some_side(), "sofa")
        table = room.in_front(sofa, "coffee_table", gap=0.45)
        room.on(table, draw.one_of(("book", "cup")), 0.0, 0.8)
        yield
    for _ in range(2):
        room.anywhere("planter", (0.8, 2.2, 1.0), keep=0.9)
        room.against(room.some_side(), "plant", (0.8, 0.8, 1.7))
        yield
    room.against(room.some_side(), "sign", (0.2, 1.2, 2.2))
    room.lined(room.some_side(), "bench", 2)
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    room.on(cabinet, "television", 0.0, 0.0)
    room.against(room.some_side(), "bin")
    yield
    yield from room.line_walls(("plant", "armchair", "bench"), 4)


def furnish_lounge(room: Interior) -> Iterator[None]:
    """Groups of armchairs around low tables, standing tables, shelves."""
    for _ in range(4 if room.area > 80 else 2):
        table = room.anywhere("coffee_table", (0.9, 1.2, 0.45), keep=1.2)
        seats(room, table, 2, "armchair")
        yield
    sofa = room.against(room.some_side(), "sofa")
    room.in_front(sofa, "coffee_table", gap=0.45)
    yield
    for _ in range(3 if room.area > 80 else 1):
        table = room.anywhere("table", (0.95, 1.8, 0.75), keep=0.9)
        chairs = seats(room, table, 4)
        lay(room, table, chairs[:1])
        yield
    room.lined(room.some_side(), "shelf", 2)
    yield
    yield from room.line_walls(("plant", "planter", "lamp", "bin"), 4)


def furnish_corridor(room: Interior) -> Iterator[None]:
    """Benches, plants and bins along the walls; the middle stays free."""
    draw = room.draw
    x, y, _ = room.room.size
    sides = ("left", "right") if x >= y else ("front", "back")
    for name, size in (("plant", None), ("bench", (0.42, 1.5, 0.45)), ("bin", (0.4, 0.4, 0.8))):
        room.against(draw.one_of(sides), name, size)
        yield


def furnish_garden(room: Interior) -> Iterator[None]:
    """A winter garden: planters, bushes, benches, a table."""
    for _ in range(3):
        room.anywhere("planter", (1.2, 2.6, 1.3), keep=0.8)
        room.against(room.some_side(), "plant", (0.9, 0.9, 1.8))
        yield
    for _ in range(2):
        room.against(room.some_side(), "bench")
        room.against(room.some_side(), "bush", (1.2, 1.2, 1.3))
        yield
    for _ in range(2):
        table = room.anywhere("table", (0.9, 1.2, 0.74), keep=0.9)
        chairs = seats(room, table, 2)
        lay(room, table, chairs[:1])
        yield
    yield from room.line_walls(("bush", "plant", "planter", "barrel"), 4)


def furnish_gym(room: Interior) -> Iterator[None]:
    """Mats on the floor, benches, boxes to jump on, lockers."""
    draw = room.draw
    for u, v in room.spots(3.2, 2.6, 2.2)[:6]:
        room.put("landing_pad", u, v, (1.6, 2.0, 0.06), keep=0.3)
        yield
    room.lined(room.some_side(), "bench", 3, (0.45, 1.8, 0.45))
    yield
    for _ in range(3):
        room.anywhere("crate", (0.9, 1.2, 0.9), keep=0.9)
        yield
    room.lined(room.some_side(), "shelf", 2)
    room.lined(room.some_side(), "cabinet", 2)
    yield
    room.lined(room.some_side(), "barrel", 2)
    room.against(room.some_side(), draw.one_of(("bin", "plant")))
    yield


def furnish_changing(room: Interior) -> Iterator[None]:
    """Lockers along the walls, benches in rows between them."""
    room.lined("left", "wardrobe", 3, (0.55, 1.0, 1.9))
    yield
    for u, v in room.spots(2.2, 2.4, 1.8)[:6]:
        room.put("bench", u, v, (0.42, 1.8, 0.45), keep=0.2)
        yield
    room.lined("right", "wardrobe", 3, (0.55, 1.0, 1.9))
    yield
    room.against(room.some_side(), "bin", (0.4, 0.4, 0.8))
    room.against(room.some_side(), "box")
    yield


def furnish_court(room: Interior) -> Iterator[None]:
    """A playing field with benches, goals of boxes and gear along its sides; the middle is free."""
    draw = room.draw
    x, y, _ = room.room.size
    sides = ("left", "right") if x >= y else ("front", "back")
    for side in sides:
        room.lined(side, "bench", 2, (0.45, 1.9, 0.85), gap=0.3)
        yield
    for sign in (-1, 1):
        at = sign * (max(x, y) / 2 - 0.9)
        u, v = (at, 0.0) if x >= y else (0.0, at)
        room.put("crate", u, v, (0.9, 1.4, 1.1), turn=0.0 if x >= y else pi / 2)
        yield
    for _ in range(3):
        room.against(draw.one_of(sides), draw.one_of(("crate", "barrel", "pallet")))
        yield
    room.against(draw.one_of(sides), "sign", (0.25, 2.2, 3.2))
    room.against(draw.one_of(sides), "bin")
    yield
    for _ in range(6):
        room.lined(draw.one_of(sides), "chair", 5, gap=0.15)
        yield


def furnish_stand(room: Interior) -> Iterator[None]:
    """Rows of seats that look over the edge of a gallery."""
    x, y, _ = room.room.size
    for u, v in room.spots(1.3, 2.2, 1.4)[:20]:
        room.put("bench", u, v, (0.45, 1.9, 0.85), turn=0.0 if y >= x else pi / 2)
        yield
    room.against(room.some_side(), "counter")
    room.against(room.some_side(), "bin")
    yield


def furnish_concourse(room: Interior) -> Iterator[None]:
    """Benches back to back, departure boards, bins, planters, ticket machines."""
    for u, v in room.spots(5.0, 4.2, 2.1)[:8]:
        size = (0.6, 2.0, 0.85)
        room.put("bench", u + 0.33, v, size)
        room.put("bench", u - 0.33, v, size, turn=pi)
        yield
    room.anywhere("sign", (0.25, 2.4, 3.4), keep=1.2)
    room.lined(room.some_side(), "wardrobe", 3, (0.6, 0.9, 1.9))
    yield
    for _ in range(4):
        room.anywhere("planter", (0.9, 1.8, 1.0), keep=1.2)
        room.anywhere("bin", keep=1.0)
        yield
    counter = room.against(room.some_side(), "counter", (0.75, 3.0, 1.05))
    room.on(counter, "monitor", 0.0, 0.6)
    room.on(counter, "laptop", 0.0, -0.6)
    yield
    yield from room.strew(("bicycle", "box", "crate"), 6, keep=0.9)
