"""Layouts of which everything is known: Gaussian tokens and their exact denoiser."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import Parameterisation
from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.diffusion.parameterisation import prediction_target
from aeroscene.learning.diffusion.schedule import Schedule


def blank_batch(n_scenes: int, n: int, channels: int, *, n_coarse: int = 1) -> TokenBatch:
    """Tokens below one site, all of one kind, every channel free."""
    zero = torch.zeros(n_scenes, n, dtype=torch.long)
    depth = torch.ones_like(zero)
    depth[:, 0] = 0
    return TokenBatch(
        kind=zero,
        parent=zero,
        depth=depth,
        ordinal=zero,
        twin=zero,
        mask=torch.ones(n_scenes, n, dtype=torch.bool),
        domain=torch.zeros(n_scenes, dtype=torch.long),
        wish=torch.zeros(n_scenes, 3),
        n_coarse_slots=n_coarse,
        weight=torch.ones(n_scenes, n, channels, dtype=torch.float64),
    )


@dataclass(frozen=True)
class GaussianDenoiser:
    """The best possible denoiser of independent channels with a mean and a spread."""

    mean: float
    spread: float
    schedule: Schedule
    parameterisation: Parameterisation

    def __call__(self, x_t: Tensor, time: Tensor, _: TokenBatch) -> Prediction:
        """What the network would say: E[x0 | x_t] in any parameterisation."""
        alpha, sigma = self.schedule.signal_and_noise(time)
        a, s = alpha[:, None, None], sigma[:, None, None]
        gain = a * self.spread**2 / (a**2 * self.spread**2 + s**2)
        x0 = self.mean + gain * (x_t - a * self.mean)
        eps = (x_t - a * x0) / s
        return Prediction(prediction_target(self.parameterisation, x0, eps, alpha, sigma))

    def endpoint(self, x_1: Tensor, alpha: float, sigma: float) -> Tensor:
        """Where the probability flow takes the noise x_1 of a level: each quantile to its own."""
        spread = (alpha**2 * self.spread**2 + sigma**2) ** 0.5
        return self.mean + self.spread / spread * (x_1 - alpha * self.mean)
