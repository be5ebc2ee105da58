"""Rooms in which guests eat, and the kitchens that cook for them."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.rooms.contents import CARTONS, KITCHEN, stock, strew
from aeroscene.corpus.curation.rooms.grid import middle_first
from aeroscene.corpus.curation.rooms.interior import Interior
from aeroscene.corpus.curation.rooms.lines import Piece, fit_line
from aeroscene.corpus.curation.rooms.tables import lay, seats

_TABLE_PITCH_M = (3.1, 2.6)
"""Distances between tables: across, where the chairs stand, and along."""


def furnish_cafe(room: Interior) -> Iterator[None]:
    """Stand a bar along one wall and small tables with chairs, every other one laid."""
    yield from _bar(room)
    yield from _tables(room, (0.95, room.draw.between(1.6, 1.8), 0.74), laid_every=2)
    yield from _rim(room)


def furnish_restaurant(room: Interior) -> Iterator[None]:
    """Stand tables in rows, laid for their guests, a bar, sideboards, plants between."""
    yield from _tables(room, (0.9, room.draw.between(1.5, 1.7), 0.75), laid_every=1)
    yield from _bar(room)
    yield from _rim(room)


def _tables(room: Interior, size: tuple[float, float, float], *, laid_every: int) -> Iterator[None]:
    """Place tables with four chairs on a grid that fills the room; lay some, two at a time."""
    found: list[tuple[Placed, list[Placed]]] = []
    # Rows that have a table, and ends of rows (place and side) that were interrupted.
    begun: set[float] = set()
    ended: set[tuple[float, bool]] = set()
    for u, v in middle_first(room.spots(*_TABLE_PITCH_M, (1.35, 1.05))):
        table = None if (u, v > 0) in ended else room.put("table", u, v, size)
        if table is None:
            # A row has no holes: on either side it ends where it is interrupted.
            ended |= {(u, v > 0)} if u in begun else set()
            continue
        begun.add(u)
        found.append((table, seats(room, table, 4)))
        yield
    for number, (table, chairs) in enumerate(found):
        if number % laid_every:
            room.on(table, "cup", 0.0, 0.6)
            continue
        # One end of every other table stays free.
        lay(room, table, chairs[:2])
        yield
        if laid_every == 1 and number % 2:
            lay(room, table, chairs[2:])
            yield


def _bar(room: Interior) -> Iterator[None]:
    size = (0.7, room.draw.between(2.2, 3.2), 1.05)
    bar = room.against(room.some_side(), "counter", size, look={"form": "bar"})
    strew(room, bar, KITCHEN, 4)
    yield


def _rim(room: Interior) -> Iterator[None]:
    """Along the walls: a fridge, shelves, sideboards, plants, a bin."""
    room.against(room.some_side(), "fridge")
    room.against(room.some_side(), "plant")
    yield
    shelf = room.against(room.some_side(), "shelf")
    stock(room, shelf, ("plate", "cup", "box"))
    yield
    cabinet = room.against(room.some_side(), "cabinet")
    strew(room, cabinet, KITCHEN, 3)
    yield
    room.against(room.some_side(), "bin")
    room.against(room.some_side(), "plant")
    yield


def furnish_galley(room: Interior) -> Iterator[None]:
    """Stand stoves and worktops in line, an island, fridges and stocked shelves."""
    draw = room.draw
    stove: Piece = ("stove", (0.7, 0.8, 0.92))
    top: Piece = ("counter", (0.7, draw.between(1.3, 1.8), 0.92))
    line = fit_line(room, [top, stove, stove, top], room.long_side())
    yield
    for piece in line:
        if piece.name == "counter":
            strew(room, piece, KITCHEN, 3)
    yield
    turn = pi / 2 if room.room.size[0] > room.room.size[1] else 0.0
    island = room.anywhere("counter", (0.8, 2.0, 0.92), keep=0.9, turn=turn)
    strew(room, island, KITCHEN, 4)
    yield
    room.lined(room.some_side(), "fridge", 3, (0.7, 0.75, 1.95))
    yield
    for _ in range(2):
        for shelf in room.lined(room.some_side(), "shelf", 2, (0.45, 1.1, 1.9)):
            stock(room, shelf, ("box", "plate", "box"))
            yield
    second = room.against(room.some_side(), "counter", (0.7, draw.between(1.4, 2.2), 0.92))
    strew(room, second, KITCHEN, 4)
    yield
    for name in ("bin", "crate", "box", "crate"):
        room.against(room.some_side(), name)
    yield
    for _ in range(2):
        cabinet = room.against(room.some_side(), "cabinet")
        strew(room, cabinet, (*KITCHEN, *CARTONS), 3)
        yield
