"""Two kinds of floor plans: rooms along corridors that open into a hall, and a wide hall.

Both are drawn in the building's frame with the hall that a flight starts in as their first zone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, pairwise
from typing import Literal

from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.indoor.zones import Role, Zone, snapped
from aeroscene.solids.shapes.facade import SLAB_M, SLAB_TOP_M, WALL_M

LOW_CEILING_M = 3.5
"""Underside of an upper storey."""
UPPER_LEVEL_M = LOW_CEILING_M + SLAB_M
CORRIDOR_M = 3.25
"""Distance between the middles of a corridor's walls: 3.1 m clear."""
START_M = 6.4
"""Side of the square in the middle of the first hall that stays free around the start."""
_SHOWN = ("booths", "produce", "aisles", "checkout")
_STORED = ("racks", "goods")
_SEATED = ("classroom", "library", "open_office", "stand", "concourse")
_DENSE = frozenset((*_SHOWN, *_STORED, *_SEATED))
"""Kinds of zones that rows of furniture fill."""
_SNUG = frozenset(("living", "dining", "bedroom", "meeting", "office"))
"""Kinds of rooms that look empty with a free middle."""
_OPEN_M = 5.6
"""Side of the square in a wide room that stays free for a large drone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Programme:
    """Which kinds of zones a building offers, in order of importance."""

    halls: tuple[str, ...]
    small: tuple[str, ...]
    """Kinds of small rooms."""
    wide: tuple[str, ...]
    """Kinds of wide rooms."""
    upper: tuple[str, ...]
    """Kinds of galleries over the rooms."""
    is_tall: bool = False
    """Whether galleries lie over the rooms; else all ceilings are at one height."""
    rear: tuple[str, ...] = ("store",)
    """Kinds of rooms behind those of the deep row."""
    rear_chance: float = 0.0
    """How often a wing's deep row is parted in that way."""


