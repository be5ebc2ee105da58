"""Quantities that a network may predict: the noise (the paper), the velocity or the clean layout.

All three carry the same information; they differ in which errors the training weighs. Near t = 1
dividing by sqrt(alpha_bar) magnifies an error of the noise, which the velocity avoids.
"""

from __future__ import annotations

from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.diffusion.config import Parameterisation
from aeroscene.learning.diffusion.schedule import over_tokens

_LEAST_ALPHA = 1e-4
"""Below this value, dividing by sqrt(alpha_bar) gives no information about x0."""


def prediction_target(
    kind: Parameterisation,
    x0: Float[Tensor, "batch n channels"],
    eps: Float[Tensor, "batch n channels"],
    alpha: Float[Tensor, " batch"],
    sigma: Float[Tensor, " batch"],
) -> Float[Tensor, "batch n channels"]:
    """Return the quantity that the network should predict.

    Args:
        kind: Which quantity.
        x0: Clean layout.
        eps: The noise in x_t.
        alpha: sqrt(alpha_bar) of each scene.
        sigma: sqrt(1 - alpha_bar) of each scene.

    Source: eps as in the paper's L_rec; v from Salimans and Ho 2022.
    """
    if kind == "eps":
        return eps
    if kind == "x0":
        return x0
    return over_tokens(alpha) * eps - over_tokens(sigma) * x0


def predicted_x0(
    kind: Parameterisation,
    output: Float[Tensor, "batch n channels"],
    x_t: Float[Tensor, "batch n channels"],
    alpha: Float[Tensor, " batch"],
    sigma: Float[Tensor, " batch"],
) -> Float[Tensor, "batch n channels"]:
    """Return the clean layout that a network's output stands for.

    Args:
        kind: Which quantity the output is.
        output: The network's output.
        x_t: The noisy layout that it read.
        alpha: sqrt(alpha_bar) of each scene.
        sigma: sqrt(1 - alpha_bar) of each scene.
    """
    if kind == "x0":
        return output
    if kind == "v":
        return over_tokens(alpha) * x_t - over_tokens(sigma) * output
    # From x_t = alpha x0 + sigma eps; for the velocity the inverse is a rotation by the same angle.
    return (x_t - over_tokens(sigma) * output) / over_tokens(alpha.clamp(min=_LEAST_ALPHA))


def min_snr_weight(
    kind: Parameterisation,
    alpha: Float[Tensor, " batch"],
    sigma: Float[Tensor, " batch"],
    gamma: float,
) -> Float[Tensor, " batch"]:
    """Weight of a scene's squared error so that x0's error counts min(SNR, gamma) times.

    Source: Hang et al. 2023, "Efficient Diffusion Training via Min-SNR Weighting Strategy", 3.4.
    """
    snr = (alpha / sigma.clamp(min=_LEAST_ALPHA)) ** 2
    of_x0 = snr.clamp(max=gamma)
    if kind == "x0":
        return of_x0
    # An error of eps is SNR times as large in x0, one of v SNR + 1 times.
    return of_x0 / (snr if kind == "eps" else snr + 1)
