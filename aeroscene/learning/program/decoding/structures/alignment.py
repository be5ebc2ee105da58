"""Alignment of storeys' lines: lines close beside each other, or beside given ones, become one.

Shares of a tree are drawn independently, so two cuts that should be one wall end up a hand apart.
Lines are visited from low to high, and each takes the place of a near one before it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

from aeroscene.partition.frames import Bounds
from aeroscene.partition.tree import Cross, Node, Part, Slice, children, part_lengths

_SAME_M = 1e-4


@dataclass(frozen=True, slots=True)
class Cut:
    """A line of a storey's tree, in the storey's frame, m."""

    at: float
    low: float
    high: float
    is_across_x: bool
    """True if the line is at one x and runs along y."""


def snapped(node: Node, length_m: float, width_m: float, nearer_m: float, least_m: float) -> Node:
    """Return a storey's tree in which lines close beside each other are one.

    Args:
        node: The tree.
        length_m: Length of the storey's frame.
        width_m: Width of the storey's frame.
        nearer_m: Lines that are nearer than this become one.
        least_m: Lines that would make a part narrower than this stay.
    """

    def nearest(cut: Cut, before: Sequence[tuple[Cut, float]]) -> float:
        for other, at in before:
            is_beside = min(other.high, cut.high) - max(other.low, cut.low) > -nearer_m
            is_near = _SAME_M < cut.at - other.at < nearer_m
            if other.is_across_x == cut.is_across_x and is_near and is_beside:
                return at
        return cut.at

    return _with_lines(node, (length_m, width_m), nearest, least_m)


def aligned(
    node: Node,
    length_m: float,
    width_m: float,
    pairs: Sequence[tuple[Cut, Cut]],
    least_m: float,
) -> Node:
    """Return a storey's tree in which some lines are moved to others.

    Args:
        node: The tree.
        length_m: Length of the storey's frame.
        width_m: Width of the storey's frame.
        pairs: A cut on a line of the tree, and the cut that it moves to.
        least_m: Lines that would make a part narrower than this stay.
    """

    def partner(cut: Cut, _: Sequence[tuple[Cut, float]]) -> float:
        for own, other in pairs:
            is_on = own.is_across_x == cut.is_across_x and abs(own.at - cut.at) < _SAME_M
            if is_on and min(own.high, cut.high) - max(own.low, cut.low) > _SAME_M:
                return other.at
        return cut.at

    return _with_lines(node, (length_m, width_m), partner, least_m)


def lines_of(node: Node, length_m: float, width_m: float) -> list[Cut]:
    """Return the lines of a storey's tree."""
    return [cut for _, cut in _cuts(node, (0.0, 0.0, length_m, width_m))]


def _with_lines(
    node: Node,
    sides_m: tuple[float, float],
    place: Callable[[Cut, Sequence[tuple[Cut, float]]], float],
    least_m: float,
) -> Node:
    """Return the tree with each line where `place` puts it, given the lines before it."""
    whole = (0.0, 0.0, *sides_m)
    cuts = list(_cuts(node, whole))
    found: list[tuple[Cut, float]] = []
    places: dict[_Owner, float] = {}
    # From low to high, so that a line can only join one that has its place already.
    for owner, cut in sorted(cuts, key=lambda each: (each[1].is_across_x, each[1].at)):
        places[owner] = place(cut, found)
        found.append((cut, places[owner]))
    return _moved(node, whole, whole, places, least_m)


_Owner = tuple[int, bool, int]
"""Identity of a node, True if the cut is at one x, and the number of the cut there."""


def _cuts(node: Node, bounds: Bounds) -> Iterator[tuple[_Owner, Cut]]:
    x0, y0, x1, y1 = bounds
    edges = _edges(node, bounds)
    if edges is None:
        return
    # Cuts across y come first, as `is_x` counts from False.
    for is_x, along in enumerate(reversed(edges)):
        low, high = (y0, y1) if is_x else (x0, x1)
        for number, at in enumerate(along[1:-1]):
            yield (id(node), bool(is_x), number), Cut(at, low, high, bool(is_x))
    for child, inner in zip(children(node), _cells(edges), strict=True):
        yield from _cuts(child, inner)


def _edges(node: Node, bounds: Bounds) -> tuple[list[float], list[float]] | None:
    """Return the cuts of a slice or cross along x and along y, with both ends."""
    x0, y0, x1, y1 = bounds
    match node:
        case Slice(axis="x"):
            return _along(node.parts, x0, x1), [y0, y1]
        case Slice():
            return [x0, x1], _along(node.parts, y0, y1)
        case Cross():
            return _along(node.columns, x0, x1), _along(node.rows, y0, y1)
        case _:
            return None


def _along(parts: tuple[Part, ...], low: float, high: float) -> list[float]:
    lengths = part_lengths(parts, high - low)
    return [low, *(low + at for at in list(accumulate(lengths))[:-1]), high]


def _cells(edges: tuple[list[float], list[float]]) -> list[Bounds]:
    return [(a, c, b, d) for c, d in pairwise(edges[1]) for a, b in pairwise(edges[0])]


def _moved(
    node: Node, before: Bounds, after: Bounds, places: dict[_Owner, float], least_m: float
) -> Node:
    """Return the tree in other bounds, with its lines at their new places."""
    edges = _edges(node, before)
    if edges is None:
        return node
    found: list[list[float]] = []
    for is_x, along in ((True, edges[0]), (False, edges[1])):
        low, high = (after[0], after[2]) if is_x else (after[1], after[3])
        inner = [places[id(node), is_x, number] for number in range(len(along) - 2)]
        new = [low, *inner, high]
        # A part would be too narrow: keep the proportions instead.
        if min(b - a for a, b in pairwise(new)) < least_m:
            size = along[-1] - along[0]
            new = [low + (at - along[0]) / size * (high - low) for at in along]
        found.append(new)
    trees = zip(children(node), _cells(edges), _cells((found[0], found[1])), strict=True)
    below = tuple(_moved(*each, places, least_m) for each in trees)
    if isinstance(node, Slice):
        parts = _parts(found[0] if node.axis == "x" else found[1])
        return Slice(node.axis, parts, below)
    assert isinstance(node, Cross)
    return replace(node, columns=_parts(found[0]), rows=_parts(found[1]), cells=below)


def _parts(edges: Sequence[float]) -> tuple[Part, ...]:
    size = edges[-1] - edges[0]
    return tuple(Part((b - a) / size) for a, b in pairwise(edges))
