"""Narrow gaps between fine objects: closed, or opened to a width that looks intended.

People put things side by side or leave room between them. A sampler leaves some objects a few
millimetres apart, which nobody would do. In curated scenes objects touch, or are at least 3 cm
apart. This stage brings pairs of objects there:

    gap g     what happens
    g < T     nothing: the objects touch
    g < W/2   one object moves by g, so that they touch
    g < W     one object moves by W - g away from the other

T is `TOUCH_M`, W is `APART_M`. So moves are usually at most 1.5 cm. Where there is no room for a
move, the other object or the other direction is tried, which may take up to 3 cm. A move counts
only if it leaves fewer narrow gaps than before and no deeper overlap, so that the stage ends, and
spoils nothing that the stages before it have reached.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import Boxes, separation
from aeroscene.feasibility.layout import Layout

TOUCH_M = 1e-3
"""Objects that are nearer touch."""
APART_M = 0.03
"""Least gap of curated objects that do not touch."""
_ROUNDING_M = 1e-4
"""Gap that the rounding of a scene document may take away."""


def settle_gaps(layout: Layout, obstacles: Boxes) -> None:
    """Close or open the narrow gaps of fine objects that have the same parent.

    Args:
        layout: Layout whose objects have their places; changed.
        obstacles: Boxes that stay free.
    """
    for first, second in _narrow_pairs(layout).tolist():
        _settle_pair(layout, obstacles, first, second)


def _narrow_pairs(layout: Layout) -> Int[np.ndarray, "k 2"]:
    """Return the pairs with a narrow gap, as rows."""
    rows = np.flatnonzero(layout.is_fine & layout.is_present)
    i, j = np.triu_indices(len(rows), 1)
    first, second = rows[i], rows[j]
    is_narrow = _are_narrow(layout.boxes, first, second)
    return np.stack([first[is_narrow], second[is_narrow]], axis=1)


def _are_narrow(
    boxes: Boxes, first: Int[np.ndarray, " k"], second: Int[np.ndarray, " k"]
) -> Bool[np.ndarray, " k"]:
    """True for pairs that stand side by side with a narrow gap between them."""
    rise_m = boxes.half_m[first, 2] + boxes.half_m[second, 2]
    rise_m -= np.abs(boxes.centre_m[first, 2] - boxes.centre_m[second, 2])
    is_beside = (boxes.parent[first] == boxes.parent[second]) & (rise_m > TOUCH_M)
    reach_m = np.hypot(boxes.half_m[:, 0], boxes.half_m[:, 1])
    apart_m = np.linalg.norm(boxes.centre_m[first, :2] - boxes.centre_m[second, :2], axis=1)
    is_beside &= apart_m < reach_m[first] + reach_m[second] + APART_M
    found = np.flatnonzero(is_beside)
    gap_m, _ = separation(boxes, first[found], second[found])
    is_narrow = np.zeros(len(first), dtype=bool)
    is_narrow[found] = (gap_m > TOUCH_M) & (gap_m < APART_M - _ROUNDING_M)
    return is_narrow


def _settle_pair(layout: Layout, obstacles: Boxes, first: int, second: int) -> None:
    boxes = layout.boxes
    gaps_m, normals = separation(boxes, np.array([first]), np.array([second]))
    gap_m, normal = float(gaps_m[0]), normals[0]
    if not TOUCH_M < gap_m < APART_M - _ROUNDING_M:
        return  # An earlier pair's move has settled it.
    close_m, open_m = -gap_m, APART_M - gap_m
    ways_m = (close_m, open_m) if gap_m < APART_M / 2 else (open_m, close_m)
    # The smaller one first: a chair moves, not the table.
    area = np.prod(boxes.half_m[[first, second], :2], axis=1)
    movers = (
        ((second, 1.0), (first, -1.0)) if area[1] <= area[0] else ((first, -1.0), (second, 1.0))
    )
    for way_m, (row, sign) in product(ways_m, movers):
        if _try_shift(layout, obstacles, row, sign * way_m * normal):
            return


def _try_shift(
    layout: Layout, obstacles: Boxes, row: int, offset_m: Float[np.ndarray, " 2"]
) -> bool:
    """Shift an object with all that it carries; take it back unless things get better."""
    moved = layout.carried(row)
    before = _state(layout, obstacles, moved)
    layout.shift(row, np.array([*offset_m, 0.0]))
    n_narrow, depth_m = _state(layout, obstacles, moved)
    if n_narrow < before[0] and depth_m <= before[1] + _ROUNDING_M:
        return True
    layout.shift(row, -np.array([*offset_m, 0.0]))
    return False


def _state(layout: Layout, obstacles: Boxes, moved: Int[np.ndarray, " k"]) -> tuple[int, float]:
    """Return how many narrow gaps some rows have, and how deep they overlap with others in all."""
    others = np.flatnonzero(layout.is_present)
    pairs = np.array(np.meshgrid(moved, others)).reshape(2, -1)
    pairs = pairs[:, ~np.isin(pairs[1], moved)]
    is_fine = layout.is_fine[pairs[0]] & layout.is_fine[pairs[1]]
    n_narrow = int(_are_narrow(layout.boxes, *pairs[:, is_fine]).sum())
    overlaps = layout.overlaps(0.0, obstacles)
    is_own = np.isin(overlaps.pairs, moved).any(axis=1)
    return n_narrow, float(overlaps.depth_m[is_own].sum())
