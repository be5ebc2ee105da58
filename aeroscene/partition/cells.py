"""Places of a tree's leaves in a frame, which they fill without gap or overlap.

A tree holds shares; metres appear only here. Frames are nested from the root downwards, so that
rounding cannot open a gap: two neighbours take the same edge.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from aeroscene.partition.frames import Bounds, Frame, hull_of
from aeroscene.partition.tree import (
    VOID,
    Bend,
    Cross,
    Leaf,
    Node,
    Overlay,
    Part,
    Pinwheel,
    Slice,
    part_lengths,
)

# Edges that are nearer than this are one.
_MEET_M = 1e-6


@dataclass(frozen=True, slots=True)
class Cell:
    """A leaf at its place."""

    leaf: Leaf
    frame: Frame
    base_m: float
    """Height of its underside."""

    @property
    def top_m(self) -> float:
        """Height of its upper face."""
        return self.base_m + self.leaf.height_m


def cells_of(node: Node, frame: Frame, base_m: float = 0.0) -> Iterator[Cell]:
    """Yield the leaves below a node in pre-order.

    The tree on a leaf stands on the leaf's upper face.

    Args:
        node: The tree.
        frame: Its frame.
        base_m: Height of the frame's ground.

    Raises:
        PartitionError: If strips are wider than their frame.
    """
    match node:
        case Leaf():
            yield Cell(node, frame, base_m)
        case Slice():
            columns, rows = (node.parts, None) if node.axis == "x" else (None, node.parts)
            for child, bounds in zip(node.children, _grid(columns, rows, frame), strict=True):
                yield from cells_of(child, frame.inner(bounds), base_m)
        case Cross():
            for child, bounds in zip(
                node.cells, _grid(node.columns, node.rows, frame), strict=True
            ):
                yield from cells_of(child, frame.inner(bounds), base_m)
        case Pinwheel():
            nodes = (*node.arms, node.middle)
            for child, bounds in zip(nodes, _pinwheel(node, frame), strict=True):
                yield from cells_of(child, frame.inner(bounds), base_m)
        case Overlay():
            yield Cell(node.base, frame, base_m)
            for item in node.items:
                inner, place = frame, item.place
                if place is not None:
                    x, y = frame.length_m * place.x_share, frame.width_m * place.y_share
                    du, dv = place.size_m[0] / 2, place.size_m[1] / 2
                    inner = frame.inner((x - du, y - dv, x + du, y + dv), place.yaw_rad)
                yield from cells_of(item.tree, inner, base_m + node.base.height_m)
        case Bend():
            yield from _bend(node, frame, base_m)


def _edges(parts: tuple[Part, ...] | None, length_m: float) -> list[float]:
    if parts is None:
        return [0.0, length_m]
    # The last edge is the side itself, not a sum with its rounding error.
    return [0.0, *list(accumulate(part_lengths(parts, length_m)))[:-1], length_m]


def _grid(
    columns: tuple[Part, ...] | None, rows: tuple[Part, ...] | None, frame: Frame
) -> Iterator[Bounds]:
    # Row by row, as `Cross.cells` lists them.
    for y0, y1 in pairwise(_edges(rows, frame.width_m)):
        for x0, x1 in pairwise(_edges(columns, frame.length_m)):
            yield (x0, y0, x1, y1)


def _pinwheel(node: Pinwheel, frame: Frame) -> list[Bounds]:
    x, y = frame.length_m, frame.width_m
    west, east, south, north = (c * side for c, side in zip(node.cuts, (x, x, y, y), strict=True))
    middle = (west, south, east, north)
    if node.is_mirrored:
        arms = [(west, 0, x, south), (east, south, x, y), (0, north, east, y), (0, 0, west, north)]
    else:
        arms = [(0, 0, east, south), (east, 0, x, north), (west, north, x, y), (0, south, west, y)]
    return [*arms, middle]


def bend_pieces(bend: Bend, frame: Frame) -> list[Frame]:
    """Return frames over the pieces of a bend.

    They are as long as the middle line and as wide as the lanes; at a turn neighbours overlap.
    """
    x, y = frame.point(bend.start[0] * frame.length_m, bend.start[1] * frame.width_m)
    heading = frame.yaw_rad + bend.heading_rad
    pieces: list[Frame] = []
    for length, turn in zip(bend.lengths_m, (0.0, *bend.turns_rad), strict=True):
        heading += turn
        dx, dy = length * math.cos(heading), length * math.sin(heading)
        pieces.append(Frame(x + dx / 2, y + dy / 2, heading, length, bend.width_m))
        x, y = x + dx, y + dy
    return pieces


def lane_reach(low: float, high: float, turn_rad: float) -> float:
    """Length by which a lane reaches beyond its middle line's end at a bend, without a gap.

    Lanes on the outside of a turn are longer than the middle line, and lanes on its inside are
    shorter: their reach is negative.

    Args:
        low: Right edge of the lane, to the left of the middle line, m.
        high: Left edge likewise.
        turn_rad: Left turn at the bend; 0 at either end of the chain.
    """
    return (
        max(-low, -high) * math.tan(turn_rad / 2)
        if turn_rad > 0
        else max(low, high) * math.tan(-turn_rad / 2)
    )


def _bend(bend: Bend, frame: Frame, base_m: float) -> Iterator[Cell]:
    half = bend.width_m / 2
    edges = [0.0, *accumulate(lane.width_m for lane in bend.lanes)]
    turns = (0.0, *bend.turns_rad, 0.0)
    for number, piece in enumerate(bend_pieces(bend, frame)):
        for lane, (low, high) in zip(bend.lanes, pairwise(edges), strict=True):
            before, after = (
                lane_reach(low - half, high - half, turns[number + end]) for end in (0, 1)
            )
            leaf = Leaf(lane.kind, lane.heights_m[number], lane.quarter)
            yield Cell(leaf, piece.inner((-before, low, piece.length_m + after, high)), base_m)
        for side, bank in enumerate(bend.banks[2 * number : 2 * number + 2]):
            if bank is None:
                # Bank 0 lies to the right of the lanes, bank 1 to their left.
                continue
            u0, u1 = bank.low_share * piece.length_m, bank.high_share * piece.length_m
            v0, v1 = (-bank.depth_m, 0.0) if side == 0 else (2 * half, 2 * half + bank.depth_m)
            yield from cells_of(bank.tree, piece.inner((u0, v0, u1, v1)), base_m)


def merged(cells: Sequence[Cell]) -> list[Cell]:
    """Join cells of one merge number to as few as possible.

    A room of several leaves thereby becomes one box, or a few; void cells are left out.
    """
    return [cell for _, cell in merged_from(cells)]


def merged_from(cells: Sequence[Cell]) -> list[tuple[int, Cell]]:
    """Join cells as `merged` does.

    Returns:
        Each joined cell with the number of the first cell that is part of it.
    """
    groups: dict[tuple[int, int], list[int]] = defaultdict(list)
    for index, cell in enumerate(cells):
        if cell.leaf.kind != VOID:
            merge = cell.leaf.merge
            # Merge number 0 means a cell by itself, so its index keeps it apart.
            groups[merge, 0 if merge else index].append(index)
    return [
        (group[0], cell) for group in groups.values() for cell in _joined([cells[i] for i in group])
    ]


def _joined(group: list[Cell]) -> list[Cell]:
    """Return one cell if a group fills a rectangle, else rows of it with equal ones joined."""
    frame = group[0].frame
    if len(group) == 1:
        return group
    bounds = [frame.bounds_of(cell.frame) for cell in group]
    hull = hull_of(bounds)
    # The cells do not overlap, so equal areas mean that they fill their hull.
    if math.isclose(sum(map(_area, bounds)), _area(hull), abs_tol=_MEET_M * _area(hull)):
        found = [hull]
    else:
        found = _join_along(_join_along(bounds, 0), 1)
    return [Cell(group[0].leaf, frame.inner(each), group[0].base_m) for each in found]


def _join_along(all_bounds: list[Bounds], axis: int) -> list[Bounds]:
    """Join rectangles that meet end to end along an axis and are equally wide."""
    found: list[Bounds] = []
    for bounds in sorted(all_bounds, key=lambda b: (b[1 - axis], b[axis])):
        last = found[-1] if found else None
        is_same = last is not None and all(
            abs(last[i + 1 - axis] - bounds[i + 1 - axis]) < _MEET_M for i in (0, 2)
        )
        if last is not None and is_same and abs(last[axis + 2] - bounds[axis]) < _MEET_M:
            found[-1] = hull_of((last, bounds))
        else:
            found.append(bounds)
    return found


def _area(bounds: Bounds) -> float:
    return (bounds[2] - bounds[0]) * (bounds[3] - bounds[1])
