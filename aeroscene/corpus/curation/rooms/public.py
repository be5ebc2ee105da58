"""Rooms in which people meet: lobbies, lounges, gardens, gyms, courts."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.rooms.contents import stock, strew
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import lay, seats

_FLANKS = ("left", "right")
"""Sides of a room along its x axis."""


def furnish_lobby(room: Interior) -> Iterator[None]:
    """Stand a reception desk, sofas before low tables, plants, full shelves, a sign."""
    draw = room.draw
    desk = room.against(room.some_side(), "counter", (0.75, draw.between(2.2, 3.0), 1.05))
    room.on(desk, "monitor", 0.0, 0.7)
    strew(room, desk, ("book", "cup", "plant"), 2)
    yield
    for _ in range(2):
        sofa = room.against(room.some_side(), "sofa")
        table = room.in_front(sofa, "coffee_table", gap=0.45)
        strew(room, table, ("book", "cup"), 2)
        yield
    for _ in range(2):
        room.against(room.some_side(), "plant", (0.8, 0.8, 1.7))
        yield
    # Islands of a planter between two benches, in the middle of the hall.
    for u, v in room.spots(4.6, 3.4, 2.2):
        room.put("bench", u + 0.75, v, (0.5, 1.9, 0.45), keep=0.2)
        room.put("planter", u, v, (0.7, 1.9, 0.9))
        room.put("bench", u - 0.75, v, (0.5, 1.9, 0.45), turn=pi, keep=0.2)
        yield
    room.against(room.some_side(), "sign", (0.2, 1.2, 2.2))
    room.lined(room.some_side(), "bench", 2, (0.45, 1.7, 0.45))
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    room.on(cabinet, "television", 0.0, 0.0)
    strew(room, cabinet, ("book", "plant"), 2)
    room.against(room.some_side(), "bin")
    yield
    stock(room, room.against(room.some_side(), "shelf"))
    yield
    yield from room.line_walls(("plant", "armchair", "bench"), 4)


def furnish_lounge(room: Interior) -> Iterator[None]:
    """Stand armchairs around low tables, sofas, standing tables, full shelves."""
    spots = room.spots(3.2, 2.6, (1.8, 1.5))
    # Every other place has a low table; the rest get high ones once the sofas stand.
    for u, v in spots[::2]:
        table = room.put("coffee_table", u, v, (0.9, 1.2, 0.45))
        seats(room, table, 2, "armchair")
        strew(room, table, ("book", "cup"), 2)
        yield
    sofa = room.against(room.some_side(), "sofa")
    strew(room, room.in_front(sofa, "coffee_table", gap=0.45), ("book", "cup"), 2)
    yield
    for u, v in spots[1::2]:
        table = room.put("table", u, v, (0.95, 1.6, 0.75))
        chairs = seats(room, table, 4)
        yield
        lay(room, table, chairs[:2])
        yield
    for shelf in room.lined(room.some_side(), "shelf", 2):
        stock(room, shelf)
        yield
    yield from room.line_walls(("plant", "planter", "lamp", "bin", "armchair"), 5)


def furnish_corridor(room: Interior) -> Iterator[None]:
    """Stand benches, plants, shallow cabinets and bins along the walls; the middle stays free."""
    draw = room.draw
    x, y, _ = room.room.size
    # The long sides: furniture at the ends would block the passage.
    sides = [side for side in room.sides if (side in _FLANKS) == (x >= y)] or list(room.sides)
    for _ in range(2):
        cabinet = room.against(draw.one_of(sides), "cabinet", (0.38, draw.between(0.8, 1.2), 0.85))
        strew(room, cabinet, ("plant", "book", "lamp", "box"), 2)
        yield
        for name, size in (
            ("plant", (0.4, 0.4, 1.2)),
            ("bench", (0.42, 1.4, 0.45)),
            ("bin", (0.36, 0.36, 0.75)),
        ):
            room.against(draw.one_of(sides), name, size)
            yield


def furnish_garden(room: Interior) -> Iterator[None]:
    """Furnish a winter garden: planters, bushes, benches, a table."""
    for u, v in room.spots(4.4, 3.3, 1.9):
        room.put("planter", u, v, (1.2, 2.6, 1.3))
        room.put("bench", u + 1.05, v, (0.5, 1.9, 0.85))
        yield
    for _ in range(3):
        room.against(room.some_side(), "plant", (0.9, 0.9, 1.8))
        room.against(room.some_side(), "bush", (1.2, 1.2, 1.3))
        yield
    # Tables stand on the other side of the planters than the benches.
    for u, v in room.spots(4.4, 3.3, 1.9):
        table = room.put("table", u - 1.6, v, (0.9, 1.2, 0.74))
        chairs = seats(room, table, 2)
        lay(room, table, chairs[:1])
        yield
    yield from room.line_walls(("bush", "plant", "planter"), 4)


def furnish_gym(room: Interior) -> Iterator[None]:
    """Lay mats on the floor; then benches, boxes to jump on, lockers."""
    draw = room.draw
    for u, v in room.spots(2.8, 2.6, 1.8):
        # A mat is the catalogue's landing pad: flat, and large enough for a small drone.
        room.put("landing_pad", u, v, (1.6, 2.0, 0.06))
        yield
    yield from room.in_ranks(room.long_side(), "bench", (0.45, 1.8, 0.45), 1, gap=0.4)
    room.lined(room.some_side(), "crate", 3, (0.9, 1.2, 0.9))
    yield
    room.lined(room.some_side(), "shelf", 2)
    room.lined(room.some_side(), "cabinet", 2)
    yield
    room.lined(room.some_side(), "box", 2)
    room.against(room.some_side(), draw.one_of(("bin", "plant")))
    yield


def furnish_changing(room: Interior) -> Iterator[None]:
    """Stand lockers along the walls, benches in rows between them, bags."""
    room.lined(room.long_side(), "wardrobe", 4, (0.55, 0.8, 1.9))
    yield
    for u, v in room.spots(1.6, 2.2, (1.4, 1.1))[:6]:
        room.put("bench", u, v, (0.42, 1.8, 0.45), keep=0.2)
        yield
    room.lined(room.some_side(), "wardrobe", 3, (0.55, 0.8, 1.9))
    yield
    for name, size in (("bin", (0.4, 0.4, 0.8)), ("box", None), ("box", None), ("bench", None)):
        room.against(room.some_side(), name, size)
    yield


def furnish_court(room: Interior) -> Iterator[None]:
    """Leave a playing field free before rows of seats, with team benches and gear at the walls."""
    draw = room.draw
    # Seats of spectators take one long wall, everything else the others.
    stand = room.long_side()
    others = [side for side in room.sides if side != stand] or [stand]
    yield from room.in_ranks(stand, "bench", (0.45, 1.9, 0.85), 2, pitch=1.05)
    for side in others:
        room.lined(side, "bench", 2, (0.45, 1.9, 0.45), gap=0.3)
        room.lined(side, "crate", 2, (0.9, 1.3, 1.0))
        yield
    room.against(draw.one_of(others), "sign", (0.25, 2.2, 3.2))
    room.against(draw.one_of(others), "bin")
    yield
    # Chairs fill up what the first ranks of benches have left.
    yield from room.in_ranks(stand, "chair", (0.5, 0.5, 0.85), 4, pitch=1.05, gap=0.15)
    for side in others:
        room.lined(side, "box", 4)
        yield


def furnish_stand(room: Interior) -> Iterator[None]:
    """Stand rows of seats that look over the edge of a gallery."""
    x, y, _ = room.room.size
    for u, v in room.spots(1.3, 2.2, 1.4)[:20]:
        room.put("bench", u, v, (0.45, 1.9, 0.85), turn=0.0 if y >= x else pi / 2)
        yield
    room.against(room.some_side(), "counter")
    room.against(room.some_side(), "bin")
    yield


def furnish_concourse(room: Interior) -> Iterator[None]:
    """Stand lines of benches back to back, a board at their ends, ticket machines and a counter."""
    size = (0.6, 2.0, 0.85)
    counter = room.against(room.some_side(), "counter", (0.75, 3.0, 1.05))
    room.on(counter, "monitor", 0.0, 0.6)
    room.on(counter, "laptop", 0.0, -0.6)
    yield
    spots = room.spots(4.4, 2.15, 2.2, is_tight=True)
    for u, v in spots:
        room.put("bench", u + 0.32, v, size)
        room.put("bench", u - 0.32, v, size, turn=pi)
        yield
    room.lined(room.some_side(), "wardrobe", 4, (0.6, 0.9, 1.9))
    yield
    # Beyond the last bench of each line.
    ends = sorted({u for u, _ in spots})
    low, high = (limit(v for _, v in spots) if spots else 0.0 for limit in (min, max))
    for u in ends:
        room.put("sign", u, high + 1.6, (0.25, 2.2, 3.2), turn=pi / 2)
        room.put("planter", u, low - 1.6, (0.9, 1.8, 1.0), turn=pi / 2)
        yield
    for _ in range(3):
        room.against(room.some_side(), "bin")
        room.lined(room.some_side(), "planter", 2, (0.7, 1.6, 1.0), gap=0.8)
        yield
