"""Rows of the ablation: one for each choice, against the row that differs in nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from aeroscene.learning.generation.loading import DEFAULT_SAMPLER
from aeroscene.learning.guidance.borders import BordersCfg
from aeroscene.learning.guidance.config import NO_GUIDANCE, GuidanceCfg
from aeroscene.learning.guidance.separation import SeparationCfg
from aeroscene.learning.paper.guidance.objectives import ObjectivesCfg

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
    is_guided: bool = True
    """Whether guidance knows these channels; without, the row is measured unguided alone."""


@dataclass(frozen=True, kw_only=True)
class SampledRow(Row):
    """Another way of sampling from the same weights."""

    sampler: Mapping[str, Any] = field(default_factory=dict)
    """Fields of `SamplerCfg`."""
    guidance: GuidanceCfg = field(default_factory=GuidanceCfg)
    noise: int = 0
    """Number of the draw of the noise."""
    against: str = "shipped"


_PAPERS_PARTS = {
    "denoiser": "unet",
    "routing": "learned",
    "coarse_branch": "cnn",
    "fine_branch": "radius_gnn",
}
_UNET = _PAPERS_PARTS | {
    "routing": "given",
    "coarse_branch": "attention",
    "fine_branch": "siblings",
}


def _trained(name: str, what: str, **changes: Mapping[str, Any]) -> TrainedRow:
    return TrainedRow(name=name, what=what, changes=changes)


def _recoded(name: str, what: str, **codec: str) -> TrainedRow:
    changes = {"codec": codec, "model": {"has_borders": False}}
    return TrainedRow(name=name, what=what, changes=changes, against="no_borders", is_guided=False)


TRAINED: tuple[TrainedRow, ...] = (
    _trained("default", "the default"),
    _trained("default_seed_1", "the default, another seed", training={"seed": 1}),
    _trained("predicts_eps", "predicts the noise (paper)", loss={"parameterisation": "eps"}),
    _trained("predicts_x0", "predicts the clean layout", loss={"parameterisation": "x0"}),
    _trained("no_borders", "does not see borders", model={"has_borders": False}),
    _trained("coarse_weight_1", "coarse errors count once", loss={"coarse_weight": 1.0}),
    _trained("no_narrow_heads", "no heads for close kin", model={"has_narrow_heads": False}),
    _trained("paper_network", "3D CNN, radius GNN, gate, UNet (paper)", model=_PAPERS_PARTS),
    _trained("unet_given", "UNet for the head on tokens", model=_UNET),
    _trained("unet_given_cnn", "UNet and 3D CNN", model=_UNET | {"coarse_branch": "cnn"}),
    _trained("unet_given_gnn", "UNet and GNN", model=_UNET | {"fine_branch": "radius_gnn"}),
    _trained("min_snr_5", "errors weighted by min-SNR 5", loss={"min_snr_gamma": 5.0}),
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
    _recoded("codec_parent", "places over half the parent's extents", frame="parent"),
    _recoded("codec_scene", "places in the frame of the scene", frame="scene"),
    _recoded("codec_angle", "yaw as an angle", yaw="angle"),
    _recoded("codec_linear", "sizes as they are, not as logarithms", size="linear"),
)
"""Trained at equal steps. Those of another codec are held against `no_borders`: guidance and
borders read the default's channels."""


def _sampled(name: str, what: str, **fields: Any) -> SampledRow:
    return SampledRow(name=name, what=what, sampler=fields)


def _guided(name: str, what: str, guidance: GuidanceCfg) -> SampledRow:
    return SampledRow(name=name, what=what, guidance=guidance)


_PAPERS_GUIDANCE = replace(NO_GUIDANCE, objectives=ObjectivesCfg())
_UNALIGNED = GuidanceCfg(alignment=None)
_BORDERLESS = replace(_UNALIGNED, borders=None)
_WITHIN_ONLY = replace(_UNALIGNED, borders=BordersCfg(n_steps=0, last_n_steps=0))
_BORDERS_ALWAYS = GuidanceCfg(borders=BordersCfg(late_share=1.0))
_WITHOUT_HOPS = SeparationCfg(n_hops=0)
_SEPARATION = replace(_BORDERLESS, separation=_WITHOUT_HOPS)


def _late(share: float) -> GuidanceCfg:
    return GuidanceCfg(separation=SeparationCfg(late_share=share))


SAMPLED: tuple[SampledRow, ...] = (
    _sampled("shipped", f"DDIM, {DEFAULT_SAMPLER.n_steps} steps, all guidance"),
    SampledRow(name="other_noise", what="the same, other noise", noise=1),
    _guided("unguided", "no guidance", NO_GUIDANCE),
    _guided("papers_guidance", "L_guide on x_t (paper)", _PAPERS_GUIDANCE),
    _guided("separation", "separation alone, no hops", _SEPARATION),
    _guided("separation_hops", "separation with hops", _BORDERLESS),
    _guided("separation_within", "and parts within their building", _WITHIN_ONLY),
    _guided("no_alignment", "all but alignment", _UNALIGNED),
    _guided("no_hops", "all but hops", GuidanceCfg(separation=_WITHOUT_HOPS)),
    _guided("at_last", "separation at the last step alone", _late(0.0)),
    _guided("late_0.3", "separation in the last 30% of the steps", _late(0.3)),
    _guided("late_1", "separation in all steps", _late(1.0)),
    _guided("borders_always", "borders in all steps", _BORDERS_ALWAYS),
    _sampled("ddim_10", "DDIM, 10 steps", n_steps=10),
    _sampled("ddim_20", "DDIM, 20 steps", n_steps=20),
    _sampled("ddim_50", "DDIM, 50 steps", n_steps=50),
    _sampled("dpm_10", "DPM-Solver++, 10 steps", kind="dpm-solver++", n_steps=10),
    _sampled("dpm_20", "DPM-Solver++, 20 steps", kind="dpm-solver++", n_steps=20),
    _sampled("dpm_30", "DPM-Solver++, 30 steps", kind="dpm-solver++"),
    _sampled("ddpm_30", "DDPM, 30 steps", kind="ddpm"),
    _sampled("ddpm_100", "DDPM, 100 steps (paper)", kind="ddpm", n_steps=100),
    _sampled("eta_0.5", "DDIM with noise, eta 0.5", eta=0.5),
    _sampled("log_snr", "steps of equal log signal-to-noise", spacing="log_snr"),
)
"""On the shipped weights, each against how `aeroscene generate` samples."""
