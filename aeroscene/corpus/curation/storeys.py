"""How a storey of a furnished building is divided: rooms in two bands, or side by side.

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
_SPINE_SHARE = (0.5, 0.56)
"""How much of the depth the front band takes."""
_LEAST_ROOM_M = DOORS_M[-1] + 2 * JAMB_M
"""Shortest room along the facade: a door between its jambs."""


def plan_storey(
    draw: Draw, size: tuple[float, float], kinds: deque[str], level: float, clear: float
) -> tuple[Zone, ...]:
    """Rooms of a storey, in the building's frame; the first is one at the front.

    Args:
        draw: Sizes of the rooms.
        size: Outer depth (x, the front at +x) and length (y) of the building, m.
        kinds: What the rooms are to be in turn; goes on to what the next storey begins with.
        level: Height of the slab's upper face, m.
        clear: Height from the slab to the ceiling, m.
    """
    half_x, half_y = size[0] / 2 - WALL_M, size[1] / 2 - WALL_M
    lines = [-half_y, *bay_borders(size[1]), half_y]
    spine = round(half_x - draw.between(*_SPINE_SHARE) * 2 * half_x, 2)
    bands = [(spine, half_x), (-half_x, spine)]
    if min(high - low for low, high in bands) < _LEAST_BAND_M or _is_wide(kinds[0]):
        bands = [(-half_x, half_x)]
    return tuple(
        Zone(
            kind=kind,
            role="room",
            x0=low,
            y0=lines[first],
            x1=high,
            y1=lines[last],
            level=level,
            clear=clear,
        )
        for low, high in bands
        for kind, first, last in _share_bays(draw, kinds, lines, high - low)
    )


def _is_wide(kind: str) -> bool:
    """Whether a use needs the whole depth of a building, as classrooms and halls do."""
    return USES[kind].least_m2 > 30.0


def _share_bays(
    draw: Draw, kinds: deque[str], lines: Sequence[float], depth: float
) -> list[tuple[str, int, int]]:
    """Kind, first and last line of each room of a band; the last room takes what is left."""
    rooms: list[tuple[str, int, int]] = []
    first, end = 0, len(lines) - 1
    while first < end:
        wanted = USES[kinds[0]].draw_area(draw) / depth
        counts = [n for n in range(1, end - first) if _may_end(lines, first, first + n)]
        bays = min(
            (*counts, end - first),
            key=lambda n: abs(lines[first + n] - lines[first] - wanted),
        )
        rooms.append((kinds[0], first, first + bays))
        kinds.rotate(-1)
        first += bays
    return rooms


def _may_end(lines: Sequence[float], first: int, last: int) -> bool:
    """Whether a room between two lines, and what is left beside it, are wide enough for doors."""
    return min(lines[last] - lines[first], lines[-1] - lines[last]) >= _LEAST_ROOM_M
