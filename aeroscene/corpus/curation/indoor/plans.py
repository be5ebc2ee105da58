"""Two kinds of floor plans: rooms along a corridor that opens into a hall, and a wide hall.

Offices and hotels have the first, markets and sports halls the second; both offer a drone space to
fly and doors to pass. They are drawn in the building's frame, and their first zone is the hall in
which a flight starts.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import cycle, pairwise
from typing import Literal

from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.packing import pack_row
from aeroscene.corpus.curation.indoor.zones import Role, Zone, snapped
from aeroscene.solids.shapes.facade import SLAB_M, SLAB_TOP_M, WALL_M

LOW_CEILING_M = 3.5
"""Underside of an upper storey."""
UPPER_LEVEL_M = LOW_CEILING_M + SLAB_M
START_M = 6.4
"""Side of the square in the middle of the first hall that stays free around the start."""
LEAST_HALL_M = 7.0
"""Shortest side of that hall."""
_LEAST_WING_M = 4.5
"""Shortest row of rooms beside a hall."""
_SHOWN = ("booths", "produce", "aisles", "checkout")
_STORED = ("racks", "goods")
_SEATED = ("library", "stand", "concourse", "restaurant")
_DENSE = frozenset((*_SHOWN, *_STORED, *_SEATED))
"""Kinds of zones that rows of furniture fill."""
_OPEN_M = 5.6
"""Side of the square in a wide zone that stays free for a large drone."""

Span = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Programme:
    """Kinds of zones that a building offers, in order of importance."""

    halls: tuple[str, ...]
    near: tuple[str, ...]
    """Kinds of rooms in the row of `depth_m`: along the whole corridor, or at the hall's end."""
    far: tuple[str, ...] = ("store",)
    """Kinds of rooms on the other side of the corridor, which takes the rest of the width."""
    upper: tuple[str, ...]
    """Kinds of galleries over the rooms."""
    depth_m: Span
    """Range of the depth of the row of near rooms."""
    corridor_m: float = 3.25
    """Distance between the middles of a corridor's walls."""
    hall_m: Span = (7.25, 8.75)
    """Range of the length of each hall along the corridor, or of the first of a wide hall."""
    is_tall: bool = False
    """True if galleries lie over the rooms; otherwise all ceilings are at one height."""
    n_open: int = 0
    """Number of halls, besides the first, that keep a square free for a large drone."""


class _Storey:
    """Zones of a plan, collected one by one."""

    def __init__(self, draw: Draw, programme: Programme, roof: float) -> None:
        self.draw = draw
        self.programme = programme
        self.roof = roof
        self.zones: list[Zone] = []
        self.near = self._kinds(programme.near)
        self.far = self._kinds(programme.far)
        self._upper = cycle(self._kinds(programme.upper))

    def _kinds(self, kinds: Sequence[str]) -> deque[str]:
        """A queue of kinds: the first stays first, the others start from a random one."""
        first, *others = kinds
        # The first kind is what characterises the building.
        start = self.draw.count(0, max(0, len(others) - 1))
        return deque((first, *others[start:], *others[:start]))

    def add(self, kind: str, role: Role, x: Span, y: Span, *, is_low: bool = False) -> Zone:
        """Add a zone of the ground floor, as high as the building or under a gallery."""
        ceiling = LOW_CEILING_M if is_low else self.roof
        zone = Zone(
            kind=kind,
            role=role,
            x0=x[0],
            y0=y[0],
            x1=x[1],
            y1=y[1],
            level=SLAB_TOP_M,
            clear=round(ceiling - SLAB_TOP_M, 4),
        )
        self.zones.append(zone)
        return zone

    def add_row(
        self, kinds: deque[str], x: Span, y: Span, *, along: Literal["x", "y"], is_low: bool
    ) -> None:
        """Add rooms side by side along x or y, each about as large as its kind asks for."""
        (low, high), across = (x, y) if along == "x" else (y, x)
        for kind, a, b in pack_row(self.draw, kinds, low, high, across[1] - across[0]):
            sides = ((a, b), across) if along == "x" else (across, (a, b))
            self.add(kind, "room", *sides, is_low=is_low)

    def add_gallery(self, x: Span, y: Span) -> None:
        """Add an upper floor that is open towards the hall; a long one has two parts."""
        clear = round(self.roof - UPPER_LEVEL_M, 4)
        is_wide = x[1] - x[0] > y[1] - y[0]
        low, high = x if is_wide else y
        lines = [low, snapped((low + high) / 2), high] if high - low > 14.0 else [low, high]
        for part in pairwise(lines):
            zone = self.add(next(self._upper), "gallery", *((part, y) if is_wide else (x, part)))
            self.zones[-1] = replace(zone, level=UPPER_LEVEL_M, clear=clear)

    def finish(self) -> tuple[Zone, ...]:
        """Return all zones; the largest halls but the first keep space for a large drone."""
        halls = [
            index
            for index, zone in enumerate(self.zones)
            # The square and 0.6 m for furniture on both sides.
            if index and zone.role == "hall" and min(zone.size) >= _OPEN_M + 1.2
        ]
        halls.sort(key=lambda index: -max(self.zones[index].size))
        for index in halls[: self.programme.n_open]:
            self.zones[index] = replace(self.zones[index], open_m=_OPEN_M)
        return tuple(self.zones)


