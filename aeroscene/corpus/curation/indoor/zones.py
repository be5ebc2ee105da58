"""Floor plans as rectangles: the borders at which zones meet, and the barriers between them.

A zone is a hall, a corridor, a gallery or a room. Halls, corridors and galleries flow into each
other; a room is walled and has one door, towards the zone through which it is reached.

Lines between zones lie in the middle of cells of a quarter metre, and doors are a whole number of
cells wide. A grid of that pitch, such as the planner's, therefore sees them at their true width.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import floor
from typing import Literal

from aeroscene.corpus.curation.frame import QUARTER

Role = Literal["hall", "corridor", "gallery", "room"]
Barrier = Literal["open", "rail", "wall"]
Side = Literal["x0", "x1", "y0", "y1"]

CELL_M = 0.25
_LEAST_SHARED_M = 0.3
"""Shortest common border of two zones that meet."""
JAMB_M = 0.5
"""Least wall on either side of a door."""
DOORS_M = (2.75, 2.25, 1.75, 1.5)
"""Widths of doors, the widest first: for large, medium and small drones, and in narrow walls."""
_DOOR_ROOM_M = (6.0, 3.8, 0.0, 0.0)
"""Least side of the room that gets a door of each of these widths."""
_PREFERENCE: dict[Role, int] = {"corridor": 0, "hall": 1, "gallery": 2, "room": 3}


class PlanError(ValueError):
    """Raised for a floor plan with a room that no door can reach."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """A rectangle of a storey, in the building's frame; its borders are the middles of walls."""

    kind: str
    """Kind of furniture."""
    role: Role
    x0: float
    y0: float
    x1: float
    y1: float
    level: float
    """Height of the slab's upper face."""
    clear: float
    """Height from the slab to the ceiling."""
    open_m: float = 0.0
    """Side of a square in the middle that stays free of furniture."""

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the sides, m."""
        return (self.x1 - self.x0, self.y1 - self.y0)

    @property
    def area(self) -> float:
        """Area, m2."""
        return self.size[0] * self.size[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class Border:
    """Common border of two zones: a vertical rectangle along x or y, in the building's frame, m."""

    zones: tuple[int, int]
    """Numbers of the zones on the low and on the high side of the line."""
    along: Literal["x", "y"]
    at: float
    """The line's other coordinate."""
    low: float
    high: float
    base: float
    top: float

    @property
    def length(self) -> float:
        """Length of the line, m."""
        return self.high - self.low

    def spot(self, place: float, across: float | None = None) -> tuple[float, float, float]:
        """Place an object on the line, or beside it.

        Args:
            place: Place along the line, m.
            across: Other coordinate, m; that of the line by default.

        Returns:
            Coordinates x and y in the building's frame, and the turn of the object, rad.
        """
        across = self.at if across is None else across
        return (across, place, 0.0) if self.along == "y" else (place, across, QUARTER)

    def side_of(self, zone: int) -> Side:
        """Return the side of a zone on which the border lies."""
        is_low = self.zones[0] == zone
        if self.along == "y":
            return "x1" if is_low else "x0"
        return "y1" if is_low else "y0"


def snapped(value: float) -> float:
    """The nearest middle of a cell, where a line between zones may run, m."""
    return (floor(value / CELL_M) + 0.5) * CELL_M


def find_borders(zones: Sequence[Zone]) -> list[Border]:
    """Find all borders between the zones of a plan.

    Args:
        zones: Zones; their numbers are those of the borders.
    """
    found: list[Border] = []
    for (i, a), (j, b) in combinations(enumerate(zones), 2):
        base, top = max(a.level, b.level), min(a.level + a.clear, b.level + b.clear)
        # Zones that share less than a metre of height do not meet.
        if top - base < 1.0:
            continue
        # Each zone may be the one on the low side.
        for first, second, low, high in ((i, j, a, b), (j, i, b, a)):
            if abs(low.x1 - high.x0) < 1e-6:
                span = (max(a.y0, b.y0), min(a.y1, b.y1))
                found += _border("y", (first, second), low.x1, span, (base, top))
            if abs(low.y1 - high.y0) < 1e-6:
                span = (max(a.x0, b.x0), min(a.x1, b.x1))
                found += _border("x", (first, second), low.y1, span, (base, top))
    return found


def _border(
    along: Literal["x", "y"],
    zones: tuple[int, int],
    at: float,
    span: tuple[float, float],
    rise: tuple[float, float],
) -> Iterable[Border]:
    if span[1] - span[0] >= _LEAST_SHARED_M:
        yield Border(
            zones=zones, along=along, at=at, low=span[0], high=span[1], base=rise[0], top=rise[1]
        )


def barrier(zones: Sequence[Zone], border: Border) -> Barrier:
    """Barrier between two zones that meet: a wall at rooms, a rail where a gallery ends."""
    first, second = (zones[i] for i in border.zones)
    if "room" in {first.role, second.role}:
        return "wall"
    return "open" if first.level == second.level else "rail"


def door_width(zone: Zone, border: Border) -> float | None:
    """Width of a room's door in a border, m; None if the border is too short for any.

    Small rooms get narrow doors, although a wide one might fit.
    """
    for width, least in zip(DOORS_M, _DOOR_ROOM_M, strict=True):
        if min(zone.size) >= least and border.length >= width + 2 * JAMB_M:
            return width
    return None


def choose_doors(zones: Sequence[Zone], borders: Sequence[Border]) -> dict[int, float]:
    """Choose borders for doors, so that every room is reached from zone 0.

    Returns:
        Widths of the doors under the numbers of their borders.

    Raises:
        PlanError: If a room meets no zone that is reached.
    """
    doors: dict[int, float] = {}
    # Zone 0 is the hall in which a flight starts.
    reached = _flow(zones, borders, {0})
    while len(reached) < len(zones):
        best: tuple[int, int, float, int, float, int] | None = None
        for index, border in enumerate(borders):
            inside = [i for i in border.zones if i in reached]
            outside = [i for i in border.zones if i not in reached]
            if len(inside) != 1 or barrier(zones, border) != "wall":
                continue
            near, far = zones[inside[0]], zones[outside[0]]
            width = door_width(far, border)
            # Doors connect zones of one level only; stairs do the rest.
            if width is None or near.level != far.level:
                continue
            # The lowest room first, then from a corridor rather than a room, then in the longest
            # border.
            rank = (outside[0], _PREFERENCE[near.role], -border.length, index, width, outside[0])
            if best is None or rank < best:
                best = rank
        if best is None:
            lost = sorted(set(range(len(zones))) - reached)
            raise PlanError(f"zones {lost} have no door; valid: each meets a zone that has one")
        doors[best[3]] = best[4]
        reached = _flow(zones, borders, reached | {best[5]})
    return doors


def _flow(zones: Sequence[Zone], borders: Sequence[Border], reached: set[int]) -> set[int]:
    """Zones that are reached without a door from those that are reached already."""
    found = set(reached)
    has_grown = True
    while has_grown:
        has_grown = False
        for border in borders:
            touching = found & set(border.zones)
            if len(touching) == 1 and barrier(zones, border) != "wall":
                found |= set(border.zones)
                has_grown = True
    return found
