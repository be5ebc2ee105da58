"""Sampling: from noise to a layout in a few steps, guided on the way.

Each step predicts the clean layout, lets guidance and given channels correct it, and moves to the
next noise level. The paper samples by DDPM. DDIM and DPM-Solver++ stand beside it, because they
need fewer calls of the network.

Source: the paper's algorithm 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import SamplerCfg
from aeroscene.learning.diffusion.loss import Denoiser, channel_weight
from aeroscene.learning.diffusion.parameterisation import predicted_x0
from aeroscene.learning.diffusion.schedule import Schedule, normal_like
from aeroscene.learning.diffusion.steps import Level, ddim_step, ddpm_step, dpm_solver_step, levels


@dataclass(frozen=True)
class Fixed:
    """Channels that are given and come out unchanged: the coarse part in scene completion."""

    mask: Bool[Tensor, "batch n channels"]
    """True for channels that are given."""
    x0: Float[Tensor, "batch n channels"]
    """Values of given channels; the others are not read."""

    def impose(self, x: Tensor, truth: Tensor) -> Tensor:
        """Return a layout with the given channels in their places.

        Args:
            x: The layout.
            truth: Values of the given channels at x's noise level.
        """
        return torch.where(self.mask, truth, x)


@dataclass(frozen=True)
class Moment:
    """State of a sampler at a step."""

    index: int
    """Number of the step, from 0."""
    n_steps: int
    """Number of steps of the sampler."""
    time: float
    """Time of x_t: 1 is noise."""
    alpha_bar: float
    """Share of signal power left in x_t."""
    fixed: Bool[Tensor, "batch n channels"] | None
    """Channels that must not change."""

    @property
    def is_last(self) -> bool:
        """True if the x0 of this step is the result."""
        return self.index == self.n_steps - 1


class Guidance(Protocol):
    """Guidance that pulls a layout towards plausibility while it is sampled."""

    def on_x0(self, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """Correct the predicted clean layout."""
        ...

    def on_mean(self, mean: Tensor, x0: Tensor, batch: TokenBatch, at: Moment) -> Tensor:
        """Correct the next state before its noise is added; `x0` is the predicted clean layout."""
        ...


OnStep = Callable[[Moment, Tensor, Tensor], None]
"""Callback `on_step(moment, x_t, x0)` after every step's prediction and guidance."""


@torch.no_grad()
def sample(
    model: Denoiser,
    batch: TokenBatch,
    schedule: Schedule,
    cfg: SamplerCfg,
    generator: torch.Generator,
    *,
    guidance: Guidance | None = None,
    fixed: Fixed | None = None,
    x0_range: tuple[Tensor, Tensor] | None = None,
    on_step: OnStep | None = None,
) -> Float[Tensor, "batch n channels"]:
    """Draw layouts for a batch of scenes.

    Args:
        model: The network.
        batch: The scenes' tokens; `x0` is not read. The shape of `weight` gives the number of
            channels. Where it is 0 the layout is held at 0, as in training.
        schedule: Noise schedule of the training.
        cfg: Settings of the sampler.
        generator: Source of all noise; same seed, same device: same layouts.
        guidance: Applied at every step.
        fixed: Given channels. They are in x_t as noised truth and come out exactly.
        x0_range: Least and greatest values in training, which broadcast to the layouts; the
            prediction is clipped to them (static thresholding, Saharia et al. 2022, section 2.3).
        on_step: Called at every step.

    Source: the paper's algorithm 2; clipping and fixed channels are ours.
    """
    weight = channel_weight(batch)
    is_free = (weight > 0).to(weight)
    first_noise = normal_like(is_free, generator) * is_free
    path = levels(schedule, sampling_times(schedule, cfg))
    x, before = first_noise, None
    for index, (at, to) in enumerate(pairwise(path)):
        if fixed is not None:
            # One draw of noise serves all steps, so given channels follow the path of a
            # deterministic sampler.
            x = fixed.impose(x, (at.alpha * fixed.x0 + at.sigma * first_noise) * is_free)
        moment = Moment(
            index, cfg.n_steps, at.time, at.alpha**2, None if fixed is None else fixed.mask
        )
        x0 = _predict(model, x, batch, at, cfg, x0_range) * is_free
        x0 = x0 if fixed is None else fixed.impose(x0, fixed.x0)
        if guidance is not None:
            x0 = guidance.on_x0(x0, batch, moment)
            # Guidance may have moved given channels; put them back.
            x0 = x0 if fixed is None else fixed.impose(x0, fixed.x0)
        if on_step is not None:
            on_step(moment, x, x0)
        mean, std = _step(x, x0, at, to, before, cfg)
        if guidance is not None:
            mean = guidance.on_mean(mean, x0, batch, moment)
        x = mean + std * normal_like(mean, generator) * is_free if std > 0 else mean
        before = (x0, at)
    # The last mean of DPM-Solver++ is not exactly x0.
    return x if fixed is None else fixed.impose(x, fixed.x0)


def sampling_times(schedule: Schedule, cfg: SamplerCfg) -> Float[Tensor, " n_steps_and_1"]:
    """Return the times between which the sampler steps, from 1 down to 0.

    With `log_snr` spacing the times are even in log SNR, and a last step leads to 0, where the log
    SNR is infinite.
    """
    if cfg.spacing == "time":
        return torch.linspace(1, 0, cfg.n_steps + 1, dtype=torch.float64)
    log = schedule.log_alpha_bar[1:]
    half_log_snr = (log - torch.log1p(-log.exp())) / 2
    wanted = torch.linspace(
        float(half_log_snr[-1]), float(half_log_snr[0]), cfg.n_steps, dtype=torch.float64
    )
    # Negated, both rise, as searchsorted requires.
    above = torch.searchsorted(-half_log_snr, -wanted).clamp(1, len(log) - 1)
    left, right = half_log_snr[above - 1], half_log_snr[above]
    share = ((wanted - left) / (right - left)).clamp(0, 1)
    times = (above + share) / schedule.cfg.n_steps
    # Interpolation may end a rounding error below 1.
    times[0] = 1.0
    return torch.cat([times, times.new_zeros(1)])


def _predict(
    model: Denoiser,
    x: Tensor,
    batch: TokenBatch,
    at: Level,
    cfg: SamplerCfg,
    x0_range: tuple[Tensor, Tensor] | None,
) -> Tensor:
    time = x.new_full((len(x),), at.time)
    alpha, sigma = (x.new_full((len(x),), value) for value in (at.alpha, at.sigma))
    output = model(x, time, batch).output
    x0 = predicted_x0(cfg.parameterisation, output.to(x), x, alpha, sigma)
    return x0 if x0_range is None else torch.clamp(x0, *x0_range)


def _step(
    x: Tensor,
    x0: Tensor,
    at: Level,
    to: Level,
    before: tuple[Tensor, Level] | None,
    cfg: SamplerCfg,
) -> tuple[Tensor, float]:
    if cfg.kind == "ddpm":
        return ddpm_step(x, x0, at, to, cfg.variance)
    if cfg.kind == "ddim":
        return ddim_step(x, x0, at, to, cfg.eta)
    return dpm_solver_step(x, x0, at, to, before)
