"""Initial layout and hierarchy embedding: from the noisy channels of an object to its token."""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn

from aeroscene.learning.model.borders import N_BORDER_FEATURES, border_features
from aeroscene.learning.model.config import N_GEOMETRY, ModelCfg
from aeroscene.learning.model.encoding import TimeEmbedding, fourier_features, sinusoid
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.decode import place_boxes

VALUE_LIMIT = 8.0
"""Channels in their own units are cut here: the noise of a wide channel may ask for anything."""

N_PLACES = 64
"""Places among siblings that are told apart."""


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

    The category is a noisy one-hot vector, so that Emb(c) is a linear map ("soft embedding").
    Where a layout has no category among its channels (an ablation: kinds given), Emb looks the
    kind up instead. The place i is counted among real tokens.
    """

    def __init__(self, cfg: ModelCfg) -> None:
        super().__init__()
        self.width = cfg.width
        self.is_soft = cfg.n_categories > 0
        self.n_geometry = N_GEOMETRY if self.is_soft else cfg.channels
        self.category = (
            nn.Linear(cfg.n_categories, cfg.width, bias=False)
            if self.is_soft
            else nn.Embedding(cfg.n_kinds, cfg.width)
        )
        self.mlp = nn.Sequential(
            nn.Linear(self.n_geometry + cfg.width, cfg.width),
            nn.SiLU(),
            nn.Linear(cfg.width, cfg.width),
        )
        self.domain = nn.Embedding(cfg.n_domains, cfg.width)

    def forward(self, x_t: Float[Tensor, "batch n c"], batch: TokenBatch) -> Embedded:
        """Tokens of a noisy layout."""
        geometry = x_t[..., : self.n_geometry]
        category = self.category(x_t[..., N_GEOMETRY:] if self.is_soft else batch.kind)
        feature = self.mlp(torch.cat([geometry, category], dim=-1))
        place = sinusoid(batch.mask.cumsum(1) - 1, self.width)
        token = feature + place + self.domain(batch.domain).unsqueeze(1)
        return Embedded(feature, token, place)


class TokenEmbedding(nn.Module):
    """Tokens of the default network, h = f + e_pos + e_dom of the paper with the skeleton's part.

    A token knows its noisy channels and its parent's, both also in their own units (shares of the
    free play, log metres), where its borders are, Fourier features of its position, its kind, its
    parent's kind, its depth and its place among its siblings (e_pos: the paper encodes the place in
    a list, which says nothing about a scene). Time, domain (e_dom) and wish modulate every block
    instead.
    """

    place: Float[Tensor, "places w"]
    channel_mean: Float[Tensor, "kinds channels"]
    channel_spread: Float[Tensor, "kinds channels"]
    is_relative: Bool[Tensor, "kinds 3"]
    is_aligned: Bool[Tensor, " kinds"]

    def __init__(self, cfg: ModelCfg) -> None:
        super().__init__()
        self.cfg = cfg
        features = 4 * cfg.channels + 6 * cfg.fourier_bands + 2 * cfg.place_width
        features += N_BORDER_FEATURES * cfg.has_borders
        self.geometry = nn.Linear(features, cfg.width)
        self.kind = nn.Embedding(cfg.n_kinds, cfg.width)
        self.parent_kind = nn.Embedding(cfg.n_kinds, cfg.width)
        self.depth = nn.Embedding(cfg.max_depth + 1, cfg.width)
        self.time = TimeEmbedding(cfg.width)
        self.domain = nn.Embedding(cfg.n_domains, cfg.width)
        self.wish = nn.Linear(3, cfg.width)
        place = sinusoid(torch.arange(N_PLACES), cfg.place_width)
        self.register_buffer("place", place, persistent=False)
        self.register_buffer("channel_mean", torch.zeros(cfg.n_kinds, cfg.channels))
        self.register_buffer("channel_spread", torch.ones(cfg.n_kinds, cfg.channels))
        self.register_buffer("is_relative", torch.zeros(cfg.n_kinds, 3, dtype=torch.bool))
        self.register_buffer("is_aligned", torch.zeros(cfg.n_kinds, dtype=torch.bool))

    def forward(
        self, x_t: Float[Tensor, "batch n channels"], batch: TokenBatch
    ) -> Float[Tensor, "batch n d"]:
        """Tokens of noisy objects."""
        parent = batch.parent.unsqueeze(-1)
        x_parent = x_t.gather(1, parent.expand_as(x_t))
        parent_kind = batch.kind.gather(1, batch.parent)
        value = self.own_units(x_t, batch.kind)
        borders = [self._borders(value, batch)] if self.cfg.has_borders else []
        feature = torch.cat(
            [
                *borders,
                x_t,
                x_parent,
                value,
                self.own_units(x_parent, parent_kind),
                fourier_features(value[..., :3], self.cfg.fourier_bands),
                self.place[batch.ordinal],
                self.place[batch.twin],
            ],
            dim=-1,
        )
        depth = batch.depth.clamp(max=self.cfg.max_depth)
        return (
            self.geometry(feature)
            + self.kind(batch.kind)
            + self.parent_kind(parent_kind)
            + self.depth(depth)
        )

    def condition(self, t: Float[Tensor, " batch"], batch: TokenBatch) -> Float[Tensor, "batch d"]:
        """Condition that modulates the blocks: time, domain and wish of each scene."""
        total = self.time(t) + self.domain(batch.domain) + self.wish(batch.wish)
        return nn.functional.silu(total)

    def use_statistics(
        self,
        mean: Float[Tensor, "kinds channels"],
        spread: Float[Tensor, "kinds channels"],
        is_relative: Bool[Tensor, "kinds 3"],
        is_aligned: Bool[Tensor, " kinds"],
    ) -> None:
        """Tell how the channels of each kind are read.

        The spread of a constant channel is 0; extents that are relative are ratios to the parent's;
        aligned kinds stand square to their parents.
        """
        self.channel_mean.copy_(mean)
        self.channel_spread.copy_(spread)
        self.is_relative.copy_(is_relative)
        self.is_aligned.copy_(is_aligned)

    @torch.no_grad()
    def _borders(
        self, value: Float[Tensor, "batch n channels"], batch: TokenBatch
    ) -> Float[Tensor, "batch n f"]:
        kind = batch.kind
        return border_features(
            place_boxes(value, self.is_relative[kind], self.is_aligned[kind], batch), batch
        )

    def own_units(
        self, x: Float[Tensor, "batch n channels"], kind: Int[Tensor, "batch n"]
    ) -> Float[Tensor, "batch n channels"]:
        """Channels before standardisation: shares of the free play, log metres, metres."""
        value = torch.addcmul(self.channel_mean[kind], self.channel_spread[kind], x)
        return value.clamp(-VALUE_LIMIT, VALUE_LIMIT)
