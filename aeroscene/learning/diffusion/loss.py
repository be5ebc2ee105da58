"""The training loss: reconstruction, guidance and supervision of the gate.

A random time is drawn for each scene, its layout is noised to that time, and the network's
prediction is compared with the known truth. The reconstruction is the paper's L_rec, the guidance
its L_guide. The third term is ours: the paper's hard threshold gives the gate no gradient, so the
gate learns from the known level of each token.

Source: the paper's algorithm 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import binary_cross_entropy

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import LossCfg
from aeroscene.learning.diffusion.parameterisation import (
    min_snr_weight,
    predicted_x0,
    prediction_target,
)
from aeroscene.learning.diffusion.schedule import Schedule, normal_like

_MOST_WEIGHT = 50.0
"""Cap of 1 / alpha_bar, which grows without bound as the layout vanishes in noise."""
_GATE_MARGIN = 1e-6
"""Distance of a score from 0 and 1 that keeps its logarithm finite."""


class Prediction(NamedTuple):
    """Prediction of a denoiser for a noisy layout."""

    output: Float[Tensor, "batch n channels"]
    """Noise, velocity or clean layout, as the parameterisation says; zero at padding."""
    tokenizability: Float[Tensor, "batch n"] | None = None
    """The paper's tau of each token, 0 to 1, and 0 at padding; None if the routing is given."""


Denoiser = Callable[[Tensor, Tensor, TokenBatch], Prediction]
"""Network as `model(x_t, t, batch)`; t is the time of each scene, 0 clean to 1 noise."""
GuidanceLoss = Callable[[Tensor, TokenBatch], Float[Tensor, " batch"]]
"""The paper's L_guide of layouts, one value for each scene."""


@dataclass(frozen=True)
class LossTerms:
    """The loss and its parts, all scalars. The parts are not yet weighted."""

    total: Float[Tensor, ""]
    reconstruction: Float[Tensor, ""]
    guide: Float[Tensor, ""]
    gate: Float[Tensor, ""]


def diffusion_loss(
    model: Denoiser,
    batch: TokenBatch,
    schedule: Schedule,
    cfg: LossCfg,
    generator: torch.Generator,
    guide: GuidanceLoss | None = None,
) -> LossTerms:
    """Compute the loss of a batch at random times.

    Args:
        model: The network.
        batch: Layouts with `x0`. Channels of weight 0 are held at 0, as they are in `sample`.
        schedule: Noise schedule.
        cfg: Settings of the loss.
        generator: Source of times and noise.
        guide: L_guide, evaluated on the predicted x0; the paper leaves open on which layout. It is
            weighted by alpha_bar, because at large t that prediction is a blur of all layouts. It
            is divided by the number of channels, because L_rec is a mean here and a sum in the
            paper.

    Raises:
        ValueError: If the batch has no `x0` or no `weight`.

    Source: the paper's algorithm 1, L = L_rec + lambda_guide L_guide.
    """
    if batch.x0 is None:
        raise ValueError("batch.x0 is None; valid: the clean layouts to be learned")
    weight = channel_weight(batch)
    # Channels without a weight get neither signal nor noise, so the network sees 0 there at every
    # time, as in sampling.
    is_free = weight > 0
    x0 = batch.x0 * is_free
    time = schedule.draw_time(
        len(x0),
        generator,
        stratified=cfg.is_stratified,
        small_noise_share=cfg.small_noise_share,
        log_snr=None
        if cfg.log_snr_mean is None
        else (cfg.log_snr_mean, cfg.log_snr_spread, cfg.log_snr_even_share),
    ).to(x0)
    eps = normal_like(x0, generator) * is_free
    x_t = schedule.forward_noise(x0, time, eps)
    alpha, sigma = schedule.signal_and_noise(time)
    prediction = model(x_t, time, batch)
    target = prediction_target(cfg.parameterisation, x0, eps, alpha, sigma)
    counts = _with_coarse_weight(weight, batch.n_coarse_slots, cfg.coarse_weight)
    reconstruction = _weighted_error(prediction.output - target, counts, alpha, sigma, cfg)
    zero = reconstruction.new_zeros(())
    guide_loss, gate_loss = zero, zero
    if guide is not None and cfg.guide_weight > 0:
        x0_hat = predicted_x0(cfg.parameterisation, prediction.output, x_t, alpha, sigma)
        # Times are random, so the first scenes of a batch are a fair sample of it.
        some = slice(cfg.guide_scenes)
        per_scene = guide((x0_hat * is_free)[some], batch.scenes(some))
        n_channels = weight[some].sum((1, 2)).clamp(min=1)
        guide_loss = (alpha[some] ** 2 * per_scene / n_channels).mean()
    if prediction.tokenizability is not None and cfg.gate_weight > 0:
        gate_loss = gate_cross_entropy(prediction.tokenizability, batch)
    total = reconstruction + cfg.guide_weight * guide_loss + cfg.gate_weight * gate_loss
    return LossTerms(total, reconstruction, guide_loss, gate_loss)


def _with_coarse_weight(weight: Tensor, n_coarse: int, factor: float) -> Tensor:
    return torch.cat([factor * weight[:, :n_coarse], weight[:, n_coarse:]], dim=1)


def _weighted_error(
    error: Tensor, weight: Tensor, alpha: Tensor, sigma: Tensor, cfg: LossCfg
) -> Float[Tensor, ""]:
    """Weighted mean of the squared errors, over channels of all scenes together."""
    squared = (error.float() ** 2 * weight).sum((1, 2))
    if cfg.min_snr_gamma is not None:
        squared = squared * min_snr_weight(cfg.parameterisation, alpha, sigma, cfg.min_snr_gamma)
    if cfg.weighting == "velocity":
        squared = squared * (alpha**-2).clamp(max=_MOST_WEIGHT)
    # Divided by the weight of the whole batch: large scenes count more than small ones.
    return squared.sum() / weight.sum().clamp(min=1)


def channel_weight(batch: TokenBatch) -> Float[Tensor, "batch n channels"]:
    """Return the weights of a batch's channels.

    Raises:
        ValueError: If it has none.
    """
    if batch.weight is None:
        raise ValueError("batch.weight is None; valid: a weight for every channel of every token")
    return batch.weight


def gate_cross_entropy(
    tokenizability: Float[Tensor, "batch n"], batch: TokenBatch
) -> Float[Tensor, ""]:
    """Cross-entropy of tau with the known level: 0 for coarse tokens, 1 for fine ones.

    The paper sends tokens with tau below gamma to the coarse branch (its eq. coarseFineCheck).
    """
    slot = torch.arange(batch.mask.shape[1], device=batch.mask.device)
    is_fine = (slot >= batch.n_coarse_slots).expand_as(batch.mask)
    score = tokenizability.float().clamp(_GATE_MARGIN, 1 - _GATE_MARGIN)
    loss = binary_cross_entropy(score, is_fine.to(score), reduction="none")
    return (loss * batch.mask).sum() / batch.mask.sum().clamp(min=1)
