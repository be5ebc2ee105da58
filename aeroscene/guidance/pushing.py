"""Parting boxes by pushing pairs: Jacobi iterations of position-based dynamics.

Each overlap is undone along the direction that costs least, shared out between the two boxes by
their masses and by the room that each has before it meets a bound. What an object carries moves
along with it. Nothing depends on the order of sums, on the GPU neither.

Source: Müller et al. 2007, "Position Based Dynamics", section 3.3; masses, bounds and the choice of
direction are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.guidance.contacts import Pairs, near_pairs, overlap_along
from aeroscene.guidance.tree import turn, turn_back
from aeroscene.tokens.boxes import Boxes

_STUCK_COST = 100.0
"""Of a metre squared of overlap that a push cannot undo, against moving a unit mass a metre."""
_CHECK_EVERY = 5
"""Iterations between two looks at whether all is done: on a GPU a look waits for the device."""
_LEAST_SLOPE = 1e-3
"""Directions nearer to an axis than this do not move along the other one."""
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
    moved = torch.zeros_like(movable.low_m)
    if len(pairs) == 0:
        return moved
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
        self._lightness = movable.lightness.reshape(-1)
        self._heading = movable.heading.reshape(-1, 2)
        self._tolerance_m = tolerance_m
        self._shape = movable.low_m.shape
        self._above = _pairs_above(pairs, movable.parent)
        self._busy = torch.zeros(len(pairs) + 1, dtype=torch.bool, device=pairs.first.device)

    def push(
        self, offset_m: Tensor, moved_m: Tensor, *, is_patient: bool
    ) -> Float[Tensor, "batch n 3"]:
        """What to add to the displacements, in the axes of the parents."""
        apart, overlap = overlap_along(self._pairs, offset_m)
        is_active = self._active(overlap.min(dim=-1).values > self._tolerance_m, is_patient)
        active = is_active.nonzero().squeeze(-1)
        # Towards both sides of each axis.
        axes = self._pairs.axes[active]
        axes = torch.cat([axes, -axes], dim=1)
        reach, apart = self._pairs.reach_m[active], apart[active]
        depth = torch.cat([reach - apart, reach + apart], dim=1) - self._tolerance_m / 2
        first, second = self._pairs.first[active], self._pairs.second[active]
        move_first, move_second, cost = self._shares(first, second, axes, depth, moved_m)
        best = cost.argmin(dim=1, keepdim=True)
        axis = axes.gather(1, best[..., None].expand(-1, -1, 3)).squeeze(1)
        push_first = turn_back(-axis * move_first.gather(1, best), self._heading[first])
        push_second = turn_back(axis * move_second.gather(1, best), self._heading[second])
        token = torch.cat([first, second])[:, None].expand(-1, 3)
        push = torch.cat([push_first, push_second])
        # Many that push the same way do not add up.
        zero = torch.zeros_like(self._low)
        forth = zero.scatter_reduce(0, token, push, "amax")
        back = zero.scatter_reduce(0, token, push, "amin")
        return (forth + back).reshape(self._shape)

    def _active(self, overlaps: Bool[Tensor, " pairs"], is_patient: bool) -> Bool[Tensor, " pairs"]:
        if not is_patient:
            return overlaps
        self._busy[:-1] |= overlaps
        waits = self._busy[self._above].any(dim=-1)
        self._busy[:-1] = overlaps | waits
        return overlaps & ~waits

    def _shares(
        self, first: Tensor, second: Tensor, axes: Tensor, depth: Tensor, moved_m: Tensor
    ) -> tuple[Tensor, Tensor, Tensor]:
        """How far each of a pair would move along each direction, and what that costs."""
        light_first, light_second = self._lightness[first, None], self._lightness[second, None]
        room_first = self._room(first, -axes, moved_m)
        room_second = self._room(second, axes, moved_m)
        share = light_first / (light_first + light_second)
        move_first = torch.minimum(depth * share, room_first)
        move_second = torch.minimum(depth - move_first, room_second)
        move_first = torch.minimum(depth - move_second, room_first)
        stuck = depth - move_first - move_second
        cost = move_first**2 / light_first + move_second**2 / light_second
        cost = cost + _STUCK_COST * stuck**2
        # Thin things overlap least in height: that is no way out where it is blocked.
        cost[:, _VERTICAL] += torch.where(stuck[:, _VERTICAL] > self._tolerance_m, torch.inf, 0.0)
        return move_first, move_second, cost

    def _room(self, token: Tensor, axes: Tensor, moved_m: Tensor) -> Float[Tensor, "pairs 10"]:
        """How far a token may go along each direction until it is at a bound."""
        moved = moved_m.reshape(-1, 3)
        direction = turn_back(axes, self._heading[token, None])
        back = (moved - self._low)[token, None]
        forth = (self._high - moved)[token, None]
        along = torch.where(direction > 0, forth, back)
        slope = direction.abs()
        far = along / slope.clamp(min=_LEAST_SLOPE)
        return torch.where(slope > _LEAST_SLOPE, far, torch.inf).min(dim=-1).values


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
