"""The UNet denoiser over the list of tokens, conditioned by cross-attention on F_attn."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.paper.network.attention import MaskedAttention


@dataclass(frozen=True)
class Condition:
    """Input of every level of the UNet beside the places."""

    time: Float[Tensor, "batch n d"]
    """Time and domain of each token; given tokens have the time without noise."""
    feature: Float[Tensor, "batch n d"]
    """F_attn, the keys and values of the cross-attention."""
    is_token: Bool[Tensor, "batch 1 n"]
    """True for real tokens, which may be keys."""
    nearness: Float[Tensor, "batch heads n n"]
    """Bias of the self-attention."""


class ResidualBlock(nn.Module):
    """Two pointwise convolutions along the list with time between them, then attention.

    Self-attention among the places comes first, as diffusion UNets have it, then the paper's
    cross-attention on F_attn. A list of objects has no neighbours along it, so a wider kernel or a
    stride would mix strangers.
    """

    def __init__(self, inward: int, width: int, condition: int, heads: int) -> None:
        super().__init__()
        self.first_norm = nn.LayerNorm(inward)
        self.first = nn.Linear(inward, width)
        self.time = nn.Linear(condition, 2 * width)
        self.second_norm = nn.LayerNorm(width)
        self.second = nn.Linear(width, width)
        self.skip = nn.Linear(inward, width) if inward != width else nn.Identity()
        self.within = MaskedAttention(width, heads)
        self.across = MaskedAttention(width, heads, condition)

    def forward(
        self, place: Float[Tensor, "batch n c"], condition: Condition
    ) -> Float[Tensor, "batch n w"]:
        """Update the places of a level."""
        scale, shift = self.time(condition.time).chunk(2, dim=-1)
        inner = self.first(functional.silu(self.first_norm(place)))
        inner = self.second_norm(inner) * (1 + scale) + shift
        # The sum of all blocks stays in single precision, even if matrix products use bfloat16.
        place = self.skip(place).float() + self.second(functional.silu(inner))
        place = self.within(place, place, condition.is_token, bias=condition.nearness)
        return self.across(place, condition.feature, condition.is_token)


class TokenUnet(nn.Module):
    """1-D UNet: levels of `ResidualBlock`s inward, one in the middle, as many outward.

    Each level on the way out reads the result of its counterpart on the way in.

    Args:
        inward: Width of an input place.
        channels: Width of an output place.
        condition: Width of time and of F_attn.
        widths: Widths of the levels, outermost first.
        heads: Attention heads; they divide every width.
    """

    def __init__(
        self, inward: int, channels: int, condition: int, widths: tuple[int, ...], heads: int
    ) -> None:
        super().__init__()
        self.inward = nn.Linear(inward, widths[0])
        above = (widths[0], *widths[:-1])
        self.down = nn.ModuleList(
            ResidualBlock(a, w, condition, heads) for a, w in zip(above, widths, strict=True)
        )
        self.middle = ResidualBlock(widths[-1], widths[-1], condition, heads)
        below = (widths[-1], *reversed(widths[1:]))
        self.up = nn.ModuleList(
            ResidualBlock(b + w, w, condition, heads)
            for b, w in zip(below, reversed(widths), strict=True)
        )
        self.norm = nn.LayerNorm(widths[0])
        # The input also goes past the LayerNorm, which would forget its
        # size, straight to the output.
        self.outward = nn.Linear(2 * widths[0], channels)
        nn.init.zeros_(self.outward.weight)
        nn.init.zeros_(self.outward.bias)

    def forward(
        self, place: Float[Tensor, "batch n i"], condition: Condition
    ) -> Float[Tensor, "batch n c"]:
        """Predict for each place of a list; the result is zero before training."""
        place = first = self.inward(place).float()
        kept = []
        for block in self.down:
            place = block(place, condition)
            kept.append(place)
        place = self.middle(place, condition)
        for block, skip in zip(self.up, reversed(kept), strict=True):
            place = block(torch.cat([place, skip], dim=-1), condition)
        with torch.autocast(place.device.type, enabled=False):
            return self.outward(torch.cat([functional.silu(self.norm(place)), first], dim=-1))
