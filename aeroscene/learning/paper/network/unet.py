"""The UNet denoiser over the list of tokens, conditioned by cross-attention on F_attn."""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.paper.network.attention import MaskedAttention

STRIDE = 2
"""A level of the UNet has this many times fewer places than the one above."""


class Condition(NamedTuple):
    """What every level of the UNet reads."""

    time: Float[Tensor, "batch d"]
    feature: Float[Tensor, "batch n d"]
    """F_attn, the keys and values of the cross-attention."""
    is_token: Bool[Tensor, "batch 1 n"]


class ResidualBlock(nn.Module):
    """Two convolutions along the list, time added between them, then cross-attention.

    Normalisation is over the channels of a place (LayerNorm), not over a group of places as in
    image UNets: there padding would leak into the statistics.
    """

    def __init__(self, inward: int, width: int, condition: int, heads: int) -> None:
        super().__init__()
        self.first_norm = nn.LayerNorm(inward)
        self.first = nn.Conv1d(inward, width, 3, padding=1)
        self.time = nn.Linear(condition, width)
        self.second_norm = nn.LayerNorm(width)
        self.second = nn.Conv1d(width, width, 3, padding=1)
        self.skip = nn.Linear(inward, width) if inward != width else nn.Identity()
        self.attention = MaskedAttention(width, heads, condition)

    def forward(
        self,
        place: Float[Tensor, "batch n c"],
        real: Float[Tensor, "batch n 1"],
        condition: Condition,
    ) -> Float[Tensor, "batch n w"]:
        """Update the places of a level; padded ones stay zero."""
        inner = _along(self.first, functional.silu(self.first_norm(place)) * real)
        inner = inner + self.time(condition.time).unsqueeze(1)
        inner = _along(self.second, functional.silu(self.second_norm(inner)) * real)
        place = (self.skip(place) + inner) * real
        return self.attention(place, condition.feature, condition.is_token) * real


class TokenUnet(nn.Module):
    """1-D UNet: levels of `ResidualBlock`s, halved by strided convolutions, doubled by repetition.

    `condition` is the width of time and of F_attn; `widths` are those of the levels, finest first.
    """

    def __init__(self, channels: int, condition: int, widths: tuple[int, ...], heads: int) -> None:
        super().__init__()
        self.inward = nn.Linear(channels, widths[0])
        above = (widths[0], *widths[:-1])
        self.down = nn.ModuleList(
            ResidualBlock(a, w, condition, heads) for a, w in zip(above, widths, strict=True)
        )
        self.halve = nn.ModuleList(nn.Conv1d(w, w, STRIDE, stride=STRIDE) for w in widths[:-1])
        self.middle = ResidualBlock(widths[-1], widths[-1], condition, heads)
        below = (widths[-1], *reversed(widths[1:]))
        self.up = nn.ModuleList(
            ResidualBlock(b + w, w, condition, heads)
            for b, w in zip(below, reversed(widths), strict=True)
        )
        self.norm = nn.LayerNorm(widths[0])
        self.outward = nn.Linear(widths[0], channels)
        nn.init.zeros_(self.outward.weight)
        nn.init.zeros_(self.outward.bias)

    def forward(
        self,
        x_t: Float[Tensor, "batch n c"],
        position: Float[Tensor, "batch n w"],
        mask: Bool[Tensor, "batch n"],
        condition: Condition,
    ) -> Float[Tensor, "batch n c"]:
        """Predict from a list whose real tokens stand at its front.

        By the positional encoding e_pos places find their own feature.
        """
        n = x_t.shape[1]
        filler = -n % STRIDE ** len(self.halve)
        place = functional.pad(
            (self.inward(x_t) + position) * mask.unsqueeze(-1), (0, 0, 0, filler)
        )
        reals = [functional.pad(mask, (0, filler)).unsqueeze(-1).to(place.dtype)]
        kept = []
        for level, block in enumerate(self.down):
            place = block(place, reals[level], condition)
            kept.append(place)
            if level < len(self.halve):
                reals.append(reals[level][:, ::STRIDE])
                place = _along(self.halve[level], place) * reals[-1]
        place = self.middle(place, reals[-1], condition)
        for block, real, skip in zip(self.up, reversed(reals), reversed(kept), strict=True):
            if place.shape[1] != skip.shape[1]:
                place = place.repeat_interleave(STRIDE, dim=1)
            place = block(torch.cat([place, skip], -1) * real, real, condition)
        return self.outward(functional.silu(self.norm(place)))[:, :n]


def _along(layer: nn.Module, place: Float[Tensor, "batch n c"]) -> Float[Tensor, "batch m w"]:
    return layer(place.transpose(1, 2)).transpose(1, 2)
