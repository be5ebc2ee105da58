"""Rows of the ablation: one for each choice, against the row that differs in nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from aeroscene.learning.generation.loading import DEFAULT_SAMPLER

Changes = Mapping[str, Mapping[str, Any]]
"""Fields of the configuration by section, as in a file for `aeroscene train --config`."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One choice, switched."""

    name: str
    """Name of the row and of its folder."""
    what: str
    """The difference, in a few words."""
    against: str
    """Row that differs in this alone; a row that names itself is a base line."""


@dataclass(frozen=True, kw_only=True)
class TrainedRow(Row):
    """A small denoiser of its own."""

    changes: Changes = field(default_factory=dict)
    against: str = "default"


@dataclass(frozen=True, kw_only=True)
class SampledRow(Row):
    """Another way of sampling from the same weights."""

    sampler: Mapping[str, Any] = field(default_factory=dict)
    """Fields of `SamplerCfg`."""
    noise: int = 0
    """Number of the draw of the noise."""
    against: str = "shipped"


def _trained(name: str, what: str, **changes: Mapping[str, Any]) -> TrainedRow:
    return TrainedRow(name=name, what=what, changes=changes)


TRAINED: tuple[TrainedRow, ...] = (
    _trained("default", "the default"),
    _trained("default_seed_1", "the default, another seed", training={"seed": 1}),
    _trained("predicts_eps", "predicts the noise (paper)", loss={"parameterisation": "eps"}),
    _trained("predicts_x0", "predicts the clean layout", loss={"parameterisation": "x0"}),
    _trained("coarse_weight_3", "coarse errors count thrice", loss={"coarse_weight": 3.0}),
    _trained("no_narrow_heads", "no heads for close kin", model={"has_narrow_heads": False}),
    _trained("min_snr_5", "errors weighted by min-SNR 5", loss={"min_snr_gamma": 5.0}),
    _trained("small_noise", "half of the times at small noise", loss={"small_noise_share": 0.5}),
    _trained("no_fourier", "no Fourier features", model={"fourier_bands": 0}),
    _trained("blocks_2", "two blocks", model={"blocks": 2}),
    _trained("blocks_6", "six blocks", model={"blocks": 6}),
    _trained("linear_noise", "linear noise schedule (paper)", schedule={"kind": "linear"}),
    _trained("times_independent", "times of a batch independent", loss={"is_stratified": False}),
    _trained("last_weights", "last weights, not averaged", training={"average_decay": 0.0}),
    _trained("rate_cosine", "learning rate by cosine", training={"schedule": "cosine"}),
    _trained(
        "adam_2e-4",
        "Adam at 2e-4 (paper)",
        training={"optimiser": "adam", "learning_rate": 2e-4, "weight_decay": 0.0},
    ),
)
"""Trained at equal steps."""


def _sampled(name: str, what: str, **fields: Any) -> SampledRow:
    return SampledRow(name=name, what=what, sampler=fields)


SAMPLED: tuple[SampledRow, ...] = (
    _sampled("shipped", f"DDIM, {DEFAULT_SAMPLER.n_steps} steps"),
    SampledRow(name="other_noise", what="the same, other noise", noise=1),
    _sampled("ddim_5", "DDIM, 5 steps", n_steps=5),
    _sampled("ddim_20", "DDIM, 20 steps", n_steps=20),
    _sampled("ddim_30", "DDIM, 30 steps", n_steps=30),
    _sampled("ddim_50", "DDIM, 50 steps", n_steps=50),
    _sampled("dpm_10", "DPM-Solver++, 10 steps", kind="dpm-solver++", n_steps=10),
    _sampled("dpm_20", "DPM-Solver++, 20 steps", kind="dpm-solver++", n_steps=20),
    _sampled("dpm_30", "DPM-Solver++, 30 steps", kind="dpm-solver++", n_steps=30),
    _sampled("ddpm_30", "DDPM, 30 steps", kind="ddpm", n_steps=30),
    _sampled("ddpm_100", "DDPM, 100 steps (paper)", kind="ddpm", n_steps=100),
    _sampled("eta_0.5", "DDIM with noise, eta 0.5", eta=0.5),
    _sampled("log_snr", "steps of equal log signal-to-noise", spacing="log_snr"),
)
"""On the shipped weights, each against how `aeroscene generate` samples."""
