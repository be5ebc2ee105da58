"""The noise schedule: the share of a layout that is left at each time, and the forward process.

Training knows T discrete steps, while samplers ask for any time. The schedule is therefore a
function of continuous time that is exact at the T steps and interpolates log alpha_bar between
them. Logarithms keep precision where alpha_bar is close to 1 or 0.
"""

from __future__ import annotations

from functools import cached_property
from math import pi

import torch
from jaxtyping import Float, Float64
from torch import Tensor

from aeroscene.learning.diffusion.config import ScheduleCfg

_LEAST_ALPHA_BAR = 1e-5
"""The cosine schedule's alpha_bar at t = 1; at 0 the noise would hide the layout wholly."""
_COSINE_OFFSET = 0.008
"""Nichol and Dhariwal 2021, eq. (17): keeps the first steps' noise from vanishing."""


class Schedule:
    """Noise schedule: alpha_bar as a function of continuous time, exact at the T training steps."""

    def __init__(self, cfg: ScheduleCfg | None = None) -> None:
        self.cfg = cfg or ScheduleCfg()

    @cached_property
    def log_alpha_bar(self) -> Float64[Tensor, " n_steps_and_1"]:
        """Logarithm of alpha_bar at t = 0, 1/T, ..., 1."""
        cfg = self.cfg
        if cfg.kind == "linear":
            # Ho et al. state their variances for T = 1000.
            scale = 1000 / cfg.n_steps
            beta = torch.linspace(
                cfg.beta_first * scale, cfg.beta_last * scale, cfg.n_steps, dtype=torch.float64
            )
            log = torch.log1p(-beta).cumsum(0)
            return torch.cat([log.new_zeros(1), log])
        if cfg.kind == "log_snr":
            ratio = torch.linspace(
                cfg.log_snr_first, cfg.log_snr_last, cfg.n_steps, dtype=torch.float64
            )
            return torch.cat([ratio.new_zeros(1), torch.nn.functional.logsigmoid(ratio)])
        time = torch.arange(cfg.n_steps + 1, dtype=torch.float64) / cfg.n_steps
        angle = (time + _COSINE_OFFSET) / (1 + _COSINE_OFFSET) * (pi / 2)
        power = torch.cos(angle) ** 2
        # Raised by a trace, not cut off, because log alpha_bar has to fall at every step.
        return torch.lerp(power / power[0], torch.ones_like(power), _LEAST_ALPHA_BAR).log()

    def alpha_bar(self, time: Float[Tensor, "*batch"]) -> Float[Tensor, "*batch"]:
        """Share of signal power left at times in [0, 1].

        Between the T steps of training log alpha_bar is linear in time.
        """
        table = self.log_alpha_bar.to(time.device)
        place = time.double().clamp(0, 1) * self.cfg.n_steps
        below = place.floor().clamp(max=self.cfg.n_steps - 1)
        low, share = below.long(), place - below
        log = torch.lerp(table[low], table[low + 1], share)
        return log.exp().to(time.dtype)

    def draw_time(
        self,
        n: int,
        generator: torch.Generator,
        *,
        stratified: bool,
        small_noise_share: float = 0.0,
        log_snr: tuple[float, float, float] | None = None,
    ) -> Tensor:
        """Draw times of training among the T steps, 1/T, ..., 1, on the generator's device.

        Args:
            n: Number of times.
            generator: Source of chance.
            stratified: True draws one time from each of n equal parts, which takes variance off the
                loss (Kingma et al. 2021, "Variational Diffusion Models").
            small_noise_share: Share of the times at which log sigma is uniform; at the others the
                time is. Uniform times of the cosine schedule have sigma below 0.1 at 6% and below
                0.025 at 1%; times of the first kind at 61% and 37%.
            log_snr: Draws times by their log signal-to-noise ratio instead: mean and spread of a
                normal distribution, and the share of the times that is drawn evenly over the ratio.
        """
        device = generator.device
        if stratified:
            # Shuffled, so that a scene's place in the batch does not fix its part.
            part = torch.randperm(n, generator=generator, device=device)
            share = (part + torch.rand(n, generator=generator, device=device)) / n
        else:
            share = torch.rand(n, generator=generator, device=device)
        n_steps = self.cfg.n_steps
        if log_snr is not None or small_noise_share > 0:
            shares = (
                self._shares_below(small_noise_share)
                if log_snr is None
                else self._shares_by_log_snr(*log_snr)
            )
            below = shares.to(device)
            # Inverse of the cumulative distribution: step whose share reaches the uniform number.
            step = torch.searchsorted(below, share.double(), right=True)
            return (step.clamp(max=n_steps - 1) + 1).to(share) / n_steps
        return ((share * n_steps).floor().clamp(max=n_steps - 1) + 1) / n_steps

    def _shares_below(self, small_noise_share: float) -> Float64[Tensor, " n_steps"]:
        """Cumulative shares of the times 1/T, ..., 1 that mix uniform log sigma with uniform time.

        A step from sigma_a to sigma_b has the weight (sigma_b - sigma_a) / sigma_b, the growth of
        log sigma. The first step has the weight one, because log sigma begins at minus infinity.
        """
        sigma = (-torch.expm1(self.log_alpha_bar)).sqrt()
        weight = sigma.diff() / sigma[1:]
        of_log = weight / weight.sum()
        share = torch.lerp(torch.full_like(of_log, 1 / len(of_log)), of_log, small_noise_share)
        return share.cumsum(0)

    def _shares_by_log_snr(
        self, mean: float, spread: float, even_share: float
    ) -> Float64[Tensor, " n_steps"]:
        """Cumulative shares of the times 1/T, ..., 1, by a normal density over log SNR.

        A share `even_share` of the density is uniform over log SNR.
        """
        log = self.log_alpha_bar[1:]
        ratio = log - torch.log(-torch.expm1(log))
        # The first step has no width of its own, since log SNR at t = 0 is infinite;
        # it takes the next one's.
        width = -torch.cat([ratio[1:2] - ratio[:1], ratio.diff()])
        density = torch.exp(-(((ratio - mean) / spread) ** 2) / 2) * width
        return torch.lerp(density / density.sum(), width / width.sum(), even_share).cumsum(0)

    def forward_noise(
        self,
        x0: Float[Tensor, "batch n channels"],
        time: Float[Tensor, " batch"],
        eps: Float[Tensor, "batch n channels"],
    ) -> Float[Tensor, "batch n channels"]:
        """Return x_t of the forward process in one step.

        Args:
            x0: Clean layout.
            time: Time of each scene, 0 to 1.
            eps: Standard normal noise.

        Source: the paper's q(x_t | x_(t-1)), T times; its algorithm 1, "Generate x_t".
        """
        alpha, sigma = self.signal_and_noise(time)
        return over_tokens(alpha) * x0 + over_tokens(sigma) * eps

    def signal_and_noise(self, time: Float[Tensor, "*batch"]) -> tuple[Tensor, Tensor]:
        """Return sqrt(alpha_bar) and sqrt(1 - alpha_bar) at some times."""
        # In double precision: 1 - alpha_bar cancels near t = 0.
        alpha_bar = self.alpha_bar(time.double())
        return alpha_bar.sqrt().to(time.dtype), (1 - alpha_bar).sqrt().to(time.dtype)


def over_tokens(per_scene: Float[Tensor, " batch"]) -> Float[Tensor, "batch 1 1"]:
    """Reshape a value for each scene, so that it multiplies all of its tokens."""
    return per_scene[:, None, None]


def normal_like(x: Tensor, generator: torch.Generator) -> Tensor:
    """Draw standard normal noise of a tensor's shape, from any device's generator."""
    # Drawn where the generator is, so that a CPU generator gives equal noise for every device.
    noise = torch.randn(x.shape, generator=generator, device=generator.device, dtype=x.dtype)
    return noise.to(x.device)
