"""Parting boxes by pushing pairs: Jacobi iterations of position-based dynamics.

Each overlap is undone along the direction that costs least, shared out between the two boxes by
their masses and by the room that each has before it meets a bound. What an object carries moves
along with it. Pairs are found on the device of the boxes; `push_loop` iterates on the processor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.guidance.contacts import Pairs, near_pairs
from aeroscene.learning.guidance.push_loop import Freedom, Touching, iterate
from aeroscene.learning.guidance.tree import turn
from aeroscene.learning.tokens.boxes import Boxes


@dataclass(frozen=True, kw_only=True)
class Movable:
    """Freedom of motion of each token in the axes of its parent."""

    heading: Float[Tensor, "batch n 2"]
    """Heading of the parent."""
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
    """Displacements that undo overlaps beyond a tolerance, in the axes of the parents, m.

    Boxes nearer than the margin are watched. In the first `n_patient_steps` of at most `n_steps`
    iterations two overlapping objects part before what is in them does.
    """
    family = movable.lineage | movable.lineage.transpose(1, 2)
    pairs = near_pairs(boxes, family, margin_m)
    if len(pairs) == 0:
        return torch.zeros_like(movable.low_m)
    touching = Touching(
        token=torch.stack([pairs.first, pairs.second], dim=-1).cpu().numpy(),
        axes=pairs.axes.double().cpu().numpy(),
        reach_m=pairs.reach_m.double().cpu().numpy(),
        offset_m=pairs.offset_m.double().cpu().numpy(),
        above=_pairs_above(pairs, movable.parent).cpu().numpy(),
    )
    moved = iterate(touching, _freedom(movable), tolerance_m, n_steps, n_patient_steps)
    return torch.from_numpy(moved).to(movable.low_m).reshape(movable.low_m.shape)


def _freedom(movable: Movable) -> Freedom:
    """What may move whither, of all scenes in one list."""
    n_scenes, n = movable.parent.shape
    start = n * torch.arange(n_scenes)[:, None]
    level = movable.lineage.sum(-1).cpu()
    parent = torch.where(level > 1, movable.parent.cpu() + start, -1)
    rows = (movable.heading, movable.low_m, movable.high_m, movable.lightness[..., None])
    heading, low, high, lightness = (row.flatten(0, 1).double().cpu().numpy() for row in rows)
    order = level.flatten().argsort(stable=True).numpy()
    return Freedom(order, parent.flatten().numpy(), heading, low, high, lightness[:, 0].copy())


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
