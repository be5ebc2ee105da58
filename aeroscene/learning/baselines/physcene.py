"""PhyScene: DiffuScene's diffusion with physical guidance in the last steps of the sampling.

This is a re-implementation from the paper. PhyScene's guidance has three terms: collisions of
boxes, objects out of their room, and objects in the way of an embodied agent. Here the first is the
overlap of all pairs. The second is the distance of fine objects from the outlines of their nearest
coarse ones, because our layouts have no given floor plan. The third is left out, because our agent
flies. PhyScene's articulated objects are no part of a layout of boxes.

The gradient of both terms, on the mean of each step, moves places and headings, but no sizes or
categories. Otherwise collisions would be solved by shrinking. PhyScene guides the last 10 of 1,000
steps. Here the last tenth of the fewer steps is guided.

Source: Yang, Jia, Zhi and Huang 2024, "PhyScene: Physically Interactable 3D Scene Synthesis for
Embodied AI", CVPR, sections 3.2 and 3.3.
"""

from __future__ import annotations

import torch
from torch import Tensor

from aeroscene.learning.baselines.diffuscene import DiffuScene, LayoutReader
from aeroscene.learning.baselines.layouts import HEADING
from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.sampling import Guidance, Moment
from aeroscene.learning.paper.guidance.coarse_to_fine import coarse_to_fine_loss
from aeroscene.learning.paper.guidance.collision import collision_loss

# Last share of the steps that are guided, and steps down the gradient in each of them.
_GUIDED_SHARE = 0.1
_INNER_STEPS = 4
_SOFTNESS_M = 0.1
_STEP_M = 0.25
"""Longest displacement of an object in one inner step, m."""


class PhyScene(DiffuScene):
    """DiffuScene with guidance. Its training is DiffuScene's."""

    @property
    def guidance(self) -> Guidance | None:
        """Guidance by collisions and rooms in the last steps."""
        return PhysicalGuidance(self.read)


class PhysicalGuidance:
    """Pulls objects apart and into their rooms while a layout is sampled."""

    def __init__(self, read: LayoutReader) -> None:
        self._read = read

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Return the prediction unchanged: the mean is guided instead."""
        return x0

    def on_mean(self, mean: Tensor, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Return the mean after some steps down the gradient of both terms.

        Earlier steps return it unchanged.
        """
        if at.index < at.n_steps - max(1, round(_GUIDED_SHARE * at.n_steps)):
            return mean
        for _ in range(_INNER_STEPS):
            mean = self._step(mean, batch)
        return mean

    def _step(self, mean: Tensor, batch: TokenBatch) -> Tensor:
        with torch.enable_grad():
            x = mean.detach().requires_grad_()
            layout = self._read(x, batch)
            loss = collision_loss(layout, tolerance=0.0, kind="soft", softness_m=_SOFTNESS_M)
            loss = (loss + coarse_to_fine_loss(layout, "border")).sum()
            # Without any overlap or distance the loss is a constant and has no gradient.
            if not loss.requires_grad:
                return mean
            (gradient,) = torch.autograd.grad(loss, x)
        is_moved = torch.zeros(gradient.shape[-1], device=gradient.device)
        is_moved[:3] = 1.0
        is_moved[HEADING] = 1.0
        gradient = gradient * is_moved
        # Each object moves by its own gradient, at most by `_STEP_M`: one deep collision must not
        # take the step from all others.
        length = gradient.norm(dim=-1, keepdim=True)
        return mean - _STEP_M * gradient / length.clamp(min=1.0) / self._read.spread_m
