"""Our guidance: overlapping boxes of the predicted clean layout are pushed apart, late.

Where the paper follows the gradient of an IoU on x_t, this moves objects by positions (Müller et
al. 2007, "Position Based Dynamics"; see `pushing`). Penetration depth keeps its slope where an IoU
is flat (one box in another); sizes and headings are left alone, so nothing shrinks out of a
collision; and all pushes are horizontal, so that roads do not stack, but for the storeys of a
building, which lie at heights of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.diffusion.loss import channel_weight
from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import require_within
from aeroscene.learning.guidance.containment import reach_of_middle
from aeroscene.learning.guidance.hopping import hop
from aeroscene.learning.guidance.pushing import Movable, separate
from aeroscene.learning.guidance.tree import lineage, parent_heading
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes, footprints_of

Decode = Callable[[Tensor, TokenBatch], Boxes]
"""Turns channels into boxes."""
Bounds = Callable[[TokenBatch], tuple[Tensor, Tensor]]
"""Least and greatest value that each channel of each token had in training."""

_HEIGHT = 2
"""Channel of an object's height."""


@dataclass(frozen=True, kw_only=True)
class SeparationCfg:
    """Settings of the separation of overlaps."""

    late_share: float = 0.6
    """Share of the sampling steps, the last ones, at which the guidance acts."""
    inner_steps: int = 10
    """Iterations at each of them."""
    last_inner_steps: int = 40
    """At most, at the last one and after each of its hops; fewer where nothing overlaps."""
    n_hops: int = 4
    """Times that, at the last step, what is still stuck hops to a free place."""
    clip_m: float = 5.0
    """Most that one step moves an object along each axis of its parent; overlaps that need much
    more are left."""
    tolerance_m: float = 0.004
    """Overlaps up to this are left."""
    margin_m: float = 1.0
    """Boxes nearer than this are watched: what moves may meet them."""
    coarse_mass: float = 4.0
    """Mass of a coarse object relative to a fine one of the same footprint."""
    patience: float = 0.3
    """Share of the iterations in which what is in two overlapping objects waits for these."""

    def __post_init__(self) -> None:
        require_within("separation", self, (0, 1), "late_share", "tolerance_m", "patience")
        require_within("separation", self, (0, 1000), "inner_steps")
        require_within("separation", self, (0, 10_000), "last_inner_steps")
        require_within("separation", self, (0, 100), "n_hops", "clip_m", "margin_m")
        require_within("separation", self, (0.01, 1000), "coarse_mass")


