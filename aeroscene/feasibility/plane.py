"""The least changes in the plane that separate all boxes, as a sequence of least-squares problems.

Two strangers are apart if they are so along one axis of either, and "one of four" is not a convex
condition. Therefore the axis of each pair is chosen anew between problems, at the places reached so
far, while changes always count from the original places.

Weights are chosen anew too: divided by the change so far, squares add up to a sum of distances. As
with an L1 norm, few objects then move far, and most do not move at all.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import Boxes, joined, reach_along, separation
from aeroscene.feasibility.changes import Changes
from aeroscene.feasibility.heights import post
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.least_change import least_change
from aeroscene.feasibility.place_search import TOUCH_M
from aeroscene.feasibility.roles import margin_m
from aeroscene.scene.catalogue import POSTS

_GAP_M = 0.002
"""Gap that is left between separated boxes."""
_RIM_M = 0.003
"""Overhang over the host's border up to which an object stays as it is."""
_NEAR_M = 0.4
"""Distance from which strangers cannot meet within one problem."""
_BORDER_M = 8.0
"""Distance from the flight volume's sides from which an object cannot leave it."""
_ROUNDS = 12
_SWEEPS = 160
_LEAST_CHANGE_M = 0.2
"""Change up to which changes count by their squares; it keeps weights finite."""

_Demands = tuple[Float[np.ndarray, "k v"], Float[np.ndarray, " k"]]
"""Rows of `A x >= b`."""


