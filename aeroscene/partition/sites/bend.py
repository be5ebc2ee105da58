"""Reading of a street that bends: pieces that overlap where they turn, and covers beside them.

Carriageways are sorted along the street. Strips that follow every carriageway are its lanes, and
other covers belong to the bank of the nearest piece. Pieces of a real street overlap at a bend; the
tree holds the middle line without that overlap, and `lane_reach` adds it again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from aeroscene.partition.cells import bend_pieces, lane_reach
from aeroscene.partition.fit import SAME_M, Piece, Widths, fit
from aeroscene.partition.frames import Bounds, Frame, frame_of, hull_of, nearest_quarter
from aeroscene.partition.tree import Bank, Bend, Lane, Leaf, Overlay, PartitionError
from aeroscene.scene import SceneObject
from aeroscene.scene.catalogue import ROADS, STRIPS

# Headings that differ by less are aligned.
_SAME_RAD = 0.01
_LEAST_LENGTH = 0.6
"""Least length of a lane, as a share of its carriageway's."""

MakeNode = Callable[[SceneObject, float], Leaf | Overlay]
"""Function that makes the leaf of a cover in a frame of a heading, rad, with covers on it."""
_Lane = tuple[SceneObject, float, float]
"""Object with its right and left edge in the frame of the piece's carriageway, m."""


def fit_bend(
    bodies: Sequence[SceneObject],
    node: MakeNode,
    widths: Widths,
    word: Callable[[SceneObject], str],
) -> tuple[Frame, Bend] | None:
    """Fit a bend to covers, in the frame of its mean heading; None if they form none.

    Args:
        bodies: Covers side by side.
        node: Makes the leaf of a cover.
        widths: The widths of the lanes are added to it.
        word: Kind of the leaf that a cover becomes.

    Raises:
        PartitionError: If a cover lies across the lanes or is turned against all pieces.
    """
    roads = _chain([obj for obj in bodies if obj.category in ROADS])
    if len(roads) < 2:
        return None
    headings = _headings(roads)
    frames = [frame_of(road.bbox, yaw) for road, yaw in zip(roads, headings, strict=True)]
    rest = [obj for obj in bodies if obj not in roads]
    lanes = _common(roads, frames, rest)
    strips = {obj.id for each in lanes for obj, _, _ in each}
    beside = [obj for obj in rest if obj.id not in strips]
    whole = _whole_frame(bodies, sum(headings) / len(headings))
    bend = _without_banks(lanes, frames, headings, whole, widths, word)
    return whole, _with_banks(bend, bend_pieces(bend, whole), beside, node, widths)


def _chain(roads: list[SceneObject]) -> list[SceneObject]:
    """Sort roads along the line through the two that are furthest apart."""
    if len(roads) < 2:
        return roads
    pairs = [(a, b) for a in roads for b in roads]
    first, last = max(pairs, key=lambda p: math.dist(p[0].bbox.p[:2], p[1].bbox.p[:2]))
    dx, dy = (last.bbox.p[i] - first.bbox.p[i] for i in (0, 1))
    return sorted(roads, key=lambda o: o.bbox.p[0] * dx + o.bbox.p[1] * dy)


def _headings(roads: list[SceneObject]) -> list[float]:
    """Return headings along the chain, each within half a turn of the one before.

    Raises:
        PartitionError: If a turn is not from `_SAME_RAD` to 1.2 rad.
    """
    dx, dy = (roads[-1].bbox.p[i] - roads[0].bbox.p[i] for i in (0, 1))
    last = math.atan2(dy, dx)
    headings: list[float] = []
    for road in roads:
        # A road may have been drawn in either direction, so half turns are removed.
        turn = math.remainder(road.bbox.yaw_rad - last, math.pi)
        last += turn
        headings.append(last)
    turns = [b - a for a, b in pairwise(headings)]
    if max(map(abs, turns)) > 1.2 or min(map(abs, turns)) < _SAME_RAD:
        raise PartitionError(f"a bend turns by {turns} rad; valid: {_SAME_RAD} to 1.2")
    return headings


def _lanes(road: SceneObject, frame: Frame, others: Sequence[SceneObject]) -> list[list[_Lane]]:
    """Return the strips without a gap along a carriageway: right and left of it, outwards."""
    strips = [(o, frame.bounds_of(frame_of(o.bbox))) for o in others if _is_aligned(o, frame)]
    found: list[list[_Lane]] = [[(road, 0.0, frame.width_m)], [(road, 0.0, frame.width_m)]]
    # Sorted by their distance from the middle, so that each strip can join the one before.
    for obj, (x0, y0, x1, y1) in sorted(strips, key=lambda s: abs(s[1][1] + s[1][3])):
        overlap = min(x1, frame.length_m) - max(x0, 0.0)
        if obj.category not in STRIPS or overlap < _LEAST_LENGTH * frame.length_m:
            continue
        if abs(y1 - found[0][-1][1]) < SAME_M:
            found[0].append((obj, y0, y1))
        elif abs(y0 - found[1][-1][2]) < SAME_M:
            found[1].append((obj, y0, y1))
    return [found[0][1:], found[1][1:]]


