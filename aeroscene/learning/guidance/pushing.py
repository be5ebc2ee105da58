"""Parting boxes by pushing pairs: Jacobi iterations of position-based dynamics.

Each overlap is undone along the direction that costs least, shared out between the two boxes by
their masses and by the room that each has before it meets a bound. What an object carries moves
along with it. Nothing depends on the order of sums, on the GPU neither.

Source: Müller et al. 2007, "Position Based Dynamics", section 3.3; masses, bounds and the choice of
direction are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.guidance.contacts import Pairs, near_pairs, overlap_along
from aeroscene.learning.guidance.push_loop import Freedom, Rules, Touching, iterate
from aeroscene.learning.guidance.tree import turn, turn_back
from aeroscene.learning.tokens.boxes import Boxes

_STUCK_COST = 100.0
"""Of a metre squared of overlap that a push cannot undo, against moving a unit mass a metre."""
_CHECK_EVERY = 5
"""Iterations between two looks at whether all is done: on a GPU a look waits for the device."""
_LEAST_SLOPE = 1e-3
"""Directions nearer to an axis than this do not move along the other one."""
_ENDLESS_M = 1e6
_LEAST_HELP = 0.7
"""Share of an overlap that a push must undo, or the pair is left alone."""
_VERTICAL = (4, 9)
"""Places of the vertical among the ten directions."""


@dataclass(frozen=True, kw_only=True)
class Movable:
    """What may move whither, each token in the axes of its parent."""

    heading: Float[Tensor, "batch n 2"]
    """Of the parent."""
    low_m: Float[Tensor, "batch n 3"]
    """Least displacement."""
    high_m: Float[Tensor, "batch n 3"]
    lightness: Float[Tensor, "batch n"]
    """One over the mass."""
    lineage: Bool[Tensor, "batch n n"]
    """Entry [i, j]: whether j is i or above it."""
    parent: Int[Tensor, "batch n"]

    def after(self, moved_m: Float[Tensor, "batch n 3"]) -> Movable:
        """What may still move whither when tokens have moved."""
        return replace(self, low_m=self.low_m - moved_m, high_m=self.high_m - moved_m)

    def move(self, boxes: Boxes, moved_m: Float[Tensor, "batch n 3"]) -> Boxes:
        """Boxes displaced in the axes of their parents, with all that they carry."""
        in_world = self.lineage.to(moved_m) @ turn(moved_m, self.heading)
        return replace(boxes, center_enu_m=boxes.center_enu_m + in_world)


def separate(
    boxes: Boxes,
    movable: Movable,
    *,
    tolerance_m: float,
    margin_m: float,
    n_steps: int,
    n_patient_steps: int = 0,
) -> Float[Tensor, "batch n 3"]:
    """Displacements that undo overlaps, in the axes of the parents, m.

    Args:
        boxes: The boxes.
        movable: What may move whither.
        tolerance_m: Overlaps up to this are left.
        margin_m: Boxes nearer than this are watched.
        n_steps: Iterations at most; fewer where all is done.
        n_patient_steps: In the first of them, two overlapping objects part before what is in
            them does.
    """
    family = movable.lineage | movable.lineage.transpose(1, 2)
    pairs = near_pairs(boxes, family, margin_m)
    if len(pairs) == 0:
        return torch.zeros_like(movable.low_m)
    part = separate_in_loop if movable.low_m.device.type == "cpu" else separate_at_once
    return part(pairs, movable, tolerance_m, n_steps, n_patient_steps)


def separate_in_loop(
    pairs: Pairs, movable: Movable, tolerance_m: float, n_steps: int, n_patient_steps: int
) -> Float[Tensor, "batch n 3"]:
    """As `separate`, pair by pair on the processor."""
    touching = Touching(
        token=torch.stack([pairs.first, pairs.second], dim=-1).numpy(),
        axes=pairs.axes.double().numpy(),
        reach_m=pairs.reach_m.double().numpy(),
        offset_m=pairs.offset_m.double().numpy(),
        above=_pairs_above(pairs, movable.parent).numpy(),
    )
    rules = Rules(tolerance_m, _STUCK_COST, _LEAST_SLOPE, _ENDLESS_M, _LEAST_HELP, _CHECK_EVERY)
    moved = iterate(touching, _freedom(movable), rules, n_steps, n_patient_steps)
    return torch.from_numpy(moved).to(movable.low_m).reshape(movable.low_m.shape)


def _freedom(movable: Movable) -> Freedom:
    """What may move whither, of all scenes in one list."""
    n_scenes, n = movable.parent.shape
    start = n * torch.arange(n_scenes)[:, None]
    level = movable.lineage.sum(-1)
    parent = torch.where(level > 1, movable.parent + start, -1)
    rows = (movable.heading, movable.low_m, movable.high_m, movable.lightness[..., None])
    heading, low, high, lightness = (row.flatten(0, 1).double().numpy() for row in rows)
    order = level.flatten().argsort(stable=True).numpy()
    return Freedom(order, parent.flatten().numpy(), heading, low, high, lightness[:, 0].copy())


def separate_at_once(
    pairs: Pairs, movable: Movable, tolerance_m: float, n_steps: int, n_patient_steps: int
) -> Float[Tensor, "batch n 3"]:
    """As `separate`, all pairs at once: for a GPU."""
    moved = torch.zeros_like(movable.low_m)
    above = movable.lineage.to(moved)
    solver = _Solver(pairs, movable, tolerance_m)
    for step in range(n_steps):
        in_world = (above @ turn(moved, movable.heading)).reshape(-1, 3)
        offset = pairs.offset_m + in_world[pairs.second] - in_world[pairs.first]
        push = solver.push(offset, moved, is_patient=step < n_patient_steps)
        if step % _CHECK_EVERY == 0 and not bool(push.any()):
            break
        moved = (moved + push).clamp(movable.low_m, movable.high_m)
    return moved


class _Solver:
    """One iteration over all pairs."""

    def __init__(self, pairs: Pairs, movable: Movable, tolerance_m: float) -> None:
        self._pairs = pairs
        self._low = movable.low_m.reshape(-1, 3)
        self._high = movable.high_m.reshape(-1, 3)
        self._tolerance_m = tolerance_m
        self._token = torch.stack([pairs.first, pairs.second])
        self._lightness = movable.lightness.reshape(-1)[self._token, None]
        heading = movable.heading.reshape(-1, 2)[self._token]
        # Away from the partner along each axis, in the axes of the parent.
        away = torch.stack([-pairs.axes, pairs.axes])
        self._away = turn_back(away, heading[:, :, None])
        slope = self._away.abs()
        is_across = slope < _LEAST_SLOPE
        self._steepness = torch.where(is_across, 0.0, 1 / slope.clamp(min=_LEAST_SLOPE))
        self._endless = torch.where(is_across, _ENDLESS_M, 0.0)
        self._above = _pairs_above(pairs, movable.parent)
        self._busy = torch.zeros(len(pairs) + 1, dtype=torch.bool, device=pairs.first.device)

    def push(
        self, offset_m: Tensor, moved_m: Tensor, *, is_patient: bool
    ) -> Float[Tensor, "batch n 3"]:
        """What to add to the displacements, in the axes of the parents."""
        apart, overlap = overlap_along(self._pairs, offset_m)
        is_active = self._active(overlap.min(dim=-1).values > self._tolerance_m, is_patient)
        active = is_active.nonzero().squeeze(-1)
        reach, apart = self._pairs.reach_m[active], apart[active]
        # Along each axis, and against it.
        depth = torch.cat([reach - apart, reach + apart], dim=1) - self._tolerance_m / 2
        move, cost = self._shares(active, depth, self._room(active, moved_m))
        best = cost.argmin(dim=1)
        row = torch.arange(len(best), device=best.device)
        n_axes = reach.shape[1]
        away = self._away[:, active][:, row, best % n_axes]
        sign = 1.0 - 2.0 * (best >= n_axes)
        move = move[:, row, best]
        # What no way helps stays: a room would be pushed out from under a slab that is too low.
        move = move * (move.sum(dim=0) >= _LEAST_HELP * depth[row, best])
        push = (away * (sign * move)[..., None]).flatten(0, 1)
        token = self._token[:, active].reshape(-1, 1).expand(-1, 3)
        # Many that push the same way do not add up.
        zero = torch.zeros_like(self._low)
        forth = zero.scatter_reduce(0, token, push, "amax")
        back = zero.scatter_reduce(0, token, push, "amin")
        return (forth + back).reshape(moved_m.shape)

    def _active(self, overlaps: Bool[Tensor, " pairs"], is_patient: bool) -> Bool[Tensor, " pairs"]:
        if not is_patient:
            return overlaps
        self._busy[:-1] |= overlaps
        waits = self._busy[self._above].any(dim=-1)
        self._busy[:-1] = overlaps | waits
        return overlaps & ~waits

    def _shares(
        self, active: Tensor, depth: Float[Tensor, "pairs 10"], room: Float[Tensor, "2 pairs 10"]
    ) -> tuple[Float[Tensor, "2 pairs 10"], Float[Tensor, "pairs 10"]]:
        """How far each of a pair would move along each direction, and what that costs."""
        light_first, light_second = self._lightness[:, active]
        share = light_first / (light_first + light_second)
        move_first = torch.minimum(depth * share, room[0])
        move_second = torch.minimum(depth - move_first, room[1])
        move_first = torch.minimum(depth - move_second, room[0])
        stuck = depth - move_first - move_second
        cost = move_first**2 / light_first + move_second**2 / light_second
        cost = cost + _STUCK_COST * stuck**2
        # Thin things overlap least in height: that is no way out where it is blocked.
        cost[:, _VERTICAL] += torch.where(stuck[:, _VERTICAL] > self._tolerance_m, torch.inf, 0.0)
        return torch.stack([move_first, move_second]), cost

    def _room(self, active: Tensor, moved_m: Tensor) -> Float[Tensor, "2 pairs 10"]:
        """How far the two of a pair may go along each direction until they are at a bound."""
        moved, token = moved_m.reshape(-1, 3), self._token[:, active]
        back = (moved - self._low)[token][:, :, None]
        forth = (self._high - moved)[token][:, :, None]
        points_up = self._away[:, active] > 0
        steepness, endless = self._steepness[:, active], self._endless[:, active]
        along = torch.where(points_up, forth, back) * steepness + endless
        against = torch.where(points_up, back, forth) * steepness + endless
        return torch.cat([along.amin(dim=-1), against.amin(dim=-1)], dim=-1)


def _pairs_above(pairs: Pairs, parent: Int[Tensor, "batch n"]) -> Int[Tensor, "pairs 2"]:
    """Places among the pairs of either one's parent with the other; their count where none is."""
    n_scenes, n = parent.shape
    scene = torch.arange(n_scenes, device=parent.device)[:, None] * n
    above = (parent + scene).reshape(-1)
    known = pairs.first * parent.numel() + pairs.second

    def find(a: Tensor, b: Tensor) -> Tensor:
        key = torch.minimum(a, b) * parent.numel() + torch.maximum(a, b)
        place = torch.searchsorted(known, key).clamp(max=len(known) - 1)
        return torch.where(known[place] == key, place, len(known))

    return torch.stack(
        [find(above[pairs.first], pairs.second), find(pairs.first, above[pairs.second])], dim=-1
    )
