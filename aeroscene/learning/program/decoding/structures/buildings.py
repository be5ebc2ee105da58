"""Storeys of a building from their tokens: rooms, and walls with openings that fit."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, replace

from aeroscene.learning.program.decoding.draft.trees import TreeReader
from aeroscene.learning.program.decoding.structures.alignment import snapped
from aeroscene.learning.program.decoding.structures.roofs import roofs_over, with_one_ceiling
from aeroscene.learning.program.decoding.structures.storeys import Level, stacked, upper_slabs
from aeroscene.learning.program.decoding.structures.strips import settled
from aeroscene.learning.program.encoding.partitions import first_leaves, owner_of
from aeroscene.learning.program.kinds import SplitKind
from aeroscene.learning.program.nesting import cells
from aeroscene.learning.program.program import Program
from aeroscene.partition import (
    Border,
    BuildingPart,
    Segment,
    StoreyPartition,
    build_storeys,
    from_sequence,
)
from aeroscene.partition.cells import cells_of
from aeroscene.partition.frames import Frame
from aeroscene.partition.sequences.read import read_border
from aeroscene.partition.sequences.record import Record
from aeroscene.partition.storeys.storey import OPEN, Line, find_lines, room_numbers
from aeroscene.partition.tree import Node, Part
from aeroscene.relations.plane import Rectangle
from aeroscene.scene import OrientedBox
from aeroscene.scene.catalogue import ROOMS

Place = int | None
WALL = Border((Segment("wall", Part(1.0)),))
_ROOM_M = 0.3
"""Least width of a room between its walls."""
# Least thickness of a wall, and least side of a storey.
_LEAST_WALL_M = 0.02
_LEAST_SIDE_M = 1.0
_STOREY_M = 1.2
"""Least height of an upper storey's floor above the first one's."""
_SAME_M = 1e-3


@dataclass(frozen=True, slots=True)
class DecodedBuilding:
    """The storeys of a building, one upon the other."""

    frame: Frame
    levels: tuple[Level, ...]
    parts: tuple[tuple[BuildingPart, Place], ...]
    """Rooms and walls, each with its token."""

    def is_upper(self, slab: OrientedBox) -> bool:
        """True if a slab belongs to an upper storey."""
        top_m = slab.p[2] + slab.s[2] / 2
        return bool(self.levels[1:]) and top_m - self.levels[0].base_m > _STOREY_M

    def under_rooms(self, slab: OrientedBox) -> OrientedBox:
        """Return a slab at the level of the first storey's rooms.

        A slab that lies a storey or more off is another one's and stays.
        """
        z_m = self.levels[0].base_m - slab.s[2] / 2
        if not _SAME_M < abs(z_m - slab.p[2]) < _STOREY_M:
            return slab
        return replace(slab, p=(*slab.p[:2], z_m))

    def upper_slabs(self, n_slabs: int) -> list[OrientedBox]:
        """Return slabs under the rooms above the first storey, about `n_slabs` of them."""
        return upper_slabs(self.levels, self.frame, [part for part, _ in self.parts], n_slabs)

    def with_one_ceiling(self) -> DecodedBuilding:
        """Return the building with one ceiling height, that of most rooms and walls.

        It is for houses without a building around them, which would state their heights.
        """
        level = with_one_ceiling([part for part, _ in self.parts])
        tokens = (token for _, token in self.parts)
        return replace(self, parts=tuple(zip(level, tokens, strict=True)))

    def roofs(self, thickness_m: float) -> list[OrientedBox]:
        """Return the tiles of a roof over all rooms and walls."""
        return roofs_over([part for part, _ in self.parts], self.frame, thickness_m)


def build_building(
    program: Program, reader: TreeReader, storeys: Sequence[int], host: Rectangle, base_m: float
) -> DecodedBuilding:
    """Build the rooms and walls of a building's storeys.

    Args:
        program: The program.
        reader: Reads its records.
        storeys: Places of the storeys' tokens, from the lowest up.
        host: The building, or the site, seen from above.
        base_m: Height of its underside.
    """
    frame = _frame(program.channels[storeys[0], 1:11].tolist(), host)
    drawn: list[_Storey] = []
    for place in storeys:
        # The level of each storey counts from the one below.
        base_m += float(program.channels[place, 7])
        drawn.append(_Storey(program, reader, place, frame, base_m))
    levels = [Level(storey.tree, storey.level_m, storey.wall_m) for storey in drawn]
    # Trees are drawn storey by storey and have to be fitted upon each other before walls are built.
    trees = stacked(levels, frame, max(storey.least_m for storey in drawn))
    parts = build_storeys(
        [storey.partition(tree) for storey, tree in zip(drawn, trees, strict=True)]
    )
    return DecodedBuilding(
        frame,
        tuple(replace(level, tree=tree) for level, tree in zip(levels, trees, strict=True)),
        tuple((part, drawn[part.storey].token(part)) for part in parts),
    )


def _frame(values: Sequence[float], host: Rectangle) -> Frame:
    x, y, cos, sin, length, width = (0.0 if math.isnan(v) else v for v in values[:6])
    place = host.place.moved(x, y, math.atan2(sin, cos or 1.0))
    # Sides of at least 1 m, or of the whole building if that is smaller.
    sides = (
        max(2 * half - less, min(2 * half, _LEAST_SIDE_M))
        for half, less in zip(host.half_m, (length, width), strict=True)
    )
    return Frame(place.x_m, place.y_m, place.yaw_rad, *sides)


class _Storey:
    """One storey, with the tokens of its leaves and borders."""

    def __init__(
        self, program: Program, trees: TreeReader, place: int, frame: Frame, level_m: float
    ) -> None:
        self._program, self._trees = program, trees
        self.frame, self.level_m = frame, level_m
        grown, self._widths = trees.head(place)
        wall_m, outer_m, self._drop_m = program.channels[place, 8:11].tolist()
        self.wall_m = max(wall_m, _LEAST_WALL_M)
        self._outer_m = outer_m if outer_m > _LEAST_WALL_M else 0.0
        self.least_m = self.wall_m + _ROOM_M
        self._is_inset = grown.record.is_inset
        # Read as a site: that is a tree without borders, which are built later.
        head = Record("site", values=(*astuple(frame), level_m))
        plain = from_sequence([*self._widths, head, *grown.flat()[1:]])
        sides_m = frame.length_m, frame.width_m
        tree = settled(plain.tree, *sides_m, self.least_m)
        self.tree = snapped(tree, *sides_m, self.wall_m, self.least_m)
        self._leaves: list[Place] = [token for token, _ in cells(grown)]
        self._border_places: list[Place] = []

    def token(self, part: BuildingPart) -> Place:
        """Return the place of the token of a room or wall of this storey."""
        return (self._leaves if part.category in ROOMS else self._border_places)[part.place]

    def partition(self, tree: Node) -> StoreyPartition:
        """Return the storey with a tree that differs from its own in numbers only."""
        found = list(cells_of(tree, self.frame, self.level_m))
        lines = find_lines(found, self.frame, has_outside=self._outer_m > 0)
        return StoreyPartition(
            frame=self.frame,
            level_m=self.level_m,
            tree=tree,
            borders=tuple(self._borders(lines, room_numbers(found))),
            wall_m=self.wall_m,
            outer_m=self._outer_m,
            drop_m=self._drop_m,
            is_inset=self._is_inset,
        )

    def _borders(self, lines: Sequence[Line], rooms: Sequence[int]) -> list[Border]:
        """Return a border for each line: the drawn one of its two rooms, or a default.

        A room whose drawn borders all have walls gets walls at its other lines, too.
        """
        children = self._trees.children
        kinds = self._program.kinds
        known: defaultdict[tuple[int, int, int], list[int]] = defaultdict(list)
        for leaf, token in enumerate(self._leaves):
            for each in [] if token is None else children[token]:
                if isinstance(kind := kinds[each], SplitKind) and kind.node == "border":
                    known[leaf, kind.side, int(self._program.host[each])].append(each)
        is_closed = self._closed(known)
        first = first_leaves(rooms)
        found: list[Border] = []
        for line in lines:
            leaf, side, beyond = owner_of(line, first, len(rooms))
            # Of several borders between two rooms each line takes the next one.
            drawn = known[leaf, side, beyond]
            place = drawn.pop(0) if drawn else None
            self._border_places.append(place)
            default = (
                WALL if any(is_closed[i] for i in (leaf, (leaf + beyond) % len(rooms))) else OPEN
            )
            border = default if place is None else self._border(place)
            found.append(_with_room(border, line.high - line.low, self.wall_m))
        return found

    def _closed(self, known: Mapping[tuple[int, int, int], Sequence[int]]) -> list[bool]:
        """Mark the leaves whose room has walls at all of its drawn borders."""
        found: list[set[bool]] = [set() for _ in self._leaves]
        for (leaf, _, beyond), places in known.items():
            for place in places:
                has_wall = self._program.kinds[place].category != "open"
                found[leaf].add(has_wall)
                found[(leaf + beyond) % len(found)].add(has_wall)
        return [each == {True} for each in found]

    def _border(self, place: int) -> Border:
        kind = self._program.kinds[place]
        if kind.category == "open":
            return OPEN
        form = str(dict(kind.attributes).get("form", ""))
        grown = self._trees.border(place, len(self._widths))
        if kind.category == "wall" or not grown.children:
            return replace(WALL, form=form)
        return read_border([*self._widths, *grown.flat()])


def _with_room(border: Border, length_m: float, wall_m: float) -> Border:
    """Return a border if its doors and windows fit into the line, else a wall."""
    fixed_m = sum(segment.part.value for segment in border.segments if segment.part.is_width)
    if fixed_m <= 0 or fixed_m + wall_m < length_m:
        return border
    return replace(WALL, form=border.form)
