"""Division of a furnished building's storey: rooms in two bands, or side by side.

A partition meets the facade between two bays, where a pier stands, so that windows stay open. Rooms
are about as large as their uses ask for, as far as whole bays allow.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.zones import DOORS_M, JAMB_M, Zone
from aeroscene.corpus.curation.rooms.uses import USES
from aeroscene.solids.shapes.facade import WALL_M, bay_borders

_LEAST_BAND_M = 3.2
"""Least depth of a band of rooms: a bedroom's width."""
_FRONT_SHARE = (0.5, 0.56)
"""Share of the depth that the front band takes."""
_WIDE_M2 = 30.0
"""Area from which a use takes the whole depth of a building, as halls do."""
_LEAST_ROOM_M = DOORS_M[-1] + 2 * JAMB_M
"""Shortest room along the facade: a door between its jambs."""
_TIGHT = 0.85
"""Least share of the area that its use asks for."""

_Room = tuple[str, int, int]
"""Kind, first and last line."""


def plan_storey(
    draw: Draw, size: tuple[float, float], kinds: deque[str], level: float, clear: float
) -> tuple[Zone, ...]:
    """Divide a storey into rooms, in the building's frame; the first one is at the front.

    Args:
        draw: Sizes of the rooms.
        size: Outer depth (x, the front at +x) and length (y) of the building, m.
        kinds: Kinds of the rooms in turn; rotated to the one with which the next storey begins.
        level: Height of the slab's upper face, m.
        clear: Height from the slab to the ceiling, m.
    """
    half_x, half_y = size[0] / 2 - WALL_M, size[1] / 2 - WALL_M
    lines = [-half_y, *(round(line, 2) for line in bay_borders(size[1])), half_y]
    spine = round(half_x - draw.between(*_FRONT_SHARE) * 2 * half_x, 2)
    whole, bands = (-half_x, half_x), [(spine, half_x), (-half_x, spine)]
    rooms: list[tuple[_Room, tuple[float, float]]] = []
    first = 0
    if min(high - low for low, high in bands) < _LEAST_BAND_M:
        bands = [whole]
    elif USES[kinds[0]].least_m2 > _WIDE_M2:
        hall = _next_room(draw, kinds, lines, 0, 2 * half_x)
        rooms.append((hall, whole))
        first = hall[2]
    for band in bands:
        at = first
        while at < len(lines) - 1:
            room = _next_room(draw, kinds, lines, at, band[1] - band[0])
            rooms.append((room, band))
            at = room[2]
    return tuple(
        Zone(
            kind=kind,
            role="room",
            x0=x[0],
            y0=lines[low],
            x1=x[1],
            y1=lines[high],
            level=level,
            clear=clear,
        )
        for (kind, low, high), x in rooms
    )


def _next_room(
    draw: Draw, kinds: deque[str], lines: Sequence[float], first: int, depth: float
) -> _Room:
    """The next kind that fits into the rest of a band, on as many bays as it asks for."""
    end = len(lines) - 1
    space = (lines[end] - lines[first]) * depth
    kind = next((k for k in kinds if _TIGHT * USES[k].least_m2 <= space), kinds[0])
    # To the end of the queue, so that every kind has its turn.
    kinds.remove(kind)
    kinds.append(kind)
    wanted = USES[kind].draw_area(draw) / depth
    ends = [n for n in range(first + 1, end) if _may_end(lines, first, n)]
    # Of all lines the one that gives the area closest to the drawn one.
    last = min((*ends, end), key=lambda n: abs(lines[n] - lines[first] - wanted))
    return (kind, first, last)


def _may_end(lines: Sequence[float], first: int, last: int) -> bool:
    """Return true if a room between two lines, and the rest beside it, have room for doors."""
    return min(lines[last] - lines[first], lines[-1] - lines[last]) >= _LEAST_ROOM_M
