"""Choices of our model that `--table choices` changes one by one, in training and in sampling.

Each row changes a single choice and keeps the others, so that a difference between two rows has one
cause. A second seed is among the rows, because it shows how large a difference is mere chance.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

Fields = Mapping[str, Any]

TRAINED: Mapping[str, tuple[str, Mapping[str, Fields]]] = MappingProxyType(
    {
        "seed_1": ("another seed", {"training": {"seed": 1}, "writer_training": {"seed": 1}}),
        "predicts_eps": ("predicts the noise (paper)", {"loss": {"parameterisation": "eps"}}),
        "predicts_x0": ("predicts the clean layout", {"loss": {"parameterisation": "x0"}}),
        "coarse_weight_3": ("coarse errors count thrice", {"loss": {"coarse_weight": 3.0}}),
        "no_narrow_heads": ("no heads for close kin", {"model": {"has_narrow_heads": False}}),
        "min_snr_5": ("errors weighted by min-SNR 5", {"loss": {"min_snr_gamma": 5.0}}),
        "small_noise": ("half of the times at small noise", {"loss": {"small_noise_share": 0.5}}),
        "no_fourier": ("no Fourier features", {"model": {"fourier_bands": 0}}),
        "blocks_2": ("two blocks", {"model": {"blocks": 2}}),
        "blocks_6": ("six blocks", {"model": {"blocks": 6}}),
        "linear_noise": ("linear noise schedule (paper)", {"schedule": {"kind": "linear"}}),
        "times_independent": (
            "times of a batch independent",
            {"loss": {"is_stratified": False}},
        ),
        "last_weights": ("last weights, not averaged", {"training": {"average_decay": 0.0}}),
        "rate_cosine": ("learning rate by cosine", {"training": {"schedule": "cosine"}}),
        "adam_2e-4": (
            "Adam at 2e-4 (paper)",
            {"training": {"optimiser": "adam", "learning_rate": 2e-4, "weight_decay": 0.0}},
        ),
    }
)
"""Title and changed fields of a training, as in a file for `aeroscene train --config`."""

SAMPLED: Mapping[str, tuple[str, Fields]] = MappingProxyType(
    {
        "ddim_5": ("DDIM, 5 steps", {"kind": "ddim", "n_steps": 5}),
        "ddim_20": ("DDIM, 20 steps", {"kind": "ddim", "n_steps": 20}),
        "ddim_50": ("DDIM, 50 steps", {"kind": "ddim", "n_steps": 50}),
        "ddim_noise": ("DDIM with noise, eta 0.5", {"kind": "ddim", "n_steps": 30, "eta": 0.5}),
        "dpm_10": ("DPM-Solver++, 10 steps", {"n_steps": 10}),
        "dpm_20": ("DPM-Solver++, 20 steps", {"n_steps": 20}),
        "dpm_30": ("DPM-Solver++, 30 steps", {"n_steps": 30}),
        "ddpm_30": ("DDPM, 30 steps", {"kind": "ddpm", "n_steps": 30}),
        "ddpm_100": ("DDPM, 100 steps (paper)", {"kind": "ddpm", "n_steps": 100}),
        "log_snr": ("steps of equal log signal-to-noise", {"spacing": "log_snr"}),
    }
)
"""Title and fields of `SamplerCfg` that differ from those of `aeroscene generate`."""
