"""The paper's guidance: the gradients of three objectives move the denoising mean.

    symbol               name                                                       unit
    L_col, L_c2f, L_sem  the objectives                                             -
    g_k                  gradient of one of them by place and heading of an object  1/m
    eta_0                step                                                       m

Deviations from the paper's equations 21 to 23, with their reasons:

- L_guide is evaluated on the predicted clean layout, because boxes of a noisy x_t overlap by
  chance.
- Each g_k is normalised on its own and an object at a time, in metres, and then weighted. Under one
  norm for a whole scene the semantic term took 93% of the step, and moved categories.
- Sizes and heights are not moved: they are right by category, and a cupboard must not shrink to
  come out of a wall. A heading moves on the lever of half the box's diagonal.
- All steps are taken in the last call, of eta_0 each. In earlier calls the predicted clean layout
  is a mean of many: parting its boxes left more collisions than no guidance did.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.paper.guidance.coarse_to_fine import coarse_to_fine_loss
from aeroscene.learning.paper.guidance.collision import collision_loss
from aeroscene.learning.paper.guidance.config import ObjectivesCfg
from aeroscene.learning.paper.guidance.layout import FlatReader, Layout, turn_back, turn_on
from aeroscene.learning.paper.guidance.semantic import SemanticPrior, semantic_loss


class Objectives:
    """L_guide, and its use in sampling."""

    def __init__(
        self,
        read: FlatReader,
        cfg: ObjectivesCfg | None = None,
        prior: SemanticPrior | None = None,
        is_hollow: Bool[Tensor, " categories"] | None = None,
    ) -> None:
        """Set up the objectives.

        Args:
            read: Turns channels into boxes.
            cfg: Weights and steps.
            prior: P_sem; None leaves out the semantic objective.
            is_hollow: Categories that hold fine objects, by number.
        """
        self._read = read
        self._prior = prior
        self._is_hollow = is_hollow
        self.cfg = cfg or ObjectivesCfg()

    def loss(self, x: Tensor, batch: TokenBatch) -> Float[Tensor, " batch"]:
        """L_guide of layouts, one value for each scene.

        Source: the paper's L_guide = L_col + L_c2f + L_sem.
        """
        layout = self._read(x, batch)
        # Detached, so that no collision is solved by shrinking.
        layout = replace(layout, size_m=layout.size_m.detach())
        terms = self._terms(layout, self.cfg.semantic_weight)
        return sum((w * term for _, w, term in terms), x.new_zeros(len(x)))

    def _terms(
        self, layout: Layout, semantic_weight: float
    ) -> Iterator[tuple[str, float, Float[Tensor, " batch"]]]:
        """Yield name, weight and value of each objective that has a weight."""
        cfg = self.cfg
        if cfg.collision_weight > 0:
            yield (
                "L_col",
                cfg.collision_weight,
                collision_loss(
                    layout,
                    tolerance=cfg.iou_tolerance,
                    kind=cfg.iou,
                    softness_m=cfg.softness_m,
                    is_hollow=self._is_hollow,
                ),
            )
        if cfg.coarse_to_fine_weight > 0:
            term = coarse_to_fine_loss(layout, cfg.region_distance, self._is_hollow)
            yield "L_c2f", cfg.coarse_to_fine_weight, term
        if self._prior is not None and semantic_weight > 0:
            yield "L_sem", semantic_weight, semantic_loss(layout, self._prior)

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Return the prediction unchanged: the paper guides the mean."""
        return x0

    def on_mean(self, mean: Tensor, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """Correct the last mean: mu' = mu - eta_0 sum_k g_k / (|g_k| + eps), repeatedly.

        Means of earlier calls are returned unchanged.

        Source: the paper's section "Inference Algorithm".
        """
        del x0
        if at.index < at.n_steps - 1:
            return mean
        for _ in range(self.cfg.n_steps):
            step = self.cfg.step_size * self.direction(mean, batch)
            if batch.given is not None:
                step = step * ~batch.given[..., None]
            mean = mean - self._in_channels(step, mean, batch)
        return mean

    def direction(self, x0: Tensor, batch: TokenBatch) -> Float[Tensor, "batch n 3"]:
        """Weighted sum of the normalised gradients: east, north, and turn on the lever."""
        start = x0.new_zeros(*x0.shape[:2], 3)
        return sum(self.steps(x0, batch).values(), start)

    def steps(self, x0: Tensor, batch: TokenBatch) -> dict[str, Float[Tensor, "batch n 3"]]:
        """Normalised gradient of each objective times its weight, by the objective's name."""
        found = {}
        for name, weight, gradient in self._gradients(self._read(x0, batch)):
            length = gradient.norm(dim=-1, keepdim=True)
            found[name] = weight * gradient / (length + self.cfg.slack)
        return found

    def _gradients(self, layout: Layout) -> list[tuple[str, float, Float[Tensor, "batch n 3"]]]:
        """Name, weight and gradient of each term, by shifts east, north and on the lever."""
        found = []
        with torch.enable_grad():
            shift = torch.zeros_like(layout.center_enu_m).requires_grad_()
            for name, weight, term in self._terms(
                _shifted(layout, shift), self.cfg.semantic_step_weight
            ):
                if term.requires_grad:
                    # The terms share the graph of the shifted layout, so it has to
                    # outlive the first gradient.
                    (gradient,) = torch.autograd.grad(term.sum(), shift, retain_graph=True)
                    found.append((name, weight, gradient))
        return found

    def _in_channels(self, step: Tensor, x0: Tensor, batch: TokenBatch) -> Tensor:
        """Convert a step in metres to a step of the channels that may move."""
        assert batch.frame is not None
        spread = self._read.spread_of(batch).to(x0)
        along = turn_back(step, batch.frame[..., 3:5].to(x0))[..., :2]
        moved = torch.zeros_like(x0)
        moved[..., :2] = along / self._read.metres_of(batch).to(x0)[..., :2]
        # q_z is the sine of half of the remainder, whose slope at 0 is 1/2.
        moved[..., 6] = step[..., 2] / _lever_m(self._read(x0, batch)) / 2 / spread[..., 6]
        return moved


def _lever_m(layout: Layout) -> Float[Tensor, "batch n"]:
    # A turn moves the corners of a box by the angle times half of its diagonal.
    return layout.size_m[..., :2].norm(dim=-1) / 2


def _shifted(layout: Layout, shift: Float[Tensor, "batch n 3"]) -> Layout:
    angle = shift[..., 2] / _lever_m(layout)
    turn = torch.stack([angle.cos(), angle.sin()], dim=-1)
    level = torch.cat([shift[..., :2], torch.zeros_like(shift[..., :1])], dim=-1)
    return replace(
        layout,
        center_enu_m=layout.center_enu_m + level,
        heading=turn_on(layout.heading, turn),
    )
