"""Tokens of programs for the network that denoises their channels."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.encoding import TimeEmbedding, fourier_features, sinusoid
from aeroscene.learning.program.program import N_HOSTS, N_MEMBERS

VALUE_LIMIT = 8.0
"""Channels in their own units are cut here: the noise of a wide channel may ask for anything."""
N_PLACES = 64
"""Places among siblings that are told apart."""


class ProgramEmbedding(nn.Module):
    """A token's noisy channels and its parent's, standardised and in their own units, and its kind.

    Kinds that are rare share what is known of their traits. Time, domain and wish modulate every
    block instead.
    """

    place: Float[Tensor, "places w"]
    traits: Bool[Tensor, "kinds traits"]
    channel_mean: Float[Tensor, "kinds channels"]
    channel_spread: Float[Tensor, "kinds channels"]

    def __init__(self, cfg: ModelCfg, traits: Bool[Tensor, "kinds traits"], n_shapes: int) -> None:
        super().__init__()
        self.cfg = cfg
        features = 4 * cfg.channels + 6 * cfg.fourier_bands + 2 * cfg.place_width
        self.geometry = nn.Linear(features, cfg.width)
        self.own = nn.Parameter(0.1 * torch.randn(len(traits), cfg.width))
        self.shared = nn.Parameter(0.1 * torch.randn(traits.shape[1], cfg.width))
        self.parent_kind = nn.Linear(cfg.width, cfg.width)
        self.extra = nn.ModuleList(
            nn.Embedding(size, cfg.width) for size in (N_MEMBERS, N_HOSTS, n_shapes)
        )
        self.depth = nn.Embedding(cfg.max_depth + 1, cfg.width)
        self.time = TimeEmbedding(cfg.width)
        self.domain = nn.Embedding(cfg.n_domains, cfg.width)
        self.wish = nn.Linear(3, cfg.width)
        place = sinusoid(torch.arange(N_PLACES), cfg.place_width)
        self.register_buffer("place", place, persistent=False)
        self.register_buffer("traits", traits, persistent=False)
        zeros = torch.zeros(len(traits), cfg.channels)
        self.register_buffer("channel_mean", zeros, persistent=False)
        self.register_buffer("channel_spread", torch.ones_like(zeros), persistent=False)

    def use_statistics(
        self,
        mean: Float[Tensor, "kinds channels"],
        spread: Float[Tensor, "kinds channels"],
    ) -> None:
        """Tell how the channels of each kind are read."""
        self.channel_mean = mean.to(self.channel_mean)
        self.channel_spread = spread.to(self.channel_spread)

    def forward(
        self, x_t: Float[Tensor, "batch n channels"], batch: TokenBatch
    ) -> Float[Tensor, "batch n d"]:
        """Tokens of noisy programs."""
        assert batch.extra is not None
        parent = batch.parent.unsqueeze(-1)
        kind = self.own[batch.kind] + self.traits[batch.kind].to(self.own.dtype) @ self.shared
        mean, spread = self.channel_mean[batch.kind], self.channel_spread[batch.kind]
        value = torch.addcmul(mean, spread, x_t).clamp(-VALUE_LIMIT, VALUE_LIMIT)
        feature = torch.cat(
            [
                x_t,
                x_t.gather(1, parent.expand_as(x_t)),
                value,
                value.gather(1, parent.expand_as(value)),
                fourier_features(value[..., :3], self.cfg.fourier_bands),
                self.place[batch.ordinal],
                self.place[batch.twin],
            ],
            dim=-1,
        )
        token = self.geometry(feature) + kind
        token = token + self.parent_kind(kind.gather(1, parent.expand_as(kind)))
        for column, numbers in enumerate(self.extra):
            token = token + numbers(batch.extra[..., column])
        return token + self.depth(batch.depth.clamp(max=self.cfg.max_depth))

    def condition(self, t: Float[Tensor, " batch"], batch: TokenBatch) -> Float[Tensor, "batch d"]:
        """Condition that modulates the blocks: time, domain and wish of each scene."""
        total = self.time(t) + self.domain(batch.domain) + self.wish(batch.wish)
        return nn.functional.silu(total)
