"""Vehicles on carriageways: moving in lanes, waiting at crossings, parked along the kerb."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import pi

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.site import PARKING_LANE_M, Road
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.materials import PAINT_COLOURS

_SLOT_M = 11.0
"""Length of road for each place in which a vehicle may drive."""
_BUSY = 0.4  # share of the places that are taken
_STOP_M = 4.3
"""Distance from the end of a road with a crossing to the waiting vehicle's bumper."""
_BAY_M = 6.2
"""Length of kerb for a parked vehicle."""
_WIDE_M = 2.7
"""Width of a lane from which buses and trucks use it."""


def drive(builder: Builder, draw: Draw, road: Road) -> Iterator[None]:
    """Place one moving vehicle in each step; some of the places in both lanes stay empty.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        road: Carriageway.
    """
    length = road.placed.size[0]
    count = max(1, int(length // _SLOT_M))
    spots = list(product((-1, 1), range(count)))
    for index in draw.shuffled(range(len(spots))):
        side, slot = spots[index]
        if not draw.chance(_BUSY):
            continue
        u = -length / 2 + (slot + 0.5) * length / count + draw.between(-1.5, 1.5)
        # The space before a crossing belongs to waiting vehicles.
        if road.zebra_end * u > length / 2 - _STOP_M - 3.0:
            continue
        if _set_off(builder, draw, road, u, side):
            yield


def wait(builder: Builder, draw: Draw, road: Road) -> Iterator[None]:
    """Place up to two vehicles before the crossing, bumper to bumper; see `drive`."""
    if not road.zebra_end:
        return
    end = road.zebra_end
    at = road.placed.size[0] / 2 - _STOP_M
    for _ in range(draw.count(0, 2)):
        size = draw.size_of("car", 0.3)
        # Traffic on the right: vehicles that wait at +x drive at negative y.
        if _place(builder, draw, road, "car", size, (end * (at - size[0] / 2), -end)):
            yield
        at -= size[0] + draw.between(1.2, 2.0)


def park(builder: Builder, draw: Draw, road: Road) -> Iterator[None]:
    """Park vehicles along the kerb, two in each step, headed like the lane beside them.

    Lanes that the site does not reserve for parking stay free; see `drive`.
    """
    length, width, _ = road.placed.size
    # Four metres at both ends of the street stay free.
    count = int((length - 8.0) // _BAY_M)
    spots = list(product(road.parking, range(count)))
    parked = 0
    for index in draw.shuffled(range(len(spots))):
        side, bay = spots[index]
        if not draw.chance(0.6):
            continue
        name = "van" if draw.chance(0.15) else "car"
        x, y, z = draw.size_of(name, 0.3)
        size = (min(x, _BAY_M - 0.9), min(y, PARKING_LANE_M - 0.15), z)
        u = (bay + 0.5 - count / 2) * _BAY_M + draw.between(-0.3, 0.3)
        v = side * (width / 2 - PARKING_LANE_M / 2)
        parked += bool(_place(builder, draw, road, name, size, (u, side), v))
        if parked % 2 == 0:
            yield


def call_bus(builder: Builder, draw: Draw, road: Road, u: float, side: int) -> None:
    """Place a bus at a stop.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        road: Carriageway beside the stop.
        u: Place of the stop along it, m.
        side: Side of the carriageway, -1 or 1.
    """
    _place(builder, draw, road, "bus", draw.size_of("bus", 0.3), (u, side))


def _set_off(builder: Builder, draw: Draw, road: Road, u: float, side: int) -> Placed | None:
    name = "car"
    if draw.chance(0.2) and 2 * abs(road.lane(1) - road.lane(-1)) > 2 * _WIDE_M:
        name = draw.one_of(("van", "van", "bus", "truck", "truck"))
    return _place(builder, draw, road, name, draw.size_of(name, 0.3), (u, side))


def _place(
    builder: Builder,
    draw: Draw,
    road: Road,
    name: str,
    size: Vector3,
    at: tuple[float, int],
    v: float | None = None,
) -> Placed | None:
    """Place a vehicle at a place along the road, on one of its sides, driving on the right."""
    u, side = at
    spot = road.placed.frame.moved(u, road.lane(side) if v is None else v, 0.0 if side < 0 else pi)
    look = {"colour": draw.one_of(PAINT_COLOURS)}
    return builder.place(
        name, spot, size, parent=road.placed, within=road.placed, margin=0.2, look=look
    )
