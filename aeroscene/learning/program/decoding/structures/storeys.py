"""Storeys upon each other: what is open above is high, and what lies under a floor ends below it.

Each storey's tree is drawn for itself. An upper storey's rooms and voids must meet where high and
low rooms meet below, or a floor runs through the air of a hall.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

from aeroscene.learning.program.decoding.structures.alignment import Cut, aligned, lines_of
from aeroscene.partition import BuildingPart
from aeroscene.partition.cells import Cell, cells_of, merged
from aeroscene.partition.frames import Bounds, Frame, hull_of
from aeroscene.partition.tree import VOID, Leaf, Node, children, with_children
from aeroscene.scene import OrientedBox
from aeroscene.scene.catalogue import WALLS
from aeroscene.solids.shapes.facade import SLAB_M

_REACH_M = 4.0
"""Farthest that the edge of an upper floor moves to where high rooms end below it."""
_BESIDE_M = 0.2
"""Nearest that walls of two storeys run beside each other; nearer ones stand upon each other."""
_MEET_M = 1e-3
_LEAST_ROOM_M = 2.0
"""Least height of a room under a floor."""
_BEARING_M = 0.1
"""How far slabs reach into outer walls."""


@dataclass(frozen=True, slots=True)
class Level:
    """The tree of a storey, and the height of its rooms' underside."""

    tree: Node
    base_m: float
    wall_m: float
    """Thickness of its walls."""


def stacked(levels: Sequence[Level], frame: Frame, least_m: float) -> list[Node]:
    """Trees of storeys that fit upon each other.

    Args:
        levels: Storeys of one building, from the lowest up.
        frame: Theirs.
        least_m: Least width of a room.
    """
    trees = [level.tree for level in levels]
    for number in range(1, len(levels)):
        rise_m = levels[number].base_m - levels[number - 1].base_m
        if rise_m - SLAB_M < _LEAST_ROOM_M:
            continue
        below, above = trees[number - 1], trees[number]
        pairs = _pairs(_plan(below, frame), _plan(above, frame), rise_m)
        pairs += _beside(below, above, frame)
        above = aligned(above, frame.length_m, frame.width_m, pairs, least_m)
        trees[number - 1] = _under(below, above, frame, rise_m)
        trees[number] = above
    return trees


_Plan = list[tuple[Bounds, Cell]]


def _plan(tree: Node, frame: Frame) -> _Plan:
    return [(frame.bounds_of(cell.frame), cell) for cell in cells_of(tree, frame)]


def _pairs(below: _Plan, above: _Plan, rise_m: float) -> list[tuple[Cut, Cut]]:
    """Each edge of an upper floor with the nearest edge of a high room that it may move to."""
    is_high = [cell.leaf.kind == VOID or cell.top_m > rise_m for _, cell in below]
    ends = list(_edges([bounds for bounds, _ in below], is_high))
    edges = _edges([b for b, _ in above], [cell.leaf.kind == VOID for _, cell in above])
    return list(_nearest(edges, ends, _REACH_M))


def _beside(below: Node, above: Node, frame: Frame) -> list[tuple[Cut, Cut]]:
    """Each line of an upper storey that runs close beside one of the lower storey, with that."""
    lower, upper = (lines_of(tree, frame.length_m, frame.width_m) for tree in (below, above))
    return list(_nearest(upper, lower, _BESIDE_M))


def _nearest(
    cuts: Iterable[Cut], others: Sequence[Cut], reach_m: float
) -> Iterator[tuple[Cut, Cut]]:
    """Each line with the nearest of other lines that run along it within reach, if there is one."""
    for cut in cuts:
        near = [
            other
            for other in others
            if other.is_across_x == cut.is_across_x
            and abs(other.at - cut.at) < reach_m
            and min(other.high, cut.high) - max(other.low, cut.low) > _MEET_M
        ]
        if near:
            yield cut, min(near, key=lambda other: abs(other.at - cut.at))


def _edges(cells: Sequence[Bounds], is_marked: Sequence[bool]) -> Iterator[Cut]:
    """Where a marked cell meets one that is not."""
    for (low, low_is), (high, high_is) in permutations(zip(cells, is_marked, strict=True), 2):
        if low_is == high_is:
            continue
        for at in (0, 1):
            start, end = max(low[1 - at], high[1 - at]), min(low[3 - at], high[3 - at])
            if abs(low[at + 2] - high[at]) < _MEET_M and end - start > _MEET_M:
                yield Cut(high[at], start, end, is_across_x=at == 0)