class PlaneProblem:
    """Separates the boxes of some objects of a layout from each other and from all others."""

    def __init__(
        self,
        layout: Layout,
        is_movable: Bool[np.ndarray, " n"],
        obstacles: Boxes | None = None,
        among: Bool[np.ndarray, " n"] | None = None,
    ) -> None:
        """Let movable objects, with all they carry, make way for each other and for obstacles.

        Args:
            layout: Layout; changed by `solve`.
            is_movable: Objects that may move or be cut.
            obstacles: Boxes that never move.
            among: Objects that exist for this problem; all remaining ones by default.
        """
        self._layout = layout
        self._began = joined(layout.boxes, obstacles)
        self._movable = np.flatnonzero(is_movable & layout.is_present)
        self._changes = Changes(layout, self._began, self._movable)
        self._candidates = self._strangers(layout.is_present if among is None else among)
        self._have_met = np.zeros(len(self._candidates), dtype=bool)
        self._x = np.zeros(self._changes.width)

    def _strangers(self, among: Bool[np.ndarray, " n"]) -> Int[np.ndarray, "k 2"]:
        """Pairs that share a height, may not overlap, and of which at least one moves."""
        began, layout = self._began, self._layout
        n, total = len(layout.boxes), len(began)
        is_there = np.ones(total, dtype=bool)
        is_there[:n] = layout.is_present & among
        moves = self._changes.carries.sum(axis=1) > 0
        first, second = np.triu_indices(total, 1)
        rise = np.minimum(began.top_m[first], began.top_m[second])
        rise -= np.maximum(began.base_m[first], began.base_m[second])
        keep = (rise > TOUCH_M) & is_there[first] & is_there[second]
        keep &= (moves[first] | moves[second]) & ~began.is_kin[first, second]
        host = np.full(total, -1)
        host[:n] = layout.host
        # An object and its host overlap in plan by nature.
        keep &= (host[first] != second) & (host[second] != first)
        return np.stack([first[keep], second[keep]], axis=1)

    def solve(self) -> None:
        """Change the layout's boxes by the least that separates them."""
        if not len(self._movable):
            return
        # Demands on borders and cuts do not change from problem to problem.
        fixed = [self._within_hosts(), self._within_extent(), self._changes.cut_limits()]
        for _ in range(_ROUNDS):
            now = self._changes.applied(self._x)
            apart, worst_m = self._apart(now)
            if worst_m < TOUCH_M and self._is_met(fixed):
                break
            demands = [*fixed, apart]
            self._x = least_change(
                np.concatenate([rows for rows, _ in demands]),
                np.concatenate([bounds for _, bounds in demands]),
                self._weights(),
                _SWEEPS,
            )
        now, boxes = self._changes.applied(self._x), self._layout.boxes
        boxes.centre_m[:], boxes.half_m[:] = now.centre_m[: len(boxes)], now.half_m[: len(boxes)]

    def _weights(self) -> Float[np.ndarray, " v"]:
        # Divided by the change so far: see above.
        sizes = self._changes.sizes(self._x)
        return self._changes.costs / np.maximum(sizes, _LEAST_CHANGE_M)

    def _is_met(self, demands: list[_Demands]) -> bool:
        return all((rows @ self._x >= bounds - TOUCH_M).all() for rows, bounds in demands)

    def _apart(self, now: Boxes) -> tuple[_Demands, float]:
        """Demand that each pair that is or was near stays apart along its best axis.

        Returns:
            The demands, and the depth of the deepest overlap.
        """
        i, j = self._candidates.T
        reach = np.hypot(now.half_m[:, 0], now.half_m[:, 1])
        middles_m = np.hypot(*(now.centre_m[j, :2] - now.centre_m[i, :2]).T)
        near = np.flatnonzero(self._have_met | (middles_m < reach[i] + reach[j] + _NEAR_M))
        gap_m, normal = separation(now, i[near], j[near])
        keep = self._have_met[near] | (gap_m < _NEAR_M)
        near, normal = near[keep], normal[keep]
        # Once a pair has met, it stays in all later problems, or it could drift together again.
        self._have_met[near] = True
        i, j = i[near], j[near]
        began, _ = separation(self._began, i, j)
        # A pair that overlaps gets a gap; one that merely touches keeps its place.
        wanted = np.where(began < -TOUCH_M, _GAP_M, np.minimum(began, 0.0))
        rows = self._changes.shifts(j, normal) - self._changes.shifts(i, normal)
        self._changes.add_cuts(rows, i, normal)
        self._changes.add_cuts(rows, j, -normal)
        worst_m = float((-gap_m).max(initial=0.0))
        return (rows, wanted - self._gap(i, j, normal)), worst_m

    def _gap(
        self, i: Int[np.ndarray, " k"], j: Int[np.ndarray, " k"], normal: Float[np.ndarray, "k 2"]
    ) -> Float[np.ndarray, " k"]:
        """Gaps along normals in the original places, m."""
        boxes = self._began
        along = np.einsum("ki,ki->k", boxes.centre_m[j, :2] - boxes.centre_m[i, :2], normal)
        return along - reach_along(boxes, i, normal) - reach_along(boxes, j, normal)

    def _within_hosts(self) -> _Demands:
        """Demand that each object stays on or within its host."""
        layout, boxes = self._layout, self._began
        rows, margins = self._kept_within()
        hosts = layout.host[rows]
        feet, radius = self._feet(rows)
        axes = boxes.axes_of(hosts)
        found: list[_Demands] = []
        for face in range(4):
            axis = face % 2
            normal = axes[:, axis] * (1.0 if face < 2 else -1.0)
            reach = np.where(radius < 0, reach_along(boxes, rows, normal), radius)
            offset = np.einsum("ki,ki->k", boxes.centre_m[hosts, :2] - feet, normal)
            room = boxes.half_m[hosts, axis] + offset - reach
            # An object that is too long for its host lies in its middle.
            spare = boxes.half_m[hosts, axis] - reach
            is_whole = ~self._changes.is_cuttable[rows]
            wanted = np.where(is_whole, np.minimum(margins, spare), margins)
            # An object that already extends beyond its host is not pushed in by this demand alone.
            wanted = np.where(room >= wanted - _RIM_M, np.minimum(wanted, room), wanted)
            demand = self._changes.shifts(hosts, normal) - self._changes.shifts(rows, normal)
            self._changes.add_cuts(demand, rows, normal)
            self._changes.add_cuts(demand, hosts, normal, -1.0)
            found.append((demand, wanted - room))
        return _stacked(found)

    def _kept_within(self) -> tuple[Int[np.ndarray, " k"], Float[np.ndarray, " k"]]:
        """Objects that have a border to stay within, and their distances from it."""
        layout = self._layout
        rows, margins = [], []
        for row in self._movable.tolist():
            parent = layout.parent_of(row)
            if parent is None or layout.host[row] != layout.boxes.parent[row]:
                kept = 0.0
            elif len(layout.tiles(int(layout.host[row]))) > 1:
                # Walls hold it, whichever of the tiles it is on.
                continue
            else:
                kept = margin_m(layout.objects[row], parent)
            if layout.host[row] >= 0 and kept is not None and not layout.is_balcony(row):
                rows.append(row)
                margins.append(kept)
        return np.array(rows, dtype=int), np.array(margins)

    def _feet(
        self, rows: Int[np.ndarray, " k"]
    ) -> tuple[Float[np.ndarray, "k 2"], Float[np.ndarray, " k"]]:
        """Middles of parts that must be on a host; radii of single posts, -1 for whole boxes."""
        feet, radius = self._began.centre_m[rows, :2].copy(), np.full(len(rows), -1.0)
        for k, row in enumerate(rows.tolist()):
            if self._layout.objects[row].category in POSTS:
                offset, radius[k] = post(self._layout, row)
                feet[k] += offset
        return feet, radius

    def _within_extent(self) -> _Demands:
        """Demand that objects anywhere near the sides of the flight volume stay within it."""
        boxes, (low, high) = self._began, self._layout.extent_m
        found: list[_Demands] = []
        for axis in range(2):
            for sign, border in ((1.0, high[axis]), (-1.0, low[axis])):
                rows = self._movable
                normal = np.zeros((len(rows), 2))
                normal[:, axis] = sign
                room = sign * (border - boxes.centre_m[rows, axis])
                room -= reach_along(boxes, rows, normal)
                near = room < _BORDER_M
                # Rows far from this side cannot reach it, and would only slow the problem down.
                rows, normal, room = rows[near], normal[near], room[near]
                demand = -self._changes.shifts(rows, normal)
                self._changes.add_cuts(demand, rows, normal)
                found.append((demand, -room))
        return _stacked(found)


def _stacked(demands: list[_Demands]) -> _Demands:
    return (
        np.concatenate([rows for rows, _ in demands]),
        np.concatenate([bounds for _, bounds in demands]),
    )
