"""Makes partition trees buildable: strips that fit, parts wide enough, lines that meet or do not.

Nothing changes where nothing has to: what was read off a scene stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

from aeroscene.partition.frames import Bounds
from aeroscene.partition.tree import (
    Bend,
    Cross,
    Node,
    Overlay,
    Part,
    Pinwheel,
    Place,
    Slice,
    children,
    part_lengths,
    with_children,
)

_SAME_M = 1e-4


def settled(node: Node, length_m: float, width_m: float, least_m: float) -> Node:
    """A tree whose parts fill a frame, each at least so wide where there is room."""
    match node:
        case Slice():
            is_x = node.axis == "x"
            parts = fitting(node.parts, length_m if is_x else width_m, least_m)
            lengths = part_lengths(parts, length_m if is_x else width_m)
            sizes = [(each, width_m) if is_x else (length_m, each) for each in lengths]
            below = zip(node.children, sizes, strict=True)
            return Slice(node.axis, parts, tuple(settled(n, *s, least_m) for n, s in below))
        case Cross():
            columns = fitting(node.columns, length_m, least_m)
            rows = fitting(node.rows, width_m, least_m)
            sizes = [
                (x, y) for y in part_lengths(rows, width_m) for x in part_lengths(columns, length_m)
            ]
            below = zip(node.cells, sizes, strict=True)
            cells = tuple(settled(n, *s, least_m) for n, s in below)
            return replace(node, columns=columns, rows=rows, cells=cells)
        case Overlay():
            items = tuple(
                replace(
                    item,
                    place=item.place and _inside(item.place, length_m, width_m),
                    tree=settled(item.tree, *_item_size(item.place, length_m, width_m), least_m),
                )
                for item in node.items
            )
            return Overlay(node.base, items)
        case Pinwheel():
            sizes = _pinwheel_sizes(node, length_m, width_m)
            trees = zip(children(node), sizes, strict=True)
            return with_children(node, tuple(settled(n, *s, least_m) for n, s in trees))
        case Bend():
            return _settled_bend(node, least_m)
        case _:
            return node


def fitting(parts: tuple[Part, ...], side_m: float, least_m: float) -> tuple[Part, ...]:
    """Parts that a side has room for."""
    fixed_m = sum(part.value for part in parts if part.is_width)
    n_free = sum(not part.is_width for part in parts)
    room_m = side_m - least_m * n_free
    if fixed_m > room_m:
        most_m = max(room_m, side_m / 2)
        parts = tuple(
            replace(part, value=part.value * min(1.0, most_m / fixed_m) * 0.999)
            if part.is_width
            else part
            for part in parts
        )
    lengths_m = part_lengths(parts, side_m)
    short = [
        not part.is_width and each < least_m for part, each in zip(parts, lengths_m, strict=True)
    ]
    if not any(short):
        return parts
    free_m = sum(m for m, part in zip(lengths_m, parts, strict=True) if not part.is_width)
    floor_m = min(least_m, free_m / n_free)
    spare_m = free_m - floor_m * n_free
    above_m = [max(0.0, each - floor_m) for each in lengths_m]
    total_m = sum(a for a, part in zip(above_m, parts, strict=True) if not part.is_width) or 1.0
    shares = [(floor_m + spare_m * each / total_m) / free_m for each in above_m]
    if spare_m <= 0:
        shares = [1.0 / n_free] * len(parts)
    return tuple(
        part if part.is_width else Part(share) for part, share in zip(parts, shares, strict=True)
    )


def _item_size(place: Place | None, length_m: float, width_m: float) -> tuple[float, float]:
    if place is None:
        return length_m, width_m
    return _inside(place, length_m, width_m).size_m


def _inside(place: Place, length_m: float, width_m: float) -> Place:
    """A place no larger than what it is on, its middle where it does not reach over."""
    x_m, y_m = min(place.size_m[0], length_m), min(place.size_m[1], width_m)
    u, v = x_m / length_m / 2, y_m / width_m / 2
    x = min(max(place.x_share, min(u, 0.5)), max(1 - u, 0.5))
    y = min(max(place.y_share, min(v, 0.5)), max(1 - v, 0.5))
    if place.yaw_rad % 1.5707963267948966 > _SAME_M:
        x, y = place.x_share, place.y_share
    return replace(place, x_share=x, y_share=y, size_m=(x_m, y_m))


def _pinwheel_sizes(node: Pinwheel, length_m: float, width_m: float) -> list[tuple[float, float]]:
    west, east, south, north = node.cuts
    middle = (east - west, north - south)
    if node.is_mirrored:
        arms = [(1 - west, south), (1 - east, 1 - south), (east, 1 - north), (west, north)]
    else:
        arms = [(east, south), (1 - east, north), (1 - west, 1 - north), (west, 1 - south)]
    return [(x * length_m, y * width_m) for x, y in (*arms, middle)]


def _settled_bend(bend: Bend, least_m: float) -> Bend:
    banks = tuple(
        bank
        and replace(
            bank,
            tree=settled(
                bank.tree,
                (bank.high_share - bank.low_share) * bend.lengths_m[index // 2],
                bank.depth_m,
                least_m,
            ),
        )
        for index, bank in enumerate(bend.banks)
    )
    return replace(bend, banks=banks)


@dataclass(slots=True, eq=False)
class _Cut:
    """A line of a storey's tree."""

    at: float
    low: float
    high: float
    is_across_x: bool
    """Whether it is at some x."""


def snapped(node: Node, length_m: float, width_m: float, nearer_m: float, least_m: float) -> Node:
    """A storey's tree in which lines that run close beside each other are one.

    Lines that would make a part narrower than `least_m` stay where they are.
    """
    whole = (0.0, 0.0, length_m, width_m)
    cuts = list(_cuts(node, whole))
    moved = {id(key): key.at for _, key in cuts}
    keys = sorted((key for _, key in cuts), key=lambda cut: (cut.is_across_x, cut.at))
    for index, second in enumerate(keys):
        for first in keys[:index]:
            is_beside = min(first.high, second.high) - max(first.low, second.low) > -nearer_m
            is_near = _SAME_M < second.at - first.at < nearer_m
            if first.is_across_x == second.is_across_x and is_near and is_beside:
                moved[id(second)] = moved[id(first)]
                break
    places = {owner: moved[id(key)] for owner, key in cuts}
    return _moved(node, whole, whole, places, least_m)


_Owner = tuple[int, bool, int]
"""Identity of a node, whether the cut is at some x, and its number there."""


def _cuts(node: Node, bounds: Bounds) -> Iterator[tuple[_Owner, _Cut]]:
    x0, y0, x1, y1 = bounds
    edges = _edges(node, bounds)
    if edges is None:
        return
    for is_x, along in enumerate(reversed(edges)):
        low, high = (y0, y1) if is_x else (x0, x1)
        for number, at in enumerate(along[1:-1]):
            yield (id(node), bool(is_x), number), _Cut(at, low, high, bool(is_x))
    for child, inner in zip(children(node), _cells(edges), strict=True):
        yield from _cuts(child, inner)


def _edges(node: Node, bounds: Bounds) -> tuple[list[float], list[float]] | None:
    """Cut places of a slice or cross along x and along y, with both ends."""
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
    """The tree in other bounds, its lines at their new places."""
    edges = _edges(node, before)
    if edges is None:
        return node
    found: list[list[float]] = []
    for is_x, along in ((True, edges[0]), (False, edges[1])):
        low, high = (after[0], after[2]) if is_x else (after[1], after[3])
        inner = [places[id(node), is_x, number] for number in range(len(along) - 2)]
        new = [low, *inner, high]
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
