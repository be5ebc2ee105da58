"""Mixtures of logistic distributions of one number each, ATISS's prediction of attributes.

    P(x in bin) = sum over k of w_k (s((x + h - m_k) / e^l_k) - s((x - h - m_k) / e^l_k))

    symbol         name
    w_k, m_k, l_k  weight, mean and log scale of component k
    h              half a bin
    s              the logistic function

The code computes s(a) - s(b) as s(a) s(-b) (1 - e^(b - a)). The difference itself rounds to zero
some sixteen scales away from the mean, and then no gradient would pull a component nearer.

Source: Salimans et al. 2017, "PixelCNN++", section 2.1, as in Paschalidou et al. 2021, section 3.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

N_COMPONENTS = 10
HALF_BIN = 0.016
"""Half of the width of a bin: 256 bins from -4 to 4, as many as ATISS has."""
_LEAST_LOG_SCALE = -5.6
"""Least log scale. ATISS has -7 for values from -1 to 1."""
# Log scale of all components before training.
_FIRST_LOG_SCALE = -1.0


def spread_means(layer: nn.Linear, reach: float) -> None:
    """Spread the means of untrained mixtures evenly from -reach to reach.

    Components that begin alike are separated by training alone, which takes long.

    Args:
        layer: Last layer of a head; its bias is changed.
        reach: Greatest mean.
    """
    with torch.no_grad():
        _, mean, log_scale = layer.bias.unflatten(0, (-1, 3, N_COMPONENTS)).unbind(1)
        mean.copy_(torch.linspace(-reach, reach, N_COMPONENTS).expand_as(mean))
        log_scale.fill_(_FIRST_LOG_SCALE)


def mixture_loss(
    parameters: Float[Tensor, "*n c 30"], values: Float[Tensor, "*n c"]
) -> Float[Tensor, "*n"]:
    """Negative log-likelihood of values, summed over their last axis, in nats.

    Args:
        parameters: Weights, means and log scales of the components of each number.
        values: The observed numbers.
    """
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
    """Draw one value from each mixture.

    A component is drawn first, then a value by the inverse of its logistic function.
    """
    weight, mean, log_scale = parameters.chunk(3, dim=-1)
    pick = torch.multinomial(weight.softmax(dim=-1), 1, generator=generator)
    scale = log_scale.clamp(min=_LEAST_LOG_SCALE).exp().gather(1, pick).squeeze(1)
    # At 0 and 1 the inverse is infinite.
    uniform = torch.rand(len(mean), generator=generator, device=mean.device).clamp(1e-5, 1 - 1e-5)
    return mean.gather(1, pick).squeeze(1) + scale * torch.logit(uniform)
