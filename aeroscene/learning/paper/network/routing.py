"""Tokenizability, and the gate that sends tokens to the coarse or to the fine branch.

    symbol           name                                               range
    f^(0)            features of a token before position and domain     -
    tau              tokenizability: sigma(w^T MLP(f^(0)))              [0, 1]
    gamma            learned threshold                                  [0, 1]
    T_coarse, T_fine tokens with tau < gamma, and with tau >= gamma     -

The paper routes by a hard comparison of tau with gamma. See `LearnedRouting` for its gradient.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn

from aeroscene.learning.batch import TokenBatch

GATE_TEMPERATURE = 0.1
"""Width of the soft gate in units of tau, whose gradient replaces that of the hard gate."""


class Routes(NamedTuple):
    """The branch of each token; padding takes none."""

    is_coarse: Bool[Tensor, "batch n"]
    is_fine: Bool[Tensor, "batch n"]
    coarse_weight: Float[Tensor, "batch n 1"]
    """1 for coarse tokens and 0 for others, with the gradient of the soft gate."""
    fine_weight: Float[Tensor, "batch n 1"]
    tokenizability: Float[Tensor, "batch n"] | None
    """tau; None if the routes were given."""


class LearnedRouting(nn.Module):
    """The paper's gate: tau against a learned scalar gamma.

    A hard comparison has no gradient, so that the paper's gamma, "optimized jointly", could not
    move. The forward pass compares as the paper says; the backward pass is that of
    sigma((tau - gamma) / `GATE_TEMPERATURE`) (straight-through, Bengio et al. 2013). The known
    level of the categories supervises tau in the loss.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.mlp = nn.Sequential(nn.Linear(width, width), nn.SiLU(), nn.Linear(width, width))
        self.w_tau = nn.Linear(width, 1, bias=False)
        self.gamma = nn.Parameter(torch.tensor(0.5))

    def forward(self, feature: Float[Tensor, "batch n d"], real: Bool[Tensor, "batch n"]) -> Routes:
        """Route tokens by their features f^(0)."""
        tau = torch.sigmoid(self.w_tau(self.mlp(feature)).squeeze(-1)).float()
        is_fine = tau >= self.gamma
        soft = torch.sigmoid((tau - self.gamma) / GATE_TEMPERATURE)
        # The value is the hard gate; the gradient is the soft one's.
        gate = (is_fine.to(soft.dtype) - soft.detach() + soft).unsqueeze(-1)
        there = real.unsqueeze(-1)
        return Routes(~is_fine & real, is_fine & real, (1 - gate) * there, gate * there, tau * real)


def given_routes(batch: TokenBatch) -> Routes:
    """Route tokens by the slots of a batch, which knows its coarse tokens."""
    slot = torch.arange(batch.mask.shape[1], device=batch.mask.device)
    is_coarse = batch.mask & (slot < batch.n_coarse_slots)
    is_fine = batch.mask & ~is_coarse
    return Routes(
        is_coarse=is_coarse,
        is_fine=is_fine,
        coarse_weight=is_coarse.to(torch.float32).unsqueeze(-1),
        fine_weight=is_fine.to(torch.float32).unsqueeze(-1),
        tokenizability=None,
    )
