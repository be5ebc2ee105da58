"""Walls on the lines between rooms: their ends, heights and openings.

Walls along y run through corners, and walls along x end at their faces, so that none overlap. With
`is_inset` walls stand in the middle of their lines; otherwise walls to nobody stand beyond theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

from aeroscene.partition.cells import Cell
from aeroscene.partition.frames import Bounds
from aeroscene.partition.storeys.storey import (
    NOBODY,
    Line,
    Segment,
    StoreyPartition,
    room_numbers,
    storey_cells,
    storey_lines,
)
from aeroscene.partition.tree import Axis, part_lengths

# Ends that are nearer than this meet.
_POINT_M = 1e-3


@dataclass(frozen=True, slots=True)
class Opening:
    """A door or window along a wall."""

    segment: Segment
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Wall:
    """A wall in the frame of its storey."""

    line: Line
    low: float
    high: float
    base_m: float
    top_m: float
    thickness_m: float
    beyond: int = 0
    """Side of the line on which it stands, -1 or 1; 0 for on the line."""
    openings: tuple[Opening, ...] = ()
    form: str = ""
    storey: int = 0
    border: int = 0
    """Number of its border in the storey."""

    @property
    def axis(self) -> Axis:
        """Axis along which it runs."""
        return self.line.axis

    @property
    def bounds(self) -> Bounds:
        """Its outline in the storey's frame."""
        middle = self.line.at + self.beyond * self.thickness_m / 2
        low, high = middle - self.thickness_m / 2, middle + self.thickness_m / 2
        if self.axis == "x":
            return (self.low, low, self.high, high)
        return (low, self.low, high, self.high)

    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the points of the line at which it begins and ends."""
        at = self.line.at
        return (
            ((self.low, at), (self.high, at))
            if self.axis == "x"
            else ((at, self.low), (at, self.high))
        )


def plan_walls(storey: StoreyPartition, number: int = 0) -> list[Wall]:
    """Return the walls of a storey, as long as their stretches of lines.

    `fitted` then lets them meet at corners.

    Args:
        storey: The storey.
        number: Its number, which the walls keep.
    """
    cells = storey_cells(storey)
    heights = dict(zip(room_numbers(cells), cells, strict=True))
    found: list[Wall] = []
    lines = zip(storey_lines(storey), storey.borders, strict=True)
    for index, (line, border) in enumerate(lines):
        base, top = wall_heights(line, heights, storey.drop_m)
        is_outer = NOBODY in line.rooms and not storey.is_inset
        beyond = 0 if not is_outer else (-1 if line.rooms[0] == NOBODY else 1)
        thickness = storey.outer_m if is_outer else storey.wall_m
        plain = Wall(line, 0.0, 0.0, base, top, thickness, beyond, (), border.form, number, index)
        found += _runs(plain, border.segments)
    return found


def wall_heights(line: Line, cells: dict[int, Cell], drop_m: float) -> tuple[float, float]:
    """Return underside and top of a wall.

    It is as high as the lower of both rooms. Beside a void it begins lower by the thickness of a
    slab.
    """
    rooms = [cells[room] for room in line.rooms if room != NOBODY]
    base = max(cell.base_m for cell in rooms) - (drop_m if len(rooms) == 1 else 0.0)
    return base, min(cell.top_m for cell in rooms)


def _runs(plain: Wall, segments: Sequence[Segment]) -> list[Wall]:
    """Return a wall for each run of segments that are not open.

    Each has at most one door and one window.
    """
    line = plain.line
    lengths = part_lengths(tuple(s.part for s in segments), line.high - line.low)
    edges = [line.low, *(line.low + at for at in accumulate(lengths[:-1])), line.high]
    found: list[Wall] = []
    is_going_on = False
    for segment, (low, high) in zip(segments, pairwise(edges), strict=True):
        if segment.kind == "open":
            is_going_on = False
            continue
        if not is_going_on:
            found.append(replace(plain, low=low, high=high))
            is_going_on = True
        if segment.kind != "wall":
            last = found[-1]
            # A wall object has attributes for one door and one window, so a
            # second door begins a new wall.
            if any(o.segment.kind == segment.kind for o in last.openings):
                cut = (last.openings[-1].high + low) / 2
                found[-1] = replace(last, high=cut)
                found.append(replace(plain, low=cut))
            last = found[-1]
            found[-1] = replace(last, openings=(*last.openings, Opening(segment, low, high)))
        found[-1] = replace(found[-1], high=high)
    return found


def fitted(walls: Sequence[Wall]) -> list[Wall]:
    """Return walls that are cut back or extended where they meet.

    An inner wall that is then shorter than it is thick is left out. An outer wall stays however
    short, because it closes a step of the outline.

    Args:
        walls: Walls of all storeys of a building, because walls of different storeys may meet.
    """
    found: list[Wall] = []
    for wall in walls:
        reach = [_reach(wall, end, [o for o in walls if _meets(wall, end, o)]) for end in (0, 1)]
        low, high = wall.low - reach[0], wall.high + reach[1]
        if high - low > (_POINT_M if wall.beyond else wall.thickness_m):
            found.append(replace(wall, low=low, high=high))
    return found


def _meets(wall: Wall, end: int, other: Wall) -> bool:
    if other is wall or other.base_m >= wall.top_m or other.top_m <= wall.base_m:
        return False
    return any(_is_same(wall.ends()[end], point) for point in other.ends())


def _is_same(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return abs(a[0] - b[0]) < _POINT_M and abs(a[1] - b[1]) < _POINT_M


def _reach(wall: Wall, end: int, met: list[Wall]) -> float:
    """Length by which a wall continues beyond an end; negative if it is cut back."""
    outwards = -1 if end == 0 else 1
    if wall.beyond:
        return _outer_reach(wall, outwards, [o for o in met if o.beyond and o.axis != wall.axis])
    met = [other for other in met if not other.beyond]
    across = [other for other in met if other.axis != wall.axis]
    if not across:
        return 0.0
    half = max(other.thickness_m for other in across) / 2
    if wall.axis == "x":
        return -half
    # Of two walls along y in one line, the later one runs through the corner.
    point = wall.ends()[end]
    is_passed_on = end == 1 and any(o.axis == "y" and _is_same(o.ends()[0], point) for o in met)
    return -half if is_passed_on else half


def _outer_reach(wall: Wall, outwards: int, across: list[Wall]) -> float:
    """Return how far an outer wall continues at a corner.

    Around a convex corner of the house the wall along y is extended; in a concave corner the wall
    along x is cut back.
    """
    for other in across:
        if wall.axis == "y" and other.beyond == outwards:
            return other.thickness_m
        if wall.axis == "x" and other.beyond == -outwards and _turns_in(wall, other):
            return -other.thickness_m
    return 0.0


def _turns_in(wall: Wall, other: Wall) -> bool:
    """True if another wall runs on the side on which a wall stands beyond its line."""
    middle = (other.low + other.high) / 2
    return (middle - wall.line.at) * wall.beyond > 0
