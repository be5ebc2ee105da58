"""Mixtures of logistic distributions of one number each, as ATISS predicts attributes by.

    P(x in bin) = sum over k of w_k (s((x + h - m_k) / e^l_k) - s((x - h - m_k) / e^l_k))

| symbol | name |
|---|---|
| w_k, m_k, l_k | weight, mean and log scale of component k |
| h | half a bin |
| s | the logistic function |

Source: Salimans et al. 2017, "PixelCNN++", section 2.1, as in Paschalidou et al. 2021, section 3.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor

N_COMPONENTS = 10
HALF_BIN = 0.002
"""Of values of order one."""
_LEAST_LOG_SCALE = -7.0
_LEAST_SHARE = 1e-9


def mixture_loss(
    parameters: Float[Tensor, "*n c 30"], values: Float[Tensor, "*n c"]
) -> Float[Tensor, "*n"]:
    """Negative log-likelihood of values, summed over their last axis."""
    weight, mean, log_scale = parameters.chunk(3, dim=-1)
    scale = log_scale.clamp(min=_LEAST_LOG_SCALE).exp()
    away = values.unsqueeze(-1) - mean
    share = torch.sigmoid((away + HALF_BIN) / scale) - torch.sigmoid((away - HALF_BIN) / scale)
    log_share = share.clamp(min=_LEAST_SHARE).log()
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