def plan_spine(
    draw: Draw, size: tuple[float, float], roof: float, programme: Programme
) -> tuple[Zone, ...]:
    """Plan a corridor between two rows of rooms; a hall replaces a part of the far row.

    In a tall building the hall extends across both rows, and galleries look down into it.

    Args:
        draw: Randomness.
        size: Outer length and width of the building, m.
        roof: Height of the ceiling, m.
        programme: Kinds of zones.
    """
    half_x, half_y = size[0] / 2 - WALL_M, size[1] / 2 - WALL_M
    storey = _Storey(draw, programme, roof)
    # The near row is on one side or the other.
    sign = 1.0 if draw.chance(0.5) else -1.0
    edge = snapped(half_y - draw.between(*programme.depth_m))
    far = edge - programme.corridor_m
    halls = _hall_lines(draw, half_x, programme)
    inner = (-half_y, half_y if programme.is_tall else edge)
    for kind, x in zip(programme.halls, pairwise(halls), strict=True):
        storey.add(kind, "hall", x, _side(inner, sign))
    if not programme.is_tall:
        x = (halls[0], halls[-1])
        storey.add_row(storey.near, x, _side((edge, half_y), sign), along="x", is_low=False)
    for wing in ((-half_x, halls[0]), (halls[-1], half_x)):
        if wing[1] - wing[0] >= _LEAST_WING_M - 0.2:
            _add_wing(storey, wing, half_y, (far, edge), sign)
    return storey.finish()


def _side(y: Span, sign: float) -> Span:
    """A range of y, mirrored if the sign is negative."""
    return y if sign > 0 else (-y[1], -y[0])


def _hall_lines(draw: Draw, half_x: float, programme: Programme) -> list[float]:
    """Ends of the halls along the corridor, somewhere in the middle or at its low end."""
    lengths = [max(LEAST_HALL_M, draw.between(*programme.hall_m)) for _ in programme.halls]
    rest = 2 * half_x - sum(lengths)
    low = draw.between(0.3, 0.7) * rest
    # Wings that would be too short for rooms are given to the other end.
    if low < _LEAST_WING_M or rest - low < _LEAST_WING_M or draw.chance(0.25):
        lines = [-half_x]
    else:
        lines = [snapped(low - half_x)]
    for length in lengths:
        lines.append(snapped(lines[-1] + length))
    return lines


def _add_wing(storey: _Storey, x: Span, half_y: float, corridor: Span, sign: float) -> None:
    """A corridor between its rows; a gallery covers the near row, and sometimes both.

    The far row's rooms are as high as the hall unless a gallery covers them.
    """
    is_tall = storey.programme.is_tall
    far, edge = corridor
    is_covered = is_tall and storey.draw.chance(0.35)
    storey.add("corridor", "corridor", x, _side((far, edge), sign), is_low=is_tall)
    storey.add_row(storey.near, x, _side((edge, half_y), sign), along="x", is_low=is_tall)
    storey.add_row(storey.far, x, _side((-half_y, far), sign), along="x", is_low=is_covered)
    if is_tall:
        storey.add_gallery(x, _side((-half_y if is_covered else far, half_y), sign))


def plan_hall(
    draw: Draw, size: tuple[float, float], roof: float, programme: Programme
) -> tuple[Zone, ...]:
    """Plan a hall of two to four open zones; rooms along one end, under a gallery if it is tall.

    Args:
        draw: Randomness.
        size: Outer length and width of the building, m.
        roof: Height of the ceiling, m.
        programme: Kinds of zones.
    """
    half_x, half_y = size[0] / 2 - WALL_M, size[1] / 2 - WALL_M
    storey = _Storey(draw, programme, roof)
    edge = snapped(-half_x + draw.between(*programme.depth_m))
    first = snapped(edge + max(LEAST_HALL_M, draw.between(*programme.hall_m)))
    # Two columns need a building that leaves each of them as wide as a hall.
    columns = 2 if half_x - first >= 17.0 else 1
    step = (half_x - first) / columns
    lines = [edge, first, *(snapped(first + i * step) for i in range(1, columns)), half_x]
    rows = [-half_y, snapped(draw.between(-0.03, 0.03) * size[1]), half_y]
    # In turn, so that neighbours differ.
    halls = cycle(programme.halls)
    for x in pairwise(lines):
        for y in pairwise(rows):
            storey.add(next(halls), "hall", x, y)
    row = ((-half_x, edge), (-half_y, half_y))
    storey.add_row(storey.near, *row, along="y", is_low=programme.is_tall)
    if programme.is_tall:
        storey.add_gallery(*row)
    return storey.finish()


def clear_end_m(zone: Zone) -> float:
    """Length that a zone's open square takes from its longer side if it lies at the end.

    Returns:
        Length, m; 0 if the square lies in the middle, or the zone has none.
    """
    return zone.open_m + 0.2 if zone.open_m and zone.kind in _DENSE else 0.0


def open_place(zone: Zone) -> tuple[float, float]:
    """Middle of a zone's open square, from the zone's middle, m.

    It lies at one end of dense zones, because a square in the middle would break every row.
    """
    x, y = zone.size
    reach = (max(x, y) - zone.open_m) / 2 - 0.2 if zone.kind in _DENSE else 0.0
    return (0.0, reach) if y >= x else (reach, 0.0)
