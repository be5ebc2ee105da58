"""Initial layout and hierarchy embedding: from the noisy channels of an object to its token."""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from aeroscene.learning.model.config import N_GEOMETRY, ModelCfg
from aeroscene.learning.model.encoding import sinusoid
from aeroscene.learning.tokens.batch import TokenBatch


class Embedded(NamedTuple):
    """The paper's token and what it is the sum of."""

    feature: Float[Tensor, "batch n d"]
    """f^(0), geometry and semantics alone: the routing reads it."""
    token: Float[Tensor, "batch n d"]
    """h = f^(0) + e_pos + e_dom."""
    place: Float[Tensor, "batch n d"]
    """e_pos."""


class LayoutEmbedding(nn.Module):
    """The paper's h_i = f_i^(0) + e_i^pos + e_i^dom with f_i^(0) = MLP([p, q, s, Emb(c)]).

    The category is a noisy one-hot vector, so that Emb(c) is a linear map ("soft embedding"). The
    place i is counted among real tokens.
    """

    def __init__(self, cfg: ModelCfg) -> None:
        super().__init__()
        self.width = cfg.width
        self.category = nn.Linear(cfg.n_categories, cfg.width, bias=False)
        self.mlp = nn.Sequential(
            nn.Linear(N_GEOMETRY + cfg.width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.width),
        )
        self.domain = nn.Embedding(cfg.n_domains, cfg.width)

    def forward(self, x_t: Float[Tensor, "batch n c"], batch: TokenBatch) -> Embedded:
        """Tokens of a noisy layout."""
        category = self.category(x_t[..., N_GEOMETRY:])
        feature = self.mlp(torch.cat([x_t[..., :N_GEOMETRY], category], dim=-1))
        place = sinusoid(batch.mask.cumsum(1) - 1, self.width)
        token = feature + place + self.domain(batch.domain).unsqueeze(1)
        return Embedded(feature, token, place)
