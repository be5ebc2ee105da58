"""Walls between zones, with their doors and inner windows."""

from __future__ import annotations

from collections.abc import Sequence

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.floor_plan import sure
from aeroscene.corpus.curation.indoor.walls import PARTITION_M, wall_spans
from aeroscene.corpus.curation.indoor.zones import CELL_M, DOORS_M, Border, Zone
from aeroscene.scene import AttributeValue
from aeroscene.solids.shapes.facade import SLAB_M

_APRON_M = 1.3
"""Depth of the air kept free before and behind a door."""
_HEADS_M = {DOORS_M[0]: 2.75, DOORS_M[1]: 2.25, DOORS_M[2]: 2.25, DOORS_M[3]: 2.25}
"""Height of a door's head above the first cell border over the slab, by the door's width."""
_HATCH_M = (1.75, 0.75)
"""Width of an inner window, and its sill above the first cell border over the slab."""
_GLAZED = frozenset(("meeting", "open_office", "cafe", "lounge", "library", "gym", "classroom"))
"""Kinds of rooms whose walls towards halls and corridors are made of glass."""


def raise_walls(
    builder: Builder,
    draw: Draw,
    shell: Placed,
    zones: Sequence[Zone],
    borders: Sequence[Border],
    doors: dict[int, float],
) -> None:
    """Place all walls, then keep the air before and behind their openings free.

    Args:
        builder: Builder to add to.
        draw: Places of the doors, choice of windows.
        shell: The building, whose rooms stand already.
        zones: A plan, in the building's frame.
        borders: All borders of the plan.
        doors: Widths of the doors under the numbers of their borders.
    """
    openings: list[tuple[Border, float, float, float]] = []
    for index, span in wall_spans(zones, borders).items():
        air = _raise_wall(builder, draw, shell, zones, borders[index], span, doors.get(index))
        openings += [(borders[index], *air)] if air else []
    # After all walls, because reserved air would refuse a wall beside a door.
    for border, at, width, low in openings:
        _keep_free(builder, shell, border, at, width, low)


def is_edge(zones: Sequence[Zone], border: Border) -> bool:
    """Return true if a border runs along an upper floor, beside a zone as high as both."""
    return min(zones[i].level for i in border.zones) < border.base - 0.1


def _raise_wall(
    builder: Builder,
    draw: Draw,
    shell: Placed,
    plan: Sequence[Zone],
    border: Border,
    span: tuple[float, float],
    door_m: float | None,
) -> tuple[float, float, float] | None:
    """Place one wall between two zones, with its door or an inner window.

    Returns:
        Middle, width and foot of the opening, or None without one.
    """
    middle, length = (span[0] + span[1]) / 2, span[1] - span[0]
    if length < PARTITION_M:
        return None
    zones = [plan[i] for i in border.zones]
    look: dict[str, AttributeValue] = {"colour": "white"}
    rooms = [zone for zone in zones if zone.role == "room"]
    if len(rooms) == 1 and rooms[0].kind in _GLAZED:
        look["form"] = "glass"
    # The wall's own y axis is the building's y, or minus its x.
    sign = 1.0 if border.along == "y" else -1.0
    # Beside the edge of an upper floor it stands on the wall below, not on the slab.
    base = border.base - SLAB_M if is_edge(plan, border) else border.base
    rise = _first_cell(border.base) - base
    air: tuple[float, float, float] | None = None
    if door_m is not None:
        at = _door_place(draw, border, door_m)
        look |= {
            "door_m": door_m,
            "door_offset_m": round(sign * (at - middle), 4),
            "door_height_m": round(rise + _HEADS_M[door_m], 4),
        }
        air = (at, door_m, border.base + 0.1)
    # Half of the longer walls towards a hall have a window to fly through.
    elif len(rooms) == 1 and border.length > 3.5 and draw.chance(0.5):
        at = _door_place(draw, border, _HATCH_M[0])
        look |= {
            "window_m": _HATCH_M[0],
            "window_offset_m": round(sign * (at - middle), 4),
            "window_sill_m": round(rise + _HATCH_M[1], 4),
            "window_height_m": round(rise + _HEADS_M[1.75], 4),
        }
        air = (at, _HATCH_M[0], base + rise + _HATCH_M[1])
    size = (PARTITION_M, length, border.top - base)
    spot = shell.frame.moved(*border.spot(middle))
    sure(builder.place("wall", spot, size, base=base, parent=shell, domain="indoor", look=look))
    return air


def _first_cell(height: float) -> float:
    """The lowest border between cells at or above a height, m."""
    # Python rounds down; two signs make that rounding up.
    return -((-height) // CELL_M) * CELL_M


def _door_place(draw: Draw, border: Border, width: float) -> float:
    """Middle of an opening whose jambs lie on borders between cells."""
    reach = (border.length - width) / 2 - 0.45
    middle = (border.low + border.high) / 2 + draw.between(-0.7, 0.7) * max(0.0, reach)
    return _first_cell(middle - width / 2 - CELL_M / 2) + width / 2


def _keep_free(
    builder: Builder, shell: Placed, border: Border, at: float, width: float, low: float
) -> None:
    """Reserve the air before and behind an opening."""
    u, v, _ = border.spot(at)
    size = (2 * _APRON_M, width + 0.2) if border.along == "y" else (width + 0.2, 2 * _APRON_M)
    height = _first_cell(border.base) + _HEADS_M[1.75] - low
    builder.reserve(shell.frame.moved(u, v), (*size, height), low)