def _common(
    roads: list[SceneObject], frames: list[Frame], rest: Sequence[SceneObject]
) -> list[list[_Lane]]:
    """Return the lanes of each piece that all pieces have alike, from right to left."""
    sides = [_lanes(road, frame, rest) for road, frame in zip(roads, frames, strict=True)]
    counts = [0, 0]
    for side in (0, 1):
        for alike in zip(*(each[side] for each in sides), strict=False):
            widths = [high - low for _, low, high in alike]
            if len({o.category for o, _, _ in alike}) > 1 or max(widths) - min(widths) > SAME_M:
                break
            counts[side] += 1
    return [
        [*right[: counts[0]][::-1], (road, 0.0, frame.width_m), *left[: counts[1]]]
        for (right, left), road, frame in zip(sides, roads, frames, strict=True)
    ]


def _is_aligned(obj: SceneObject, frame: Frame) -> bool:
    return abs(nearest_quarter(obj.bbox.yaw_rad - frame.yaw_rad)[1]) < _SAME_RAD


def _whole_frame(bodies: Sequence[SceneObject], yaw_rad: float) -> Frame:
    plane = Frame(0.0, 0.0, yaw_rad, 0.0, 0.0)
    points = [plane.local(x, y) for obj in bodies for x, y in obj.bbox.corners()[:4, :2].tolist()]
    return plane.inner(hull_of((u, v, u, v) for u, v in points))


def _without_banks(
    lanes: list[list[_Lane]],
    frames: list[Frame],
    headings: list[float],
    whole: Frame,
    widths: Widths,
    word: Callable[[SceneObject], str],
) -> Bend:
    turns = [b - a for a, b in pairwise(headings)]
    low, high = lanes[0][0][1], lanes[0][-1][2]
    # The middle line runs in the middle of all lanes, not of the carriageway.
    middle = (low + high) / 2
    ends = [0.0, *turns, 0.0]
    lengths = [
        frame.length_m
        - sum(lane_reach(-middle, frame.width_m - middle, turn) for turn in ends[i : i + 2])
        for i, frame in enumerate(frames)
    ]
    start = whole.local(*frames[0].point(0.0, middle))
    chain = [
        Lane(
            word(first[0]),
            widths.shared(first[2] - first[1]),
            tuple(each[index][0].bbox.s[2] for each in lanes),
            nearest_quarter(first[0].bbox.yaw_rad - headings[0])[0],
        )
        for index, first in enumerate(lanes[0])
    ]
    return Bend(
        start=(start[0] / whole.length_m, start[1] / whole.width_m),
        heading_rad=headings[0] - whole.yaw_rad,
        lengths_m=tuple(lengths),
        turns_rad=tuple(turns),
        lanes=tuple(chain),
        banks=(None,) * (2 * len(lengths)),
    )


def _with_banks(
    bend: Bend,
    frames: list[Frame],
    beside: list[SceneObject],
    node: MakeNode,
    widths: Widths,
) -> Bend:
    banks: list[list[tuple[SceneObject, Bounds]]] = [[] for _ in bend.banks]
    for obj in beside:
        number, frame = _nearest(obj, frames)
        bounds = frame.bounds_of(frame_of(obj.bbox))
        side = 0 if bounds[3] <= SAME_M else 1
        if side and bounds[1] < frame.width_m - SAME_M:
            raise PartitionError(f"object {obj.id} lies across a bend; valid: beside its lanes")
        banks[2 * number + side].append((obj, bounds))
    found = [
        _bank(group, frames[index // 2], index % 2, node, widths) if group else None
        for index, group in enumerate(banks)
    ]
    return Bend(
        bend.start, bend.heading_rad, bend.lengths_m, bend.turns_rad, bend.lanes, tuple(found)
    )


def _nearest(obj: SceneObject, frames: list[Frame]) -> tuple[int, Frame]:
    aligned = [(i, frame) for i, frame in enumerate(frames) if _is_aligned(obj, frame)]
    if not aligned:
        raise PartitionError(f"object {obj.id} is turned against a bend; valid: along a piece")
    x, y = obj.bbox.p[:2]
    return min(aligned, key=lambda each: math.dist((each[1].x_enu_m, each[1].y_enu_m), (x, y)))


def _bank(
    group: list[tuple[SceneObject, Bounds]],
    frame: Frame,
    side: int,
    node: MakeNode,
    widths: Widths,
) -> Bank:
    """Fit the covers on one side of a piece, from the lanes' edge to the furthest of them."""
    edge = frame.width_m if side else 0.0
    x0, y0, x1, y1 = hull_of(bounds for _, bounds in group)
    hull = (x0, min(y0, edge), x1, max(y1, edge))
    pieces = [Piece(bounds, node(obj, frame.yaw_rad), obj.id + 1) for obj, bounds in group]
    length = frame.length_m
    return Bank(x0 / length, x1 / length, hull[3] - hull[1], fit(pieces, widths, hull))
