"""Settling of the remaining overlaps: cut objects, move the rest, drop those that fit nowhere.

The plane problem leaves objects whose demands contradict each other. They are few, so that a place
can be searched for one after another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Int

from aeroscene.feasibility.boxes import Boxes, footprint_depth, joined
from aeroscene.feasibility.hosts import dissolve, other_hosts
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.place_search import TOUCH_M
from aeroscene.feasibility.places import Place, find_place, move_to
from aeroscene.feasibility.roles import cuttable, least_m
from aeroscene.scene.catalogue import BLOCKS, BRIDGES, GROUND, ROOMS

_GAP_M = 0.0005
_MOST_CUT = 0.6
"""Largest share of a side that a last cut may take."""
_ROUNDS = 3
_FAR_M = 2.0
"""Distance of a place from which other hosts are considered as well."""
_MUCH_TOO_FAR_M = 4.0
"""Distance of a structure's place from which ground is cut for it instead."""
_LOYALTY_M = 1.0
"""Distance by which a place on another host must be nearer than one on its own host."""


def cut_overlaps(
    layout: Layout,
    is_wanted: Bool[np.ndarray, " n"],
    is_whole: Bool[np.ndarray, " n"] | None = None,
) -> bool:
    """Shorten objects until they no longer extend into strangers.

    Each object stays long enough for its category.

    Args:
        layout: Layout; changed.
        is_wanted: Objects that are considered; both of a pair have to be.
        is_whole: Objects that must not be cut.

    Returns:
        True if anything was cut.
    """
    has_cut = False
    for _ in range(_ROUNDS):
        overlaps = layout.overlaps(TOUCH_M)
        is_cut = False
        # The deepest overlap first; a cut may part several pairs.
        for i, j in overlaps.pairs[np.argsort(-overlaps.depth_m, kind="stable")].tolist():
            if not (is_wanted[i] and is_wanted[j]) or _are_apart(layout, i, j):
                continue
            cuts = [
                cut
                for row, other in ((i, j), (j, i))
                if is_whole is None or not is_whole[row]
                for cut in _cuts(layout, row, other)
            ]
            if cuts:
                # The cut that loses the smallest share of its object.
                _, row, axis, sign, depth_m = min(cuts)
                _cut(layout, row, axis, sign, depth_m)
                is_cut = True
        has_cut |= is_cut
        if not is_cut:
            break
    return has_cut


def resettle(layout: Layout, is_wanted: Bool[np.ndarray, " n"], obstacles: Boxes) -> None:
    """Move objects that still overlap to the nearest free place, larger ones first, or drop them.

    A large object without a place takes that of smaller ones, which are then moved.

    Args:
        layout: Layout; changed.
        is_wanted: Objects that may be moved.
        obstacles: Boxes to keep free besides all objects.
    """
    for _ in range(_ROUNDS):
        losers = _losers(layout, is_wanted, obstacles)
        size = layout.boxes.half_m[losers].prod(axis=1)
        for row in losers[np.argsort(-size, kind="stable")].tolist():
            # An earlier move in this round may have solved the conflict.
            if layout.is_present[row] and _is_in_conflict(layout, row, obstacles):
                settle(layout, row, obstacles)
        if not len(losers):
            break


def settle(layout: Layout, row: int, obstacles: Boxes) -> None:
    """Move one object to the nearest free place on its host, else on another; or drop it.

    Balconies have no place but their own: within the building they would be in its walls.
    """
    if layout.is_balcony(row):
        layout.drop(row)
        return
    place = _nearest_place(layout, row, obstacles)
    if layout.objects[row].category in BLOCKS | BRIDGES and (
        place is None or place.distance_m > _MUCH_TOO_FAR_M
    ):
        # For a structure ground may be cut, if that saves it a long move.
        nearest_m = math.inf if place is None else place.distance_m
        place = find_place(layout, row, -1, obstacles, nearest_m, may_cut=True) or place
    if place is None and layout.is_fine[row]:
        place = find_place(layout, row, int(layout.host[row]), obstacles, may_push=True)
    if place is None:
        give_up(layout, row, obstacles)
    else:
        move_to(layout, row, place)


