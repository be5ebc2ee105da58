"""The paper's preset: what its network is, how it is trained, guided and sampled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from aeroscene.learning.diffusion.loss import LossCfg
from aeroscene.learning.diffusion.sampling import SamplerCfg
from aeroscene.learning.diffusion.schedule import ScheduleCfg
from aeroscene.learning.model.config import N_GEOMETRY, ModelCfg
from aeroscene.learning.paper.guidance.objectives import ObjectivesCfg
from aeroscene.learning.paper.guidance.semantic import SemanticPriorCfg
from aeroscene.learning.training.config import TrainCfg
from aeroscene.scene.catalogue import CATALOGUE

PAPER_SAMPLER = SamplerCfg(kind="ddpm", n_steps=100)
"""Section 4.1: "we employ 100 reverse diffusion steps"."""
PAPER_TRAINING = TrainCfg(
    batch_size=64,
    optimiser="adam",
    learning_rate=2e-4,
    weight_decay=0.0,
    schedule="cosine",
    warmup_steps=0,
    clip_norm=0.0,
    average_decay=0.0,
    keep="last",
)
"""Section 4.1, "Implementation Details": Adam at 2e-4, batches of 64, cosine schedule."""


def paper_cfg(n_categories: int) -> ModelCfg:
    """The paper's network, equations 3 to 12 as they stand, for C categories."""
    return ModelCfg(
        denoiser="unet",
        routing="learned",
        coarse_branch="cnn",
        fine_branch="radius_gnn",
        channels=N_GEOMETRY + n_categories,
        n_categories=n_categories,
        blocks=4,
    )


PAPER_SECTIONS: Mapping[str, Any] = {
    "model": paper_cfg(len(CATALOGUE)),
    "schedule": ScheduleCfg(kind="linear"),
    # The paper leaves lambda_guide open but for "small", and does not supervise its gate.
    "loss": LossCfg(
        parameterisation="eps",
        is_stratified=False,
        guide_weight=0.1,
        guide_scenes=8,
        gate_weight=0.1,
    ),
    "training": PAPER_TRAINING,
    "prior": SemanticPriorCfg(n_categories=len(CATALOGUE)),
    "guidance": ObjectivesCfg(),
}
"""Sections of the paper's configuration, by name."""
