"""The partition of a storey: a tree of rooms, and a border on each line between them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

from aeroscene.partition.cells import Cell, cells_of
from aeroscene.partition.frames import Frame
from aeroscene.partition.tree import VOID, Axis, Node, Part, PartitionError

SegmentKind = Literal["wall", "door", "window", "open"]

NOBODY = -1
"""Side of a line without a room: a void, or the outside."""
# Lines that are nearer than this are one, and shorter ones than the next are none.
_MEET_M = 1e-5
_LEAST_M = 0.01


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of the line between two rooms."""

    kind: SegmentKind
    part: Part
    """Doors and windows have a width in m; walls and open stretches share the rest."""
    sill_m: float = 0.0
    """Lower end of a door or window above the wall's underside."""
    head_m: float = 0.0
    """Upper end of a door or window above the wall's underside."""


@dataclass(frozen=True, slots=True)
class Border:
    """Segments of a line, from its low end."""

    segments: tuple[Segment, ...]
    form: str = ""
    """Word for the wall's form, such as `glass`."""


OPEN = Border((Segment("open", Part(1.0)),))


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreyPartition:
    """Division of one storey into rooms.

    Raises:
        PartitionError: If there is not one border for each line.
    """

    frame: Frame
    level_m: float
    """Height of the rooms' underside."""
    tree: Node
    borders: tuple[Border, ...]
    """One for each of `storey_lines`, in their order."""
    wall_m: float
    """Thickness of walls between rooms."""
    outer_m: float = 0.0
    """Thickness of walls to the outside; 0 if a shell stands around the storey."""
    drop_m: float = 0.0
    """Distance below the level at which walls beside a void begin, because they stand under the
    slab's edge."""
    is_inset: bool = True
    """True if rooms end at the faces of their walls. Otherwise they end at the lines, and outer
    walls stand beyond."""

    def __post_init__(self) -> None:
        count = len(storey_lines(self))
        if count != len(self.borders):
            raise PartitionError(f"storey.borders has {len(self.borders)} entries; valid: {count}")


@dataclass(frozen=True, slots=True)
class Line:
    """A line on which two rooms meet, or a room and nobody, in the frame of the storey."""

    axis: Axis
    """Axis along which it runs."""
    at: float
    low: float
    high: float
    rooms: tuple[int, int]
    """Numbers of the rooms on the side of lower and of higher coordinates; `NOBODY` for none."""


def storey_cells(storey: StoreyPartition) -> list[Cell]:
    """Return the leaves of a storey in pre-order, void ones too."""
    return list(cells_of(storey.tree, storey.frame, storey.level_m))


def room_numbers(cells: Sequence[Cell]) -> list[int]:
    """Return the room of each leaf, numbered by its first leaf; `NOBODY` for void leaves.

    Leaves of one merge number are one room.
    """
    numbers: dict[tuple[int, int], int] = {}
    return [
        NOBODY
        if cell.leaf.kind == VOID
        else numbers.setdefault((cell.leaf.merge, 0 if cell.leaf.merge else index), len(numbers))
        for index, cell in enumerate(cells)
    ]


def storey_lines(storey: StoreyPartition) -> list[Line]:
    """Return all lines between rooms: those along x first, sorted by place.

    Lines to the outside are included if the storey has outer walls.
    """
    cells = storey_cells(storey)
    return find_lines(cells, storey.frame, has_outside=storey.outer_m > 0)


def find_lines(cells: Sequence[Cell], frame: Frame, *, has_outside: bool) -> list[Line]:
    """Return the lines between leaves of a frame that belong to different rooms.

    Args:
        cells: Leaves of the storey.
        frame: Frame of the storey.
        has_outside: True adds the lines between rooms and the outside.
    """
    bounds = (frame.bounds_of(cell.frame) for cell in cells)
    rooms = list(zip(room_numbers(cells), bounds, strict=True))
    length, width = frame.length_m, frame.width_m
    # Four rectangles around the frame stand for the outside.
    beyond = [
        (NOBODY, (-1.0, 0.0, 0.0, width)),
        (NOBODY, (length, 0.0, length + 1.0, width)),
        (NOBODY, (0.0, -1.0, length, 0.0)),
        (NOBODY, (0.0, width, length, width + 1.0)),
    ]
    found: list[Line] = []
    axes: tuple[tuple[Axis, int], ...] = (("x", 1), ("y", 0))
    # Ordered pairs: each line is found once, with the lower room first.
    for (low_room, low), (high_room, high) in permutations(rooms + beyond * has_outside, 2):
        for axis, at in axes:
            start, end = max(low[1 - at], high[1 - at]), min(low[3 - at], high[3 - at])
            is_met = abs(low[at + 2] - high[at]) < _MEET_M and end - start > _MEET_M
            if is_met and low_room != high_room:
                # Two leaves of one room have no line between them.
                found.append(Line(axis, high[at], start, end, (low_room, high_room)))
    return [line for line in _joined(found) if line.high - line.low > _LEAST_M]


def _joined(lines: Iterable[Line]) -> list[Line]:
    """Sort lines, and join those that continue between the same rooms."""
    found: list[Line] = []
    for line in sorted(lines, key=lambda n: (n.axis, round(n.at, 4), n.rooms, n.low)):
        last = found[-1] if found else None
        if (
            last
            and (last.axis, last.rooms) == (line.axis, line.rooms)
            and abs(last.at - line.at) < _MEET_M
            and abs(last.high - line.low) < _MEET_M
        ):
            found[-1] = Line(last.axis, last.at, last.low, line.high, last.rooms)
        else:
            found.append(line)
    return sorted(found, key=lambda n: (n.axis, round(n.at, 4), n.low))
