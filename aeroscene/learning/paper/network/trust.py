"""Share of the network's correction of the formula that is followed, by noise and kind of channel.

A network that has long learned its scenes corrects the formula too boldly in scenes that it has not
seen, above all where noise hides nearly everything. The best share s of its correction has a closed
form. With the formula's guess e and the correction d, the squared error of e + s d is least at s =
<eps - e, d> / <d, d>. The share is fitted once, at the end of a training, on half of the held-out
scenes. It is taken one standard error lower, so that no group of channels is worse than the formula
at any noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

import torch
from jaxtyping import Float
from torch import Tensor, nn

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import TrustRow
from aeroscene.learning.paper.channels import N_GEOMETRY, ROTATION, SCALE

NOISE_TO_SIGNAL = (100.0, 30.0, 10.0, 4.0, 2.0, 1.0, 0.5, 0.3, 0.1, 0.03, 0.01)
"""Ratios sigma / sqrt(alpha_bar) at which shares are fitted; between them they are interpolated."""
GROUPS: Mapping[str, slice] = {
    "places": slice(0, 2),
    "heights": slice(2, 3),
    "headings": ROTATION,
    "extents": SCALE,
}
"""Channels that are judged and trusted together."""
# A fixed seed, so that the same weights always get the same shares.
_SEED = 11
_LEAST = 1e-12

Denoiser = Callable[[Tensor, Tensor, TokenBatch], Tensor]
"""Predicted noise of a noisy batch at a time of each scene."""


class Trust(nn.Module):
    """Share of the correction that is followed; 1 everywhere if none was fitted."""

    logs: Tensor
    shares: Tensor

    def __init__(self, rows: tuple[TrustRow, ...]) -> None:
        super().__init__()
        shares = torch.ones(len(NOISE_TO_SIGNAL), N_GEOMETRY)
        for k, row in enumerate(rows):
            for value, channels in zip(row, GROUPS.values(), strict=True):
                shares[k, channels] = value
        self.register_buffer("logs", torch.tensor(NOISE_TO_SIGNAL).log().flip(0), persistent=False)
        self.register_buffer("shares", shares.flip(0), persistent=False)

    def forward(
        self, alpha: Float[Tensor, "batch n 1"], sigma: Float[Tensor, "batch n 1"]
    ) -> Float[Tensor, "batch n c"]:
        """Return the shares at the noise of each token, for each channel."""
        # Given tokens have no noise, so their ratio is 0 and takes the last row.
        ratio = (sigma / alpha).clamp(NOISE_TO_SIGNAL[-1], NOISE_TO_SIGNAL[0])
        log = ratio.log().squeeze(-1)
        above = torch.bucketize(log, self.logs).clamp(1, len(self.logs) - 1)
        low, high = self.logs[above - 1], self.logs[above]
        share = ((log - low) / (high - low)).unsqueeze(-1)
        return torch.lerp(self.shares[above - 1], self.shares[above], share)


def fitted_trust(
    predict: Denoiser, variance: Tensor, batches: Iterable[TokenBatch], schedule: Schedule
) -> tuple[TrustRow, ...]:
    """Fit the best shares on scenes that a network has not learned from.

    Args:
        predict: The network, with a trust of 1.
        variance: Variance of the clean channels of each category, (categories, channels).
        batches: Layouts with their clean channels.
        schedule: Noise schedule.

    Returns:
        One row for each ratio of `NOISE_TO_SIGNAL`; shares from 0 to 1.
    """
    kept = list(batches)
    return tuple(_shares(predict, variance, kept, schedule, ratio) for ratio in NOISE_TO_SIGNAL)


def _shares(
    predict: Denoiser,
    variance: Tensor,
    batches: list[TokenBatch],
    schedule: Schedule,
    noise_to_signal: float,
) -> TrustRow:
    time = time_of(schedule, noise_to_signal)
    # The same noise at every ratio, so that shares vary smoothly between them.
    generator = torch.Generator().manual_seed(_SEED)
    along = torch.zeros(len(batches), len(GROUPS))
    square = torch.zeros_like(along)
    for b, batch in enumerate(batches):
        x_t, eps, is_free = noisy(batch, schedule, time, generator)
        guess = formula(x_t, time, variance[batch.kind], schedule)
        with torch.no_grad():
            correction = (predict(x_t, time.expand(len(x_t)), batch) - guess) * is_free
        for k, channels in enumerate(GROUPS.values()):
            along[b, k] = ((eps - guess) * correction)[..., channels].sum()
            square[b, k] = correction[..., channels].square().sum()
    places, heights, headings, extents = _cautious(along, square).clamp(0, 1).tolist()
    return places, heights, headings, extents


def _cautious(
    along: Float[Tensor, "batches groups"], square: Float[Tensor, "batches groups"]
) -> Float[Tensor, " groups"]:
    """Ratio of two sums less its standard error, because too bold costs more than too shy.

    The error is the jackknife's over batches.
    """
    best = along.sum(0) / square.sum(0).clamp(min=_LEAST)
    n = len(along)
    # One batch gives no error.
    if n < 2:
        return best
    without = (along.sum(0) - along) / (square.sum(0) - square).clamp(min=_LEAST)
    return best - (without.var(0, correction=0) * (n - 1)).sqrt()


def formula(
    x_t: Float[Tensor, "batch n c"],
    time: Float[Tensor, ""],
    variance: Float[Tensor, "batch n c"],
    schedule: Schedule,
) -> Float[Tensor, "batch n c"]:
    """Best guess of the noise of each channel by itself, eps = sigma x_t / V.

    Args:
        x_t: Noisy channels.
        time: Time of all scenes.
        variance: Variance v of the clean channels; V = alpha_bar v + sigma^2.
        schedule: Noise schedule.
    """
    alpha, sigma = schedule.signal_and_noise(time)
    return sigma / (alpha**2 * variance + sigma**2) * x_t


def time_of(schedule: Schedule, noise_to_signal: float) -> Float[Tensor, ""]:
    """Return the training time at which sigma / sqrt(alpha_bar) is nearest to a ratio."""
    log = schedule.log_alpha_bar[1:]
    log_ratio = (torch.log(-torch.expm1(log)) - log) / 2
    step = int((log_ratio - math.log(noise_to_signal)).abs().argmin()) + 1
    return torch.tensor(step / schedule.cfg.n_steps)


def noisy(
    batch: TokenBatch, schedule: Schedule, time: Float[Tensor, ""], generator: torch.Generator
) -> tuple[Tensor, Tensor, Tensor]:
    """Noise a batch at one time.

    Args:
        batch: Layouts with `x0` and `weight`.
        schedule: Noise schedule.
        time: Time of all scenes.
        generator: Source of the noise, on the processor.

    Returns:
        The noisy channels, their noise, and 1 for channels that are free.
    """
    assert batch.x0 is not None
    assert batch.weight is not None
    is_free = (batch.weight > 0).to(batch.x0)
    x0 = batch.x0 * is_free
    eps = torch.randn(x0.shape, generator=generator) * is_free
    return schedule.forward_noise(x0, time.expand(len(x0)), eps), eps, is_free