def _under(below: Node, above: Node, frame: Frame, rise_m: float) -> Node:
    """The lower tree, its rooms low under floors, and high in the open."""
    upper = _plan(above, frame)
    floors = [bounds for bounds, cell in upper if cell.leaf.kind != VOID]
    lower = _plan(below, frame)
    tops_m = [cell.top_m for _, cell in lower] + [rise_m + cell.top_m for _, cell in upper]
    heights: list[float] = []
    for bounds, cell in lower:
        height_m = cell.leaf.height_m
        if any(_share(bounds, floor) for floor in floors):
            height_m = rise_m - SLAB_M
        elif cell.leaf.kind != VOID and height_m < rise_m:
            height_m = max(tops_m)
        heights.append(height_m)
    return _with_heights(below, iter(heights))


def _share(first: Bounds, second: Bounds) -> bool:
    """Whether two outlines have ground in common."""
    return all(
        min(first[at + 2], second[at + 2]) - max(first[at], second[at]) > _MEET_M for at in (0, 1)
    )


def _with_heights(node: Node, heights: Iterator[float]) -> Node:
    if isinstance(node, Leaf):
        return replace(node, height_m=next(heights))
    return with_children(node, tuple(_with_heights(child, heights) for child in children(node)))


def upper_slabs(
    levels: Sequence[Level], frame: Frame, parts: Sequence[BuildingPart], n_slabs: int
) -> list[OrientedBox]:
    """Slabs under the rooms of upper storeys: one for each, or one for all of a storey.

    Args:
        levels: Storeys of one building, from the lowest up.
        frame: Theirs.
        parts: Rooms and walls of the building.
        n_slabs: How many slabs are wanted; where there are fewer than rooms, storeys have one each.
    """
    plans = [merged([cell for _, cell in _plan(level.tree, frame)]) for level in levels[1:]]
    is_each = n_slabs >= sum(map(len, plans))
    found: list[OrientedBox] = []
    for level, cells in zip(levels[1:], plans, strict=True):
        outlines = [frame.bounds_of(cell.frame) for cell in cells]
        for outline in outlines if is_each else [hull_of(outlines)] if outlines else []:
            walls = [outline_in(frame, part) for part in parts if _passes(part, level.base_m)]
            others = [each for each in outlines if is_each and each != outline]
            bounds = _borne(outline, frame, level.wall_m / 2, walls, others)
            found.append(frame.inner(bounds).box(0, level.base_m - SLAB_M, level.base_m))
    return found


def _passes(part: BuildingPart, level_m: float) -> bool:
    """Whether a wall passes by the edge of a floor."""
    low_m, high_m = part.box.p[2] - part.box.s[2] / 2, part.box.p[2] + part.box.s[2] / 2
    return part.category in WALLS and low_m < level_m - _MEET_M and high_m > level_m - SLAB_M / 2


def outline_in(frame: Frame, part: BuildingPart) -> Bounds:
    """A part of a building from above, in a frame that it is aligned with."""
    x, y, yaw_rad = part.box.p[0], part.box.p[1], part.box.yaw_rad
    return frame.bounds_of(Frame(x, y, yaw_rad, part.box.s[0], part.box.s[1]))


def _borne(
    outline: Bounds,
    frame: Frame,
    edge_m: float,
    walls: Sequence[Bounds],
    others: Sequence[Bounds],
) -> Bounds:
    """A slab from outer walls to outer walls: over the walls below its edge, up to higher ones."""
    sides = list(outline)
    whole = (0.0, 0.0, frame.length_m, frame.width_m)
    for side, outwards in enumerate((-1.0, -1.0, 1.0, 1.0)):
        if abs(outline[side] - whole[side]) < _MEET_M:
            sides[side] += outwards * _BEARING_M
            continue
        at = side % 2
        beside = [each for each in walls if _is_met(outline, side, each)]
        faces = [wall[at] if outwards > 0 else wall[at + 2] for wall in beside]
        if faces:
            sides[side] = min(faces) if outwards > 0 else max(faces)
        elif not any(_is_met(outline, side, other) for other in others):
            sides[side] += outwards * edge_m
    return (sides[0], sides[1], sides[2], sides[3])


def _is_met(outline: Bounds, side: int, other: Bounds) -> bool:
    """Whether a side of an outline runs along another outline."""
    at = side % 2
    beside_m = min(outline[3 - at], other[3 - at]) - max(outline[1 - at], other[1 - at])
    return beside_m > _MEET_M and other[at] - _MEET_M < outline[side] < other[at + 2] + _MEET_M
