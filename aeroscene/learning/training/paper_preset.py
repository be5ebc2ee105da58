"""The paper's presets: their network, training, guidance and sampling.

`paper` denoises all objects at once, in the site's frame. `progressive` denoises coarse objects
first, then fine ones given these, each in the frame of its region. This is the nearest reading of
the paper's title, and of its sentence that fine details are "arranged relative to the larger
elements". The paper's algorithm 2 is one chain; two chains are a deviation.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from aeroscene.learning.diffusion.config import LossCfg, SamplerCfg, ScheduleCfg
from aeroscene.learning.model.config import N_GEOMETRY, ModelCfg
from aeroscene.learning.paper.contents.config import ContentsCfg
from aeroscene.learning.paper.guidance.config import ObjectivesCfg, SemanticPriorCfg
from aeroscene.learning.training.config import TrainCfg
from aeroscene.scene.catalogue import CATALOGUE

_REVERSE_STEPS = 100
"""Section 4.1: "we employ 100 reverse diffusion steps"."""
PAPER_TRAINING = TrainCfg(
    batch_size=64,
    optimiser="adam",
    learning_rate=1e-3,
    second_decay=0.99,
    weight_decay=0.0,
    schedule="cosine",
    warmup_steps=100,
    clip_norm=1.0,
    average_decay=0.999,
    keep="best",
)
"""Section 4.1, "Implementation Details": Adam, batches of 64, cosine schedule. The rate is five
times the paper's 2e-4, with an average of the weights: it reaches in 2,000 steps what 2e-4 reaches
in 10,000."""
CONTENTS_TRAINING = TrainCfg(
    batch_size=64, learning_rate=2e-3, second_decay=0.99, warmup_steps=50, look_steps=100
)


def paper_sampler(*, has_regions: bool) -> SamplerCfg:
    """Return the paper's ancestral sampling.

    The two passes of the progressive preset share its steps.
    """
    n_steps = _REVERSE_STEPS // 2 if has_regions else _REVERSE_STEPS
    return SamplerCfg(kind="ddpm", n_steps=n_steps, parameterisation="eps")


def paper_cfg(n_categories: int) -> ModelCfg:
    """Return the paper's network, equations 3 to 12, for C categories."""
    return ModelCfg(
        denoiser="unet",
        routing="learned",
        coarse_branch="cnn",
        fine_branch="radius_gnn",
        channels=N_GEOMETRY,
        n_categories=n_categories,
        blocks=4,
        # 128 m halved eight times: waves down to 0.5 m for faces.
        fourier_bands=9,
        unet_widths=(192, 192),
        grid_shape=(8, 8, 4),
        grid_reach=1.0,
        graph_radius=2.0,
    )


PAPER_SECTIONS: Mapping[str, Any] = {
    "model": paper_cfg(len(CATALOGUE)),
    "schedule": ScheduleCfg(kind="log_snr"),
    # The paper leaves lambda_guide open except for "small", and does not supervise its gate.
    "loss": LossCfg(
        parameterisation="eps",
        weighting="velocity",
        log_snr_mean=1.0,
        log_snr_spread=2.5,
        log_snr_even_share=0.15,
        guide_weight=0.05,
        guide_scenes=4,
        gate_weight=0.02,
    ),
    "training": PAPER_TRAINING,
    "contents": ContentsCfg(),
    "contents_training": CONTENTS_TRAINING,
    "prior": SemanticPriorCfg(n_categories=len(CATALOGUE)),
    "guidance": ObjectivesCfg(),
}
"""Sections of the paper's configuration, by name."""
PROGRESSIVE_SECTIONS: Mapping[str, Any] = dict(PAPER_SECTIONS)
"""The same network and settings: batches (`paper.training_set`) and passes (`generation.layouts`)
make the difference."""
