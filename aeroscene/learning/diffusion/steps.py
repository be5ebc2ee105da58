"""One step back in time by each sampler, as a mean and the standard deviation of its noise.

All steps are written with the predicted clean layout x0, whatever the network predicts, because
clipping and guidance have changed x0 before.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, isinf, log, sqrt

import torch
from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.diffusion.config import Variance
from aeroscene.learning.diffusion.schedule import Schedule


@dataclass(frozen=True)
class Level:
    """Noise level at one time of a sampler's path."""

    time: float
    alpha: float
    """sqrt(alpha_bar), the factor of the layout."""
    sigma: float
    """sqrt(1 - alpha_bar), the factor of the noise."""

    @property
    def half_log_snr(self) -> float:
        """Lambda of DPM-Solver, log(alpha / sigma); infinite without noise."""
        return inf if self.sigma == 0 else log(self.alpha / self.sigma)


def levels(schedule: Schedule, times: Float[Tensor, " n"]) -> list[Level]:
    """Return the noise level at each time."""
    alpha_bar = schedule.alpha_bar(times.double())
    rows = zip(
        times.tolist(), alpha_bar.sqrt().tolist(), (1 - alpha_bar).sqrt().tolist(), strict=True
    )
    return [Level(*row) for row in rows]


def noise_in(x: Tensor, x0: Tensor, at: Level) -> Tensor:
    """Return the noise that makes x of x0 at a level."""
    return (x - at.alpha * x0) / at.sigma


def ddpm_step(
    x: Tensor, x0: Tensor, at: Level, to: Level, variance: Variance
) -> tuple[Tensor, float]:
    """Ancestral step of DDPM.

    Sampling levels lie further apart than those of training. Therefore alpha_t is the ratio of
    their alpha_bar (Nichol and Dhariwal 2021, section 4), so that 100 steps serve a network trained
    with T = 1000. The paper leaves Sigma open: `small` is the posterior's of a known x0, `large` is
    beta_t (Ho et al. 2020, section 3.2).

    Returns:
        Mean and standard deviation of the next state.

    Source: the paper's mu_theta of the section "Inference Algorithm".
    """
    alpha_t = (at.alpha / to.alpha) ** 2
    beta_t = 1 - alpha_t
    mean = (x - beta_t / at.sigma * noise_in(x, x0, at)) / sqrt(alpha_t)
    # The last step adds no noise: its mean is the result.
    if to.sigma == 0:
        return mean, 0.0
    return mean, sqrt(beta_t) * (to.sigma / at.sigma if variance == "small" else 1.0)


def ddim_step(x: Tensor, x0: Tensor, at: Level, to: Level, eta: float) -> tuple[Tensor, float]:
    """Step of DDIM; `eta` 0 adds no noise, 1 as much as DDPM with small variance.

    Returns:
        Mean and standard deviation of the next state.

    Source: Song, Meng and Ermon 2021, eqs. (12) and (16).
    """
    std = eta * to.sigma / at.sigma * sqrt(max(0.0, 1 - (at.alpha / to.alpha) ** 2))
    # Rounding may take the difference below 0.
    along = sqrt(max(0.0, to.sigma**2 - std**2))
    return to.alpha * x0 + along * noise_in(x, x0, at), std


def dpm_solver_step(
    x: Tensor, x0: Tensor, at: Level, to: Level, before: tuple[Tensor, Level] | None
) -> tuple[Tensor, float]:
    """Step of DPM-Solver++(2M), of second order if the step before is known, else of first order.

    Args:
        x: Present state.
        x0: Predicted clean layout.
        at: Present level.
        to: Next level.
        before: Clean layout and level of the step before.

    Returns:
        The next state, and 0.0: the sampler is deterministic.

    Source: Lu et al. 2022, "DPM-Solver++", algorithm 2.
    """
    step = to.half_log_snr - at.half_log_snr
    blend = x0
    # The last step goes to sigma 0, an infinite step in log SNR, where the
    # extrapolation is undefined.
    if before is not None and not isinf(step):
        ratio = (at.half_log_snr - before[1].half_log_snr) / step
        blend = torch.lerp(before[0], x0, 1 + 1 / (2 * ratio))
    return to.sigma / at.sigma * x + to.alpha * (1 - exp(-step)) * blend, 0.0
