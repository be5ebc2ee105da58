"""Buildable partition trees: strips that fit their side, and parts that are wide enough.

Strips have widths of their own in metres, and no network learns that their sum is at most the side.
Trees that were read off a scene fit already and stay as they are.
"""

from __future__ import annotations

from dataclasses import replace

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
    """Return a tree whose parts fill a frame, each wide enough if there is room.

    Args:
        node: The tree.
        length_m: Length of the frame.
        width_m: Width of the frame.
        least_m: Least width of a part with a share.
    """
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
    """Return parts for which a side has room.

    Strips that are too wide together shrink alike. Then parts that are too narrow take width from
    the wider ones.

    Args:
        parts: Parts of the side, with shares or widths.
        side_m: Length of the side.
        least_m: Least width of a part with a share.
    """
    fixed_m = sum(part.value for part in parts if part.is_width)
    n_free = sum(not part.is_width for part in parts)
    room_m = side_m - least_m * n_free
    if fixed_m > room_m:
        # Strips take at most half of a side that is too short for all.
        most_m = max(room_m, side_m / 2)
        parts = tuple(
            # A thousandth less, so that rounding leaves something for the shares.
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
    """Return a place no larger than its bearer, moved so that it does not reach over."""
    x_m, y_m = min(place.size_m[0], length_m), min(place.size_m[1], width_m)
    u, v = x_m / length_m / 2, y_m / width_m / 2
    x = min(max(place.x_share, min(u, 0.5)), max(1 - u, 0.5))
    y = min(max(place.y_share, min(v, 0.5)), max(1 - v, 0.5))
    # Places at an angle keep their middle; the limits hold for places along the axes.
    if place.yaw_rad % 1.5707963267948966 > _SAME_M:
        x, y = place.x_share, place.y_share
    return replace(place, x_share=x, y_share=y, size_m=(x_m, y_m))


def _pinwheel_sizes(node: Pinwheel, length_m: float, width_m: float) -> list[tuple[float, float]]:
    west, east, south, north = node.cuts
    middle = (east - west, north - south)
    # Arms go around the middle, clockwise or counter-clockwise.
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
