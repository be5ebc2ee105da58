"""Parked vehicles and bicycles in racks, lamps and benches along paths."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import QUARTER, Frame
from aeroscene.corpus.curation.places.goods import paint
from aeroscene.corpus.curation.places.support_surfaces import Bearing

_LONGEST_M = {"car": 4.8, "van": 5.6}


def park(
    bearing: Bearing, name: str, frame: Frame, u: float, v: float, turn: float
) -> Placed | None:
    """Park a vehicle with a drawn colour.

    Args:
        bearing: Surface that carries it.
        name: Category, such as "car"; cars and vans are never too long for a bay.
        frame: Frame of the coordinates.
        u: Middle, m.
        v: Middle, m.
        turn: Heading in the frame, rad.

    Returns:
        The vehicle, or None if it does not fit.
    """
    length, width, height = bearing.draw.size_of(name, 0.25)
    size = (min(length, _LONGEST_M.get(name, length)), width, height)
    look = paint(bearing.draw)
    return bearing.stand(name, frame.moved(u, v, turn), size, margin=0.15, look=look)


def rack_bicycles(bearing: Bearing, frame: Frame, u: float, v: float, count: int) -> None:
    """Place bicycles side by side along the frame's x axis, each in a colour of its own.

    Args:
        bearing: Surface that carries them.
        frame: Frame of the coordinates.
        u: Middle of the row, m.
        v: Middle of the row, m.
        count: Number of bicycles; those that do not fit are left out.
    """
    for index in range(count):
        at = u + (index - (count - 1) / 2) * 0.75
        size = (1.75, 0.55, 1.05)
        bearing.stand("bicycle", frame.moved(at, v, QUARTER), size, look=paint(bearing.draw))


def line_way(
    bearing: Bearing, frame: Frame, span: tuple[float, float], reach: float
) -> Iterator[None]:
    """Place benches in pairs beside a path, facing it, with bins and lamps between.

    Args:
        bearing: Surface that carries them.
        frame: Frame in the middle of the path, x along it.
        span: Ends along the path, m.
        reach: Half the path's width, m.
    """
    low, high = span
    count = max(1, int((high - low) / 7.0))
    spots = [low + (index + 0.5) * (high - low) / count for index in range(count)]
    for index, at in enumerate(spots):
        sides = (-1, 1) if index % 2 else (1, -1)
        # A short path has benches on both sides, a long one on alternating sides.
        for side in sides[: 2 if count < 4 else 1]:
            _bench(bearing, frame, at, side, reach)
        if index % 2 == 0:
            spot = frame.moved(at + 1.8, sides[0] * (reach + 0.5), pi)
            bearing.stand("bin", spot, (0.5, 0.5, 0.95))
        yield
    for index in range(max(1, int((high - low) / 14.0))):
        # Half a pitch of the benches, so that no lamp stands before one.
        at = low + 3.5 + 14.0 * index
        side = 1 if index % 2 else -1
        turn = -side * QUARTER
        bearing.stand("street_lamp", frame.moved(at, side * (reach + 0.5), turn), (0.9, 0.4, 4.2))
        yield


def _bench(bearing: Bearing, frame: Frame, at: float, side: int, reach: float) -> None:
    size = (0.6, bearing.draw.between(1.5, 2.0), 0.85)
    bearing.stand("bench", frame.moved(at, side * (reach + 0.55), -side * QUARTER), size)
