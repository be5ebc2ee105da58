"""Mixtures of logistic distributions of one number each, as ATISS predicts attributes by.

    P(x in bin) = sum over k of w_k (s((x + h - m_k) / e^l_k) - s((x - h - m_k) / e^l_k))

| symbol | name |
|---|---|
| w_k, m_k, l_k | weight, mean and log scale of component k |
| h | half a bin |
| s | the logistic function |

Computed as s(a) - s(b) = s(a) s(-b) (1 - e^(b - a)): the difference itself is rounded to nothing
some sixteen scales away from the mean, where nothing would then pull a component nearer.

Source: Salimans et al. 2017, "PixelCNN++", section 2.1, as in Paschalidou et al. 2021, section 3.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

N_COMPONENTS = 10
HALF_BIN = 0.016
"""Of values that reach from -4 to 4: 256 bins, as ATISS has them."""
_LEAST_LOG_SCALE = -5.6
"""ATISS: -7 of values from -1 to 1."""
_FIRST_LOG_SCALE = -1.0


def spread_means(layer: nn.Linear, reach: float) -> None:
    """Have the components of untrained mixtures stand side by side from -reach to reach.

    Components that begin alike are told apart by training alone, which takes it long.
    """
    with torch.no_grad():
        _, mean, log_scale = layer.bias.unflatten(0, (-1, 3, N_COMPONENTS)).unbind(1)
        mean.copy_(torch.linspace(-reach, reach, N_COMPONENTS).expand_as(mean))
        log_scale.fill_(_FIRST_LOG_SCALE)


def mixture_loss(
    parameters: Float[Tensor, "*n c 30"], values: Float[Tensor, "*n c"]
) -> Float[Tensor, "*n"]:
    """Negative log-likelihood of values, summed over their last axis."""
    weight, mean, log_scale = parameters.chunk(3, dim=-1)
    scale = log_scale.clamp(min=_LEAST_LOG_SCALE).exp()
    away = values.unsqueeze(-1) - mean
    log_share = (
        functional.logsigmoid((away + HALF_BIN) / scale)
        + functional.logsigmoid((HALF_BIN - away) / scale)
        + torch.expm1(-2 * HALF_BIN / scale).neg().log()
    )
    return -torch.logsumexp(torch.log_softmax(weight, dim=-1) + log_share, dim=-1).sum(-1)


def draw_mixture(
    parameters: Float[Tensor, "c 30"], generator: torch.Generator
) -> Float[Tensor, " c"]:
    """Values drawn, one for each of the mixtures."""
    weight, mean, log_scale = parameters.chunk(3, dim=-1)
    pick = torch.multinomial(weight.softmax(dim=-1), 1, generator=generator)
    scale = log_scale.clamp(min=_LEAST_LOG_SCALE).exp().gather(1, pick).squeeze(1)
    uniform = torch.rand(len(mean), generator=generator, device=mean.device).clamp(1e-5, 1 - 1e-5)
    return mean.gather(1, pick).squeeze(1) + scale * torch.logit(uniform)
