"""Settling of the remaining overlaps: cut objects, move the rest, drop those that fit nowhere."""

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
"""Distance of a place beyond which other hosts are considered as well."""
_MUCH_TOO_FAR_M = 4.0
"""Distance of a structure's place beyond which ground is cut for it instead."""
_LOYALTY_M = 1.0
"""Distance by which a place upon another host must be nearer than one upon the own host."""


def cut_overlaps(
    layout: Layout,
    is_wanted: Bool[np.ndarray, " n"],
    is_whole: Bool[np.ndarray, " n"] | None = None,
) -> bool:
    """Shorten what may be shorter until it reaches into no stranger; whether anything was cut.

    Only wanted objects are looked at, and each stays long enough for its category; those that are
    to be whole are not cut.
    """
    has_cut = False
    for _ in range(_ROUNDS):
        overlaps = layout.overlaps(TOUCH_M)
        is_cut = False
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
                _, row, axis, sign, depth_m = min(cuts)
                _cut(layout, row, axis, sign, depth_m)
                is_cut = True
        has_cut |= is_cut
        if not is_cut:
            break
    return has_cut


def resettle(layout: Layout, is_wanted: Bool[np.ndarray, " n"], obstacles: Boxes) -> None:
    """Move what still overlaps to the nearest free place, larger things first, or drop it.

    Obstacles are boxes to keep free beside all objects. A large thing without a place takes that of
    smaller ones, which are then moved.
    """
    for _ in range(_ROUNDS):
        losers = _losers(layout, is_wanted, obstacles)
        size = layout.boxes.half_m[losers].prod(axis=1)
        for row in losers[np.argsort(-size, kind="stable")].tolist():
            if layout.is_left[row] and _is_in_conflict(layout, row, obstacles):
                settle(layout, row, obstacles)
        if not len(losers):
            break


def settle(layout: Layout, row: int, obstacles: Boxes) -> None:
    """Move one object to the nearest free place: upon its host, else upon another; or drop it.

    Balconies have none but their own: within the building they would be in its walls.
    """
    if layout.is_balcony(row):
        layout.drop(row)
        return
    place = _nearest_place(layout, row, obstacles)
    if layout.objects[row].category in BLOCKS | BRIDGES and (
        place is None or place.distance_m > _MUCH_TOO_FAR_M
    ):
        nearest_m = math.inf if place is None else place.distance_m
        place = find_place(layout, row, -1, obstacles, nearest_m, may_cut=True) or place
    if place is None and layout.is_fine[row]:
        place = find_place(layout, row, int(layout.host[row]), obstacles, may_push=True)
    if place is None:
        give_up(layout, row, obstacles)
    else:
        move_to(layout, row, place)


def give_up(layout: Layout, row: int, _: Boxes) -> None:
    """Take an object out with all that belongs to it; a surface alone, without what it bears."""
    if layout.objects[row].category in GROUND | ROOMS:
        dissolve(layout, row)
    else:
        layout.drop(row)


def _nearest_place(layout: Layout, row: int, obstacles: Boxes) -> Place | None:
    """Upon an object's own host, or where that is much nearer upon another."""
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
    """Whether cuts made meanwhile have parted two boxes."""
    depth = footprint_depth(layout.boxes, np.array([i]), np.array([j]))
    return bool(depth[0] <= TOUCH_M)


def _cuts(layout: Layout, row: int, other: int) -> Iterator[tuple[float, int, int, float, float]]:
    """Cuts of an object that part it from another: share lost, object, axis, face, depth in m."""
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
    carries = (layout.moves_with & layout.is_left[:, None]).sum(axis=0)
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
        if movable and not lost & set(pair):
            lost.add(min(movable, key=lambda row: (carries[row], size[row], row)))
    return np.array(sorted(lost), dtype=int)


def _is_in_conflict(layout: Layout, row: int, obstacles: Boxes) -> bool:
    """Whether an object overlaps any stranger for which it must make room."""
    boxes = joined(layout.boxes, obstacles)
    is_stranger = ~boxes.is_kin[row]
    is_stranger[: len(layout.boxes)] &= layout.is_left & layout.obstructs(row)
    rise = np.minimum(boxes.top_m, boxes.top_m[row]) - np.maximum(boxes.base_m, boxes.base_m[row])
    others = np.flatnonzero(is_stranger & (rise > TOUCH_M))
    return bool((footprint_depth(boxes, others, np.full(len(others), row)) > TOUCH_M).any())