def give_up(layout: Layout, row: int, _: Boxes) -> None:
    """Drop an object with all that belongs to it; a surface alone, without the objects on it."""
    if layout.objects[row].category in GROUND | ROOMS:
        dissolve(layout, row)
    else:
        layout.drop(row)


def _nearest_place(layout: Layout, row: int, obstacles: Boxes) -> Place | None:
    """The nearest place on an object's own host, or on another if that is much nearer."""
    host = int(layout.host[row])
    place = find_place(layout, row, host, obstacles)
    if place is not None and place.distance_m <= _FAR_M:
        return place
    for other in other_hosts(layout, row):
        nearest_m = math.inf if place is None else place.distance_m - _LOYALTY_M
        found = find_place(layout, row, other, obstacles, nearest_m)
        place = place if found is None else found
    return place


def set_on_earth(layout: Layout, row: int, obstacles: Boxes) -> None:
    """Move one object to the nearest free place beside all ground, if there is one."""
    place = find_place(layout, row, -1, obstacles)
    if place is not None:
        move_to(layout, row, place)


def _are_apart(layout: Layout, i: int, j: int) -> bool:
    """Return true if cuts made in the meantime have separated two boxes."""
    depth = footprint_depth(layout.boxes, np.array([i]), np.array([j]))
    return bool(depth[0] <= TOUCH_M)


def _cuts(layout: Layout, row: int, other: int) -> Iterator[tuple[float, int, int, float, float]]:
    """Cuts that separate an object from another: share lost, object, axis, face, depth in m."""
    boxes = layout.boxes
    for axis in np.flatnonzero(cuttable(layout.objects[row])).tolist():
        unit = boxes.frame(row)[axis]
        along = float(unit @ (boxes.centre_m[other, :2] - boxes.centre_m[row, :2]))
        reach = float(np.abs(boxes.frame(other) @ unit) @ boxes.half_m[other, :2])
        side = 2 * float(boxes.half_m[row, axis])
        for sign in (1.0, -1.0):
            depth_m = side / 2 - (sign * along - reach) + _GAP_M
            share = depth_m / side
            if 0 < share <= _MOST_CUT and side - depth_m >= least_m(layout.objects[row])[axis]:
                yield share, row, axis, sign, depth_m


def _cut(layout: Layout, row: int, axis: int, sign: float, depth_m: float) -> None:
    boxes = layout.boxes
    boxes.centre_m[row, :2] -= boxes.frame(row)[axis] * (sign * depth_m / 2)
    boxes.half_m[row, axis] -= depth_m / 2


def _losers(
    layout: Layout, is_wanted: Bool[np.ndarray, " n"], obstacles: Boxes
) -> Int[np.ndarray, " k"]:
    """The one of each overlapping pair that carries less, or is smaller, if it may be moved.

    Fine objects make room for coarse ones.
    """
    n = len(layout.boxes)
    carries = (layout.moves_with & layout.is_present[:, None]).sum(axis=0)
    size = layout.boxes.half_m.prod(axis=1)
    lost: set[int] = set()
    overlaps = layout.overlaps(TOUCH_M, obstacles)
    for pair in overlaps.pairs[np.argsort(-overlaps.depth_m, kind="stable")].tolist():
        has_fine = any(row < n and not layout.is_coarse[row] for row in pair)
        movable = [
            row
            for row in pair
            if row < n and is_wanted[row] and not (has_fine and layout.is_coarse[row])
        ]
        # One loser for each pair at most: its partner then stays for this round.
        if movable and not lost & set(pair):
            lost.add(min(movable, key=lambda row: (carries[row], size[row], row)))
    return np.array(sorted(lost), dtype=int)


def _is_in_conflict(layout: Layout, row: int, obstacles: Boxes) -> bool:
    """Return true if an object overlaps any stranger for which it must make room."""
    boxes = joined(layout.boxes, obstacles)
    is_stranger = ~boxes.is_kin[row]
    is_stranger[: len(layout.boxes)] &= layout.is_present & layout.obstructs(row)
    rise = np.minimum(boxes.top_m, boxes.top_m[row]) - np.maximum(boxes.base_m, boxes.base_m[row])
    others = np.flatnonzero(is_stranger & (rise > TOUCH_M))
    return bool((footprint_depth(boxes, others, np.full(len(others), row)) > TOUCH_M).any())
