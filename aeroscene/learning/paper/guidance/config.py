"""Settings of the paper's guidance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from aeroscene.learning.diffusion.config import DiffusionError, require_choice

# A file that names larger numbers is refused before any memory is taken.
_MOST = {
    "n_categories": 4086,
    "width": 4096,
    "category_width": 1024,
    "n_neighbours": 64,
    "n_parts": 64,
    "batch_size": 4096,
}
"""Upper bounds of the semantic prior's numbers, because checkpoints and settings of others name
them."""

_MOST_STEPS = 10_000

IouKind = Literal["exact", "soft", "depth"]

RegionDistance = Literal["centroid", "border"]


@dataclass(frozen=True, kw_only=True)
class ObjectivesCfg:
    """The objectives and their strengths; the paper leaves delta_d and eta_0 open."""

    collision_weight: float = 1.0
    coarse_to_fine_weight: float = 1.0
    semantic_weight: float = 0.1
    """Weight of L_sem in the training loss. The first two weigh the steps of sampling, too; zeros
    are the rows of the paper's ablation."""
    semantic_step_weight: float = 0.0
    """Weight of L_sem in the steps of sampling. At 0.1 it draws walls into rooms, and at 1
    neighbours together: the network knows better than P_sem how objects stand."""
    iou: IouKind = "depth"
    iou_tolerance: float = 0.01
    """delta_d: the IoU from which the paper's collision rate counts a pair. It is in m if `iou` is
    `depth`."""
    softness_m: float = 0.1
    """Softness of the soft IoU."""
    region_distance: RegionDistance = "border"
    """`centroid` is the paper's, whose least value is a heap in the middle of a region."""
    step_size: float = 0.02
    """eta_0, m: the longest displacement of an object by one term in one step."""
    n_steps: int = 40
    """Steps, all of them in the last call."""
    slack: float = 0.5
    """The paper's epsilon beside a norm, 1/m: weaker gradients move less."""

    def __post_init__(self) -> None:
        require_choice("guidance", self, iou=IouKind, region_distance=RegionDistance)
        for name in (
            "collision_weight",
            "coarse_to_fine_weight",
            "semantic_weight",
            "semantic_step_weight",
            "step_size",
        ):
            if getattr(self, name) < 0:
                raise DiffusionError(f"guidance.{name} is {getattr(self, name):g}, valid: from 0")
        # Above 1 no pair would ever collide.
        if not 0 <= self.iou_tolerance < 1:
            raise DiffusionError(
                f"guidance.iou_tolerance is {self.iou_tolerance:g}, valid: 0 to below 1"
            )
        for name in ("softness_m", "slack"):
            if getattr(self, name) <= 0:
                value = getattr(self, name)
                raise DiffusionError(f"guidance.{name} is {value:g}, valid: above 0")
        if not 0 <= self.n_steps <= _MOST_STEPS:
            raise DiffusionError(f"guidance.n_steps is {self.n_steps}, valid: 0 to {_MOST_STEPS}")


@dataclass(frozen=True, kw_only=True)
class SemanticPriorCfg:
    """Shape of the prior and of its training."""

    n_categories: int
    width: int = 64
    category_width: int = 16
    n_neighbours: int = 8
    """Number of nearest objects with which each object forms pairs."""
    n_parts: int = 8
    """Number of Gaussians of the mixture."""
    reach_m: float = 4.0
    """Scale of the middles of the Gaussians."""
    learning_rate: float = 2e-3
    batch_size: int = 16
    """Scenes of a training step."""

    def __post_init__(self) -> None:
        for name, most in _MOST.items():
            value = getattr(self, name)
            if not 1 <= value <= most:
                raise DiffusionError(f"prior.{name} is {value}, valid: 1 to {most}")
        for name in ("reach_m", "learning_rate"):
            if getattr(self, name) <= 0:
                raise DiffusionError(f"prior.{name} is {getattr(self, name):g}, valid: above 0")
