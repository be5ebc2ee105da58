"""Galleries: the slabs that carry them, the rails along their edges, the stairs up to them."""

from __future__ import annotations

from collections.abc import Sequence

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER
from aeroscene.corpus.curation.indoor.floor_plan import Building, sure
from aeroscene.corpus.curation.indoor.partitions import is_edge
from aeroscene.corpus.curation.indoor.walls import PARTITION_M
from aeroscene.corpus.curation.indoor.zones import Border, Side, barrier
from aeroscene.solids.shapes.facade import SLAB_M, SLAB_TOP_M, WALL_M

_BEARING_M = 0.1
"""Depth by which an upper slab extends into the outer walls."""
_RAIL_M = (0.1, 1.05)
"""Thickness and height of a gallery's railing."""
_STAIR_M = (4.4, 1.1)
"""Run and width of a flight of stairs, which fills less than a hundredth of its building."""
_TRIES = 30


def lay_upper_slabs(builder: Builder, building: Building, borders: Sequence[Border]) -> None:
    """Lay a slab under each gallery; it ends over walls below rails and against higher walls.

    Args:
        builder: Builder of the scene.
        building: Building with the rooms of its ground floor.
        borders: All borders of its plan.

    Raises:
        OverlapError: If a slab does not fit, which is a fault of the plan.
    """
    shell, zones = building.shell, building.plan.zones
    inner_x, inner_y = (length / 2 - WALL_M for length in building.plan.size)
    for index, zone in enumerate(zones):
        if zone.level <= SLAB_TOP_M:
            continue
        reach: dict[Side, float] = {
            # Slabs bear on outer walls; the small term compares sums of floats.
            "x0": _BEARING_M if zone.x0 <= -inner_x + 1e-6 else 0.0,
            "x1": _BEARING_M if zone.x1 >= inner_x - 1e-6 else 0.0,
            "y0": _BEARING_M if zone.y0 <= -inner_y + 1e-6 else 0.0,
            "y1": _BEARING_M if zone.y1 >= inner_y - 1e-6 else 0.0,
        }
        for border in borders:
            if index in border.zones and is_edge(zones, border):
                is_rail = barrier(zones, border) == "rail"
                reach[border.side_of(index)] = PARTITION_M / 2 if is_rail else -PARTITION_M / 2
        x0, x1 = zone.x0 - reach["x0"], zone.x1 + reach["x1"]
        y0, y1 = zone.y0 - reach["y0"], zone.y1 + reach["y1"]
        spot, size = shell.frame.moved((x0 + x1) / 2, (y0 + y1) / 2), (x1 - x0, y1 - y0, SLAB_M)
        base = zone.level - SLAB_M
        sure(builder.place("floor", spot, size, base=base, parent=shell, domain="indoor"))


def guard_gallery(builder: Builder, draw: Draw, building: Building, border: Border) -> None:
    """Place rails along a gallery's edge, and a flight of stairs if there is space for one.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        building: Building with all its rooms.
        border: Border whose barrier is a rail.
    """
    # The upper zone first.
    zones = building.plan.zones
    upper, lower = sorted(border.zones, key=lambda i: -zones[i].level)
    gap = _climb(builder, draw, building, border, upper, lower)
    spans = [(border.low, border.high)]
    # The rail leaves a gap at the head of the stairs.
    if gap is not None:
        half = _STAIR_M[1] / 2 + 0.1
        spans = [(border.low, gap - half), (gap + half, border.high)]
    inward = -1.0 if border.side_of(upper) in {"x1", "y1"} else 1.0
    line = border.at + inward * 0.1
    floor_space = building.spaces[upper]
    for low, high in spans:
        # Rails stay clear of the walls at their ends.
        length, middle = high - low - 0.24, (low + high) / 2
        if length < 1.0:
            continue
        spot = building.shell.frame.moved(*border.spot(middle, line))
        size = (_RAIL_M[0], length, _RAIL_M[1])
        look = {"form": "rails"}
        builder.place(
            "fence", spot, size, base=floor_space.floor, parent=floor_space.placed, look=look
        )


def _climb(
    builder: Builder, draw: Draw, building: Building, border: Border, upper: int, lower: int
) -> float | None:
    """Place stairs from the lower zone to the edge of the upper one.

    Returns:
        Coordinate of the stairs along the edge, or None if no place is free.
    """
    run, width = _STAIR_M
    floor_space = building.spaces[lower]
    rise = round(building.plan.zones[upper].level - floor_space.floor, 3)
    outward = 1.0 if border.side_of(upper) in {"x1", "y1"} else -1.0
    across = border.at + outward * (PARTITION_M / 2 + run / 2)
    reach = border.length / 2 - width / 2 - 0.4
    if reach <= 0:
        return None
    for _ in range(_TRIES):
        at = (border.low + border.high) / 2 + draw.between(-1.0, 1.0) * reach
        u, v = (across, at) if border.along == "y" else (at, across)
        # Stairs rise towards their +x, which has to point at the edge.
        turn = (0.0 if outward < 0 else 2 * QUARTER) if border.along == "y" else -outward * QUARTER
        spot, room = building.shell.frame.moved(u, v, turn), floor_space.placed
        size, base = (run, width, rise), floor_space.floor
        placed = builder.place("stairs", spot, size, base=base, parent=room, within=room)
        if placed:
            return at
    return None
