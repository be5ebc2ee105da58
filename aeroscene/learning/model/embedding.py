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
"""Channels in their own units are clipped here, because the noise of a wide channel has no
bound."""
N_PLACES = 64
"""Number of places among siblings with a vector of their own; `MOST_SIBLINGS` is the last."""


class ProgramEmbedding(nn.Module):
    """Embeds each token: its noisy channels, its parent's, and its kind.

    Channels come both standardised and in their own units. Rare kinds share learned vectors of
    their traits, so that few examples suffice. Time, domain and wish are no part of a token; they
    modulate every block instead.

    Args:
        cfg: Shape of the network.
        traits: Traits of each kind.
        n_shapes: Number of arrays in the vocabulary.
    """

    place: Float[Tensor, "places w"]
    traits: Bool[Tensor, "kinds traits"]
    channel_mean: Float[Tensor, "kinds channels"]
    channel_spread: Float[Tensor, "kinds channels"]

    def __init__(self, cfg: ModelCfg, traits: Bool[Tensor, "kinds traits"], n_shapes: int) -> None:
        super().__init__()
        self.cfg = cfg
        # Own and parent's channels, each in two forms; sines and cosines of
        # three numbers; two places.
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
        # Buffers follow the module to its device. They are not saved: vocabulary and
        # statistics restore them.
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
        """Set mean and spread of the channels of each kind, which bring them to their own units."""
        self.channel_mean = mean.to(self.channel_mean)
        self.channel_spread = spread.to(self.channel_spread)

    def forward(
        self, x_t: Float[Tensor, "batch n channels"], batch: TokenBatch
    ) -> Float[Tensor, "batch n d"]:
        """Embed noisy programs.

        Args:
            x_t: Noisy standardised channels.
            batch: Tokens with `extra`; its parents, places and kinds are read.
        """
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
                # Waves of the first three channels, which hold most of a token's place, resolve
                # small differences.
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
        """Return the condition that modulates the blocks: time, domain and wish of each scene."""
        total = self.time(t) + self.domain(batch.domain) + self.wish(batch.wish)
        return nn.functional.silu(total)
