"""Rooms of a home."""

from __future__ import annotations

from collections.abc import Iterator

from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.tables import lay, seats


def furnish_living(room: Interior) -> Iterator[None]:
    """Sofa, coffee table and television in line; armchair, shelf, lamp, plant."""
    draw = room.draw
    side, other = ("left", "right") if draw.chance(0.5) else ("right", "left")
    sofa = room.against(side, "sofa")
    table = room.in_front(sofa, "coffee_table", gap=0.45)
    yield
    cabinet = room.against(other, "cabinet", (0.45, 1.6, 0.72))
    room.on(cabinet, "television", 0.0, 0.0)
    yield
    if sofa:
        room.beside(sofa, "lamp", 0.0, sofa.size[1] / 2 + 0.4, 0.0, (0.45, 0.45, 1.6))
    room.against("back", "armchair")
    yield
    dining = room.anywhere("table", (0.95, 1.8, 0.74), keep=0.8)
    chairs = seats(room, dining, 4)
    yield
    room.against(other, "shelf")
    room.against(side, "plant")
    yield
    room.on(table, "book", 0.1, 0.5)
    room.on(table, "cup", -0.2, -0.6)
    lay(room, dining, chairs[2:4])
    yield
    room.against(room.some_side(), "shelf")
    room.against(room.some_side(), "armchair")
    yield


def furnish_bedroom(room: Interior) -> Iterator[None]:
    """A bed between nightstands, wardrobe, desk with chair."""
    draw = room.draw
    side, other = ("left", "right") if draw.chance(0.5) else ("right", "left")
    bed = room.against(side, "bed")
    stands = []
    if bed:
        for sign in (-1, 1):
            u = -bed.size[0] / 2 + 0.25
            v = sign * (bed.size[1] / 2 + 0.35)
            stands.append(room.beside(bed, "nightstand", u, v, 0.0, (0.42, 0.5, 0.5)))
    yield
    room.against(other, "wardrobe")
    yield
    for stand in stands:
        if draw.chance(0.7):
            room.on(stand, "lamp", 0.0, 0.0)
    yield
    desk = room.against(other, "desk")
    room.in_front(desk, "chair")
    room.on(desk, "laptop", 0.0, 0.5)
    yield
    room.against("back", "plant")
    room.against("front", "armchair")
    yield
    room.against(room.some_side(), "cabinet")
    room.against(room.some_side(), "shelf")
    yield


def furnish_kitchen(room: Interior) -> Iterator[None]:
    """Counter, stove and fridge along one wall; a table set for a meal."""
    draw = room.draw
    side = draw.one_of(("left", "right"))
    counter = room.against(side, "counter", (0.62, draw.between(1.8, 2.8), 0.92))
    if counter:
        stove = (0.62, 0.6, 0.9)
        fridge = (0.65, 0.7, 1.85)
        at = counter.size[1] / 2 + 0.05
        sign = 1.0 if draw.chance(0.5) else -1.0
        room.beside(counter, "stove", 0.0, sign * (at + 0.3), 0.0, stove)
        room.beside(counter, "fridge", 0.0, -sign * (at + 0.35), 0.0, fridge)
    yield
    table = room.anywhere("table", (0.95, draw.between(1.7, 2.1), 0.74), keep=0.75)
    chairs = seats(room, table, 4)
    yield
    lay(room, table, chairs[2:4])
    yield
    room.on(counter, draw.one_of(("plate", "box")), 0.0, 0.6)
    room.on(counter, "cup", 0.0, -0.5)
    yield
    room.against("back", "bin", (0.4, 0.4, 0.75))
    room.against(room.some_side(), "shelf")
    yield


def furnish_dining(room: Interior) -> Iterator[None]:
    """A long table set for a meal, a sideboard."""
    draw = room.draw
    turn = 0.0 if draw.chance(0.5) else 1.5707963267948966
    table = room.anywhere("table", (1.1, draw.between(2.0, 2.6), 0.75), keep=0.85, turn=turn)
    chairs = seats(room, table, 6)
    yield
    lay(room, table, chairs[:2])
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    room.on(cabinet, "lamp", 0.0, 0.7)
    yield
    lay(room, table, chairs[2:3])
    room.against(room.some_side(), "plant")
    yield
