"""The paper's guidance: the gradient of three objectives on x_t moves the denoising mean."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import DiffusionError, require_choice
from aeroscene.learning.paper.guidance.coarse_to_fine import RegionDistance, coarse_to_fine_loss
from aeroscene.learning.paper.guidance.collision import IouKind, collision_loss
from aeroscene.learning.paper.guidance.layout import Reader
from aeroscene.learning.paper.guidance.semantic import SemanticPrior, semantic_loss
from aeroscene.learning.tokens.batch import TokenBatch

_LEAST_NORM = 1e-8
"""The paper's epsilon under the gradient's norm."""


@dataclass(frozen=True, kw_only=True)
class ObjectivesCfg:
    """The objectives and their strengths; the paper leaves delta_d and eta_0 open."""

    collision_weight: float = 1.0
    coarse_to_fine_weight: float = 1.0
    semantic_weight: float = 1.0
    """Zeros are the rows of the paper's ablation."""
    iou: IouKind = "soft"
    iou_tolerance: float = 0.01
    """delta_d: the IoU from which the paper's collision rate counts a pair."""
    softness_m: float = 0.1
    """Softness of the soft IoU."""
    region_distance: RegionDistance = "centroid"
    """`centroid` is the paper's."""
    step_size: float = 10.0
    """eta_0, in standardised units of x for a whole scene. With less than 3 the terms move nothing
    that the figures see, with 40 they tear scenes apart."""

    def __post_init__(self) -> None:
        require_choice("guidance", self, iou=IouKind, region_distance=RegionDistance)
        weights = ("collision_weight", "coarse_to_fine_weight", "semantic_weight", "step_size")
        for name in weights:
            if getattr(self, name) < 0:
                raise DiffusionError(f"guidance.{name} is {getattr(self, name):g}, valid: from 0")
        if not 0 <= self.iou_tolerance < 1:
            raise DiffusionError(f"guidance.iou_tolerance is {self.iou_tolerance:g}, valid: 0 to 1")
        if self.softness_m <= 0:
            raise DiffusionError(f"guidance.softness_m is {self.softness_m:g}, valid: above 0")


class Objectives:
    """L_guide, and its use in sampling."""

    def __init__(
        self, read: Reader, cfg: ObjectivesCfg | None = None, prior: SemanticPrior | None = None
    ) -> None:
        """Set up; without a prior P_sem the semantic objective is left out."""
        self._read = read
        self._prior = prior
        self.cfg = cfg or ObjectivesCfg()

    def loss(self, x: Tensor, batch: TokenBatch) -> Float[Tensor, " batch"]:
        """L_guide of layouts, one value a scene.

        Source: the paper's L_guide = L_col + L_c2f + L_sem.
        """
        cfg = self.cfg
        layout = self._read(x, batch)
        total = x.new_zeros(len(x))
        if cfg.collision_weight > 0:
            total = total + cfg.collision_weight * collision_loss(
                layout, tolerance=cfg.iou_tolerance, kind=cfg.iou, softness_m=cfg.softness_m
            )
        if cfg.coarse_to_fine_weight > 0:
            to_region = coarse_to_fine_loss(layout, cfg.region_distance)
            total = total + cfg.coarse_to_fine_weight * to_region
        if self._prior is not None and cfg.semantic_weight > 0:
            total = total + cfg.semantic_weight * semantic_loss(layout, self._prior)
        return total

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:  # noqa: ARG002 - of the protocol
        """Nothing: the paper guides x_t."""
        return x0

    def on_mean(self, mean: Tensor, x_t: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """The mean mu' = mu - eta_t g / (|g| + eps) with eta_t = eta_0 sqrt(1 - alpha_bar).

        Source: the paper's section "Inference Algorithm". The norm is that of each scene.
        """
        with torch.enable_grad():
            x = x_t.detach().requires_grad_()
            loss = self.loss(x, batch).sum()
            if not loss.requires_grad:
                return mean
            (gradient,) = torch.autograd.grad(loss, x)
        if at.fixed is not None:
            gradient = gradient * ~at.fixed
        norm = gradient.flatten(1).norm(dim=1)[:, None, None]
        size = self.cfg.step_size * (1 - at.alpha_bar) ** 0.5
        return mean - size * gradient / (norm + _LEAST_NORM)
