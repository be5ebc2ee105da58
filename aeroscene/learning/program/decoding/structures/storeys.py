"""Storeys upon each other: open space above needs high rooms below, and floors end low ones.

Each storey's tree is drawn by itself. The edges of an upper floor must meet the places where high
and low rooms meet below, or a floor runs through the air of a hall. Walls of two storeys that run
close beside each other become one. The upper tree moves, the lower one keeps its lines and adapts
its heights.
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
"""Greatest distance by which the edge of an upper floor moves to the end of a high room below."""
_BESIDE_M = 0.2
"""Walls of two storeys that are nearer than this stand upon each other."""
_MEET_M = 1e-3
_LEAST_ROOM_M = 2.0
"""Least height of a room under a floor."""
_BEARING_M = 0.1
"""Depth by which slabs reach into outer walls."""


@dataclass(frozen=True, slots=True)
class Level:
    """Tree of a storey, and the height of its rooms' underside."""

    tree: Node
    base_m: float
    wall_m: float
    """Thickness of its walls."""


def stacked(levels: Sequence[Level], frame: Frame, least_m: float) -> list[Node]:
    """Return trees of storeys that fit upon each other.

    Args:
        levels: Storeys of one building, from the lowest up.
        frame: Their frame.
        least_m: Least width of a room.
    """
    trees = [level.tree for level in levels]
    for number in range(1, len(levels)):
        rise_m = levels[number].base_m - levels[number - 1].base_m
        # There is no room under this floor, so the storeys are not fitted to each other.
        if rise_m - SLAB_M < _LEAST_ROOM_M:
            continue
        below, above = trees[number - 1], trees[number]
        pairs = _pairs(_plan(below, frame), _plan(above, frame), rise_m)
        pairs += _beside(below, above, frame)
        # First the upper floor moves to the rooms below, then their heights follow it.
        above = aligned(above, frame.length_m, frame.width_m, pairs, least_m)
        trees[number - 1] = _under(below, above, frame, rise_m)
        trees[number] = above
    return trees


_Plan = list[tuple[Bounds, Cell]]


def _plan(tree: Node, frame: Frame) -> _Plan:
    return [(frame.bounds_of(cell.frame), cell) for cell in cells_of(tree, frame)]


def _pairs(below: _Plan, above: _Plan, rise_m: float) -> list[tuple[Cut, Cut]]:
    """Pair each edge of an upper floor with the nearest edge of a high room that it may move to."""
    is_high = [cell.leaf.kind == VOID or cell.top_m > rise_m for _, cell in below]
    ends = list(_edges([bounds for bounds, _ in below], is_high))
    edges = _edges([b for b, _ in above], [cell.leaf.kind == VOID for _, cell in above])
    return list(_nearest(edges, ends, _REACH_M))


def _beside(below: Node, above: Node, frame: Frame) -> list[tuple[Cut, Cut]]:
    """Pair each line of an upper storey with a line close beside it in the lower storey."""
    lower, upper = (lines_of(tree, frame.length_m, frame.width_m) for tree in (below, above))
    return list(_nearest(upper, lower, _BESIDE_M))


def _nearest(
    cuts: Iterable[Cut], others: Sequence[Cut], reach_m: float
) -> Iterator[tuple[Cut, Cut]]:
    """Pair each line with the nearest parallel line within reach, if there is one."""
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
    """Yield the lines on which a marked cell meets one that is not marked."""
    for (low, low_is), (high, high_is) in permutations(zip(cells, is_marked, strict=True), 2):
        if low_is == high_is:
            continue
        for at in (0, 1):
            start, end = max(low[1 - at], high[1 - at]), min(low[3 - at], high[3 - at])
            if abs(low[at + 2] - high[at]) < _MEET_M and end - start > _MEET_M:
                yield Cut(high[at], start, end, is_across_x=at == 0)


def _under(below: Node, above: Node, frame: Frame, rise_m: float) -> Node:
    """Return the lower tree with rooms that are low under floors, and high in the open."""
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
            # An open low room would end in the air: it reaches up to the highest ceiling.
            height_m = max(tops_m)
        heights.append(height_m)
    return _with_heights(below, iter(heights))


def _share(first: Bounds, second: Bounds) -> bool:
    """True if two outlines have ground in common."""
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
    """Return slabs under the rooms of upper storeys: one for each, or one for each storey.

    Args:
        levels: Storeys of one building, from the lowest up.
        frame: Their frame.
        parts: Rooms and walls of the building.
        n_slabs: Number of slabs wanted; if it is less than the number of rooms, each storey has
            one.
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
    """True if a wall passes by the edge of a floor."""
    low_m, high_m = part.box.p[2] - part.box.s[2] / 2, part.box.p[2] + part.box.s[2] / 2
    return part.category in WALLS and low_m < level_m - _MEET_M and high_m > level_m - SLAB_M / 2


def outline_in(frame: Frame, part: BuildingPart) -> Bounds:
    """Return a part of a building from above, in a frame that it is aligned with."""
    x, y, yaw_rad = part.box.p[0], part.box.p[1], part.box.yaw_rad
    return frame.bounds_of(Frame(x, y, yaw_rad, part.box.s[0], part.box.s[1]))


def _borne(
    outline: Bounds,
    frame: Frame,
    edge_m: float,
    walls: Sequence[Bounds],
    others: Sequence[Bounds],
) -> Bounds:
    """Extend a slab at each side: into the outer wall, over a wall below, or up to a higher one."""
    sides = list(outline)
    whole = (0.0, 0.0, frame.length_m, frame.width_m)
    for side, outwards in enumerate((-1.0, -1.0, 1.0, 1.0)):
        # A side on the rim of the building lies on the outer wall.
        if abs(outline[side] - whole[side]) < _MEET_M:
            sides[side] += outwards * _BEARING_M
            continue
        at = side % 2
        beside = [each for each in walls if _is_met(outline, side, each)]
        faces = [wall[at] if outwards > 0 else wall[at + 2] for wall in beside]
        if faces:
            sides[side] = min(faces) if outwards > 0 else max(faces)
        # A free edge, which meets no wall and no other slab, reaches half a
        # wall's thickness further.
        elif not any(_is_met(outline, side, other) for other in others):
            sides[side] += outwards * edge_m
    return (sides[0], sides[1], sides[2], sides[3])


def _is_met(outline: Bounds, side: int, other: Bounds) -> bool:
    """True if a side of an outline runs along another outline."""
    at = side % 2
    beside_m = min(outline[3 - at], other[3 - at]) - max(outline[1 - at], other[1 - at])
    return beside_m > _MEET_M and other[at] - _MEET_M < outline[side] < other[at + 2] + _MEET_M