class _Storey:
    """Collects zones."""

    def __init__(self, draw: Draw, programme: Programme, roof: float) -> None:
        self.draw = draw
        self.programme = programme
        self.roof = roof
        self.zones: list[Zone] = []
        self._small = self._kinds(programme.small)
        self._wide = self._kinds(programme.wide)
        self._upper = self._kinds(programme.upper)
        self._rear = cycle(programme.rear)

    def _kinds(self, kinds: Sequence[str]) -> Iterator[str]:
        """The first kind first, the others in turn from a random one on."""
        first, *others = kinds
        start = self.draw.count(0, max(0, len(others) - 1))
        return cycle((first, *others[start:], *others[:start]))

    def add(
        self,
        kind: str,
        role: Role,
        x: tuple[float, float],
        y: tuple[float, float],
        *,
        is_low: bool = False,
    ) -> Zone:
        """A zone of the ground floor, as high as the building or under a gallery."""
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
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        *,
        along: Literal["x", "y"],
        pitch: float,
        is_low: bool,
        is_rear: bool = False,
    ) -> None:
        """Rooms side by side along x or y, each about `pitch` long."""
        low, high = x if along == "x" else y
        depth = (y[1] - y[0]) if along == "x" else (x[1] - x[0])
        count = max(1, round((high - low) / pitch))
        lines = [low, *(snapped(low + i * (high - low) / count) for i in range(1, count)), high]
        for a, b in pairwise(lines):
            is_wide = min(depth, b - a) >= 6.0
            kind = next(self._rear if is_rear else self._wide if is_wide else self._small)
            sides = ((a, b), y) if along == "x" else (x, (a, b))
            self.add(kind, "room", *sides, is_low=is_low)

    def add_gallery(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        """An upper floor that is open towards the hall, in two parts where it is long."""
        clear = round(self.roof - UPPER_LEVEL_M, 4)
        is_wide = x[1] - x[0] > y[1] - y[0]
        low, high = x if is_wide else y
        lines = [low, snapped((low + high) / 2), high] if high - low > 14.0 else [low, high]
        for part in pairwise(lines):
            zone = self.add(next(self._upper), "gallery", *((part, y) if is_wide else (x, part)))
            self.zones[-1] = replace(zone, level=UPPER_LEVEL_M, clear=clear)

    def finish(self) -> tuple[Zone, ...]:
        """All zones; wide halls without rows keep a square free for a large drone.

        So does every other one of the remaining wide zones but the first.
        """
        first, *others = self.zones
        n_wide = 0
        for index, zone in enumerate(others):
            open_m = _wide_open(zone)
            is_free = zone.role == "hall" and zone.kind not in _DENSE
            n_wide += open_m > 0 and not is_free
            others[index] = replace(zone, open_m=open_m if is_free or n_wide % 2 else 0.0)
        return (first, *others)


def _wide_open(zone: Zone) -> float:
    if zone.kind in _SNUG:
        return 0.0
    least = 10.5 if zone.kind in _DENSE else 7.5
    is_wide = min(zone.size) >= 7.5 and max(zone.size) >= least and zone.area >= 75.0
    return _OPEN_M if is_wide else 0.0


def plan_spine(
    draw: Draw, size: tuple[float, float], roof: float, programme: Programme
) -> tuple[Zone, ...]:
    """A hall across the building; corridors lead from it between two rows of rooms."""
    half_x, half_y = size[0] / 2 - WALL_M, size[1] / 2 - WALL_M
    storey = _Storey(draw, programme, roof)
    length = draw.between(9.5, 12.0)
    if programme.is_tall:
        hall = (-half_x, snapped(-half_x + length))
    else:
        middle = draw.between(-0.08, 0.08) * size[0]
        hall = (snapped(middle - length / 2), snapped(middle + length / 2))
    cut = snapped(draw.between(-0.1, 0.1) * size[1])
    halls = [(-half_y, cut), (cut, half_y)]
    for kind, y in zip(cycle(programme.halls), halls, strict=False):
        storey.add(kind, "hall", hall, y)
    shallow = draw.between(6.0, 7.5)
    for wing in ((-half_x, hall[0]), (hall[1], half_x)):
        if wing[1] - wing[0] < 4.0:
            continue
        _add_wing(storey, wing, half_y, shallow if draw.chance(0.5) else -shallow)
    return storey.finish()


def _add_wing(storey: _Storey, x: tuple[float, float], half_y: float, shallow: float) -> None:
    """A corridor between a shallow row of rooms and a deep one.

    The shallow row lies at y > 0 where `shallow` is positive. In a tall building a gallery covers
    it and the corridor, and sometimes the deep row too, whose rooms are as high as the hall else.
    """
    is_tall, draw = storey.programme.is_tall, storey.draw
    edge = snapped(half_y - shallow) if shallow > 0 else snapped(-half_y - shallow)
    far = edge - CORRIDOR_M if shallow > 0 else edge + CORRIDOR_M
    near_row = (edge, half_y) if shallow > 0 else (-half_y, edge)
    deep_row = (-half_y, far) if shallow > 0 else (far, half_y)
    is_covered = is_tall and draw.chance(0.35)
    storey.add("corridor", "corridor", x, (min(edge, far), max(edge, far)), is_low=is_tall)
    storey.add_row(x, near_row, along="x", pitch=draw.between(4.2, 5.4), is_low=is_tall)
    pitch = draw.between(8.0, 10.0)
    if draw.chance(storey.programme.rear_chance):
        middle = snapped((deep_row[0] + deep_row[1]) / 2)
        parts = ((deep_row[0], middle), (middle, deep_row[1]))
        front, rear = parts if shallow < 0 else parts[::-1]
        storey.add_row(x, front, along="x", pitch=pitch, is_low=is_covered)
        storey.add_row(x, rear, along="x", pitch=pitch, is_low=is_covered, is_rear=True)
    else:
        storey.add_row(x, deep_row, along="x", pitch=pitch, is_low=is_covered)
    if is_tall:
        covered = (min(far, near_row[0]), max(far, near_row[1]))
        storey.add_gallery(x, (-half_y, half_y) if is_covered else covered)


def plan_hall(
    draw: Draw, size: tuple[float, float], roof: float, programme: Programme
) -> tuple[Zone, ...]:
    """A hall of two to four open zones; rooms under a gallery along one end."""
    half_x, half_y = size[0] / 2 - WALL_M, size[1] / 2 - WALL_M
    storey = _Storey(draw, programme, roof)
    edge = snapped(-half_x + draw.between(6.2, 8.0))
    columns = 3 if half_x - edge >= 27.0 else 2
    step = (half_x - edge) / columns
    lines = [edge, *(snapped(edge + i * step) for i in range(1, columns)), half_x]
    rows = [-half_y, snapped(draw.between(-0.1, 0.1) * size[1]), half_y]
    halls = cycle(programme.halls)
    for x in pairwise(lines):
        for y in pairwise(rows):
            storey.add(next(halls), "hall", x, y)
    storey.add_row(
        (-half_x, edge), (-half_y, half_y), along="y", pitch=draw.between(6.5, 9.5), is_low=True
    )
    if programme.is_tall:
        storey.add_gallery((-half_x, edge), (-half_y, half_y))
    return storey.finish()


def clear_end_m(zone: Zone) -> float:
    """How much of a zone's longer side its open square takes where that lies at the end."""
    return zone.open_m + 0.2 if zone.open_m and zone.kind in _DENSE else 0.0


def open_place(zone: Zone) -> tuple[float, float]:
    """Middle of a zone's open square, from the zone's: at one end of zones full of furniture."""
    x, y = zone.size
    reach = (max(x, y) - zone.open_m) / 2 - 0.2 if zone.kind in _DENSE else 0.0
    return (0.0, reach) if y >= x else (reach, 0.0)
