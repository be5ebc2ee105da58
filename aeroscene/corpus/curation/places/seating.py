"""Tables with chairs that face them, tables laid for a meal, benches with a view."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.places.support_surfaces import Bearing
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.furniture import WOODS

_SEAT_M = 0.72
"""Length of table for one person."""
_GAP_M = 0.06


_Seat = tuple[int, float]
"""Side of a table (1 or -1) and place along it, m."""


def set_table(
    bearing: Bearing, frame: Frame, u: float, v: float, *, turn: float = 0.0, chairs: int = 4
) -> tuple[Placed, list[_Seat]] | None:
    """Place a table with chairs along its two long sides, each facing it.

    Args:
        bearing: Surface that carries them.
        frame: Frame of the coordinates.
        u: Middle of the table, m.
        v: Middle of the table, m.
        turn: Heading of the table in the frame, rad.
        chairs: Most chairs.

    Returns:
        The table and the seats whose chairs found space, or None if the table found none.
    """
    size = (0.9, bearing.draw.between(1.2, 1.8), 0.74)
    # Chairs share the table's wood, so that they look like a set.
    wood, form = bearing.draw.one_of(WOODS), bearing.draw.one_of(("legs", "trestle"))
    spot = frame.moved(u, v, turn)
    table = bearing.stand("table", spot, size, margin=0.1, look={"wood": wood, "form": form})
    if table is None:
        return None
    seats: list[_Seat] = []
    for side, along in _seats(size, chairs):
        seat = (0.5, 0.5, 0.9)
        reach = side * (size[0] / 2 + seat[0] / 2 + _GAP_M)
        facing = pi if side > 0 else 0.0
        spot = table.frame.moved(reach, along, facing)
        if bearing.stand("chair", spot, seat, look={"wood": wood, "form": "legs"}):
            seats.append((side, along))
    return table, seats


def _seats(size: Vector3, count: int) -> list[_Seat]:
    """Seats of a table, alternately on one side and the other."""
    per_side = max(1, min((count + 1) // 2, int(size[1] / _SEAT_M)))
    spots = [
        (side, (index - (per_side - 1) / 2) * size[1] / per_side)
        for index in range(per_side)
        for side in (-1, 1)
    ]
    return spots[:count]


def lay_table(builder: Builder, draw: Draw, table: Placed, seats: Sequence[_Seat]) -> None:
    """Lay a plate and perhaps a cup before each of some seats.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        table: Table.
        seats: Seats of `set_table`.
    """
    reach = table.size[0] / 2
    for side, along in seats:
        items: list[tuple[str, float, float]] = [("plate", reach - 0.2, 0.0)]
        if draw.chance(0.6):
            # Beside the plate, on the left of the guest.
            items.append(("cup", reach - 0.36, side * -0.2))
        for name, inset, aside in items:
            put_on(builder, draw, table, name, side * inset, along + aside, 0.0)


def put_on(
    builder: Builder, draw: Draw, bearer: Placed, name: str, u: float, v: float, turn: float
) -> Placed | None:
    """Lay an object on another one's upper face.

    Args:
        builder: Builder of the scene.
        draw: Randomness; draws the size.
        bearer: Object that carries it.
        name: Category.
        u: Place in the frame of the bearer, m.
        v: Place in the frame of the bearer, m.
        turn: Heading in that frame, rad.

    Returns:
        The object, or None if it does not fit.
    """
    spot = bearer.frame.moved(u, v, turn)
    return builder.place(name, spot, draw.size_of(name), parent=bearer, within=bearer)


def dine(
    bearing: Bearing, frame: Frame, spots: list[tuple[float, float]], turn: float, chairs: int = 4
) -> Iterator[None]:
    """Place tables at some spots of a frame; afterwards lay them, one by one.

    Args:
        bearing: Surface that carries them.
        frame: Frame of the spots.
        spots: Middles of the tables, m.
        turn: Heading of the tables in the frame, rad.
        chairs: Most chairs of each table.
    """
    tables: list[tuple[Placed, list[_Seat]]] = []
    for u, v in spots:
        found = set_table(bearing, frame, u, v, turn=turn, chairs=chairs)
        if found:
            tables.append(found)
            yield
    for table, seats in tables:
        # One or two of the seats, so that some places stay empty.
        lay_table(bearing.builder, bearing.draw, table, seats[: bearing.draw.count(1, 2)])
        yield


def picnic(bearing: Bearing, frame: Frame, u: float, v: float, turn: float) -> Placed | None:
    """Place a table between two benches that face it; None if the table does not fit."""
    length = bearing.draw.between(1.6, 2.0)
    form = {"form": "trestle"}
    size = (0.8, length, 0.74)
    table = bearing.stand("table", frame.moved(u, v, turn), size, margin=0.1, look=form)
    if table is None:
        return None
    for side in (-1, 1):
        facing = pi if side > 0 else 0.0
        size = (0.42, length, 0.46)
        plain = {"form": "plain"}
        bearing.stand("bench", table.frame.moved(side * 0.72, 0.0, facing), size, look=plain)
    return table