class SeparationGuidance:
    """Pushes overlapping objects apart in the predicted clean layout."""

    def __init__(self, decode: Decode, bounds: Bounds, cfg: SeparationCfg | None = None) -> None:
        """Set up, with the bounds of the channels in training: no object is pushed over those.

        Of the channels that are decoded the first three are the place.
        """
        self._decode = decode
        self._bounds = bounds
        self.cfg = cfg or SeparationCfg()

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """The layout with its objects moved apart."""
        cfg = self.cfg
        if at.share_left > cfg.late_share and not at.is_last:
            return x0
        boxes = self._decode(x0, batch)
        unit_m = self._units_m(boxes, batch)
        movable = self._movable(x0, unit_m, boxes, batch, at.fixed)
        if at.is_last:
            moved_m = self._settle(boxes, movable, batch)
        else:
            moved_m = self._push(boxes, movable, cfg.inner_steps)
        place = x0[..., :3] + moved_m / unit_m.clamp(min=1e-6)
        return torch.cat([place, x0[..., 3:]], dim=-1)

    def _push(self, boxes: Boxes, movable: Movable, n_steps: int) -> Float[Tensor, "batch n 3"]:
        cfg = self.cfg
        return separate(
            boxes,
            movable,
            tolerance_m=cfg.tolerance_m,
            margin_m=cfg.margin_m,
            n_steps=n_steps,
            n_patient_steps=round(cfg.patience * n_steps),
        )

    def _settle(
        self, boxes: Boxes, movable: Movable, batch: TokenBatch
    ) -> Float[Tensor, "batch n 3"]:
        """Displacements that leave as few overlaps as can be."""
        cfg = self.cfg
        may_hop = torch.arange(boxes.mask.shape[1], device=boxes.mask.device)
        may_hop = (may_hop >= batch.n_coarse_slots) & boxes.mask
        moved = self._push(boxes, movable, cfg.last_inner_steps)
        for _ in range(cfg.n_hops):
            now, left = movable.move(boxes, moved), movable.after(moved)
            hopped = hop(now, left, may_hop, tolerance_m=cfg.tolerance_m)
            now, left = left.move(now, hopped), left.after(hopped)
            moved = moved + hopped + self._push(now, left, cfg.last_inner_steps)
        return moved

    def on_mean(self, mean: Tensor, x_t: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Nothing: the layout was moved where it was clean."""
        return mean

    @staticmethod
    def _units_m(boxes: Boxes, batch: TokenBatch) -> Float[Tensor, "batch n 3"]:
        """Metres by which one unit of each channel of the place moves a box, 0 where none does."""
        is_free = channel_weight(batch)[..., :3] > 0
        # Storeys only: what stands on a slope has a free height, too, and must not leave it.
        slot = torch.arange(is_free.shape[1], device=is_free.device)
        is_storey = (slot < batch.n_coarse_slots) & (batch.depth > 1)
        is_free[..., _HEIGHT] &= is_storey
        return torch.cat([boxes.play_m, boxes.rise_m[..., None]], dim=-1) * is_free

    def _movable(
        self, x0: Tensor, unit_m: Tensor, boxes: Boxes, batch: TokenBatch, fixed: Tensor | None
    ) -> Movable:
        low, high = (bound[..., :3] for bound in self._bounds(batch))
        place, clip = x0[..., :3], self.cfg.clip_m
        unit_m = unit_m * batch.mask[..., None]
        if fixed is not None:
            unit_m = unit_m * ~fixed[..., None]
        above = lineage(batch)
        least = ((low - place).clamp(max=0) * unit_m).clamp(min=-clip)
        most = ((high - place).clamp(min=0) * unit_m).clamp(max=clip)
        outward, inward = self._room(boxes, batch)
        return Movable(
            heading=parent_heading(boxes.heading, batch),
            low_m=torch.maximum(least, inward),
            high_m=torch.minimum(most, outward),
            lightness=1 / self._mass(boxes, batch, above),
            lineage=above,
            parent=batch.parent,
        )

    @staticmethod
    def _room(boxes: Boxes, batch: TokenBatch) -> tuple[Tensor, Tensor]:
        """Displacements up and down the axes that keep a middle over its parent."""
        outlines = footprints_of(boxes, batch)
        none = torch.zeros_like(batch.mask)
        limit = reach_of_middle(outlines, boxes, batch, none)
        up = (limit - outlines.middle_m).clamp_min(0.0)
        down = (-limit - outlines.middle_m).clamp_max(0.0)
        free = torch.full_like(up[..., :1], torch.inf)
        return torch.cat([up, free], dim=-1), torch.cat([down, -free], dim=-1)

    def _mass(
        self, boxes: Boxes, batch: TokenBatch, above: Bool[Tensor, "batch n n"]
    ) -> Float[Tensor, "batch n"]:
        """Mass of a token with all that it carries."""
        side = boxes.size_m[..., :2].prod(-1).sqrt()
        slot = torch.arange(side.shape[1], device=side.device)
        factor = torch.where(slot < batch.n_coarse_slots, self.cfg.coarse_mass, 1.0)
        own = (side + _LEAST_MASS) * factor * batch.mask
        return torch.einsum("bij,bi->bj", above.to(own), own).clamp(min=_LEAST_MASS)


_LEAST_MASS = 0.3
"""Mass of the smallest object, in units of one that is a metre long and wide."""
