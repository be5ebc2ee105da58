"""Blocks of the default network: within-scale mixing, cross-scale attention and FFN side by side.

The paper's cross-scale block is F' = FC(Attn(LN Q, LN K, LN V)) + F, after separate branches. Here
each of the L alternating blocks also holds the within-scale mixing of both scales and an FFN. All
of these read the same normalised tokens, with one matrix in and one matrix out for each scale (the
parallel form of Wang and Komatsuzaki 2021), because on a CPU few large products cost least. Time,
domain and wish modulate them by adaLN-zero (Peebles and Xie 2023).
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.model.relations import Relations


class Reading(NamedTuple):
    """Projections of one scale's tokens at the start of a block."""

    own: tuple[Tensor, Tensor, Tensor]
    """Queries, keys and values of the within-scale attention, each [B, H, n, d / H]."""
    cross: tuple[Tensor, ...]
    """Queries, or keys and values, of the cross-scale attention, each [B, H, n, d / H]."""
    hidden: Float[Tensor, "batch n h"]
    """Activations of the FFN."""
    gate: Float[Tensor, "batch 1 d"]
    """Gate of the block's output."""


class Scale(nn.Module):
    """Matrices and modulation of one scale (coarse or fine) in one block.

    Args:
        width: Width d of a token.
        heads: Attention heads H; they divide `width`.
        ffn_ratio: Hidden width of the FFN by `width`.
        asks: True makes its tokens the queries of the cross-scale attention; otherwise they are
            keys and values.
    """

    def __init__(self, width: int, heads: int, ffn_ratio: int, asks: bool) -> None:
        super().__init__()
        self.heads = heads
        # Widths of the parts of one product: attention within, attention across, FFN.
        self.parts = [3 * width, width if asks else 2 * width, ffn_ratio * width]
        self.modulation = nn.Linear(width, 3 * width)
        self.inward = nn.Linear(width, sum(self.parts))
        self.outward = nn.Linear(width * (1 + int(asks) + ffn_ratio), width)
        # At zero the gate is closed: an untrained block passes its tokens
        # on unchanged (adaLN-zero).
        nn.init.zeros_(self.modulation.weight)
        nn.init.zeros_(self.modulation.bias)

    def read(
        self, token: Float[Tensor, "batch n d"], condition: Float[Tensor, "batch d"]
    ) -> Reading:
        """Normalise, modulate and project the tokens."""
        shift, scale, gate = self.modulation(condition).unsqueeze(1).chunk(3, dim=-1)
        level = functional.layer_norm(token, token.shape[-1:])
        inner = self.inward(torch.addcmul(shift, level, 1.0 + scale))
        own, cross, hidden = inner.split(self.parts, dim=-1)
        query, key, value = self._to_heads(own, 3)
        return Reading(
            (query, key, value),
            # A share of 1/3 of the first part holds queries alone, 2/3 keys and values.
            self._to_heads(cross, self.parts[1] * 3 // self.parts[0]),
            # Squared ReLU, the activation of Primer (So et al. 2021).
            functional.relu(hidden).square(),
            gate,
        )

    def write(
        self,
        token: Float[Tensor, "batch n d"],
        reading: Reading,
        *mixed: Float[Tensor, "batch n d"],
    ) -> Float[Tensor, "batch n d"]:
        """Add the results of attention and FFN to the tokens, through the block's gate."""
        found = self.outward(torch.cat([*mixed, reading.hidden], dim=-1))
        return torch.addcmul(token, reading.gate, found)

    def _to_heads(self, packed: Float[Tensor, "batch n p"], parts: int) -> tuple[Tensor, ...]:
        return packed.unflatten(-1, (parts, self.heads, -1)).permute(2, 0, 3, 1, 4).unbind(0)


class HierarchyBlock(nn.Module):
    """One block: both scales mix within themselves, and one asks the other.

    Top-down, fine tokens ask coarse ones; bottom-up, coarse tokens ask fine ones.
    """

    def __init__(self, width: int, heads: int, ffn_ratio: int, is_top_down: bool) -> None:
        super().__init__()
        self.is_top_down = is_top_down
        self.coarse = Scale(width, heads, ffn_ratio, asks=not is_top_down)
        self.fine = Scale(width, heads, ffn_ratio, asks=is_top_down)

    def forward(
        self,
        coarse: Float[Tensor, "batch nc d"],
        fine: Float[Tensor, "batch nf d"],
        condition: Float[Tensor, "batch d"],
        relations: Relations,
    ) -> tuple[Float[Tensor, "batch nc d"], Float[Tensor, "batch nf d"]]:
        """Update the tokens of both scales.

        Both scales are read before either is written, so neither sees the other's update.
        """
        above, below = self.coarse.read(coarse, condition), self.fine.read(fine, condition)
        mixed_coarse = [attend(*above.own, relations.coarse_self)]
        mixed_fine = [attend(*below.own, relations.fine_self)]
        if self.is_top_down:
            (query,), (key, value) = below.cross, above.cross
            mixed_fine.append(attend(query, key, value, relations.top_down))
        else:
            (query,), (key, value) = above.cross, below.cross
            answer = attend(query, key, value, relations.bottom_up)
            # A coarse token without fine tokens has nothing to attend to; its answer
            # is noise and is removed.
            mixed_coarse.append(answer * relations.has_fine)
        return (
            self.coarse.write(coarse, above, *mixed_coarse),
            self.fine.write(fine, below, *mixed_fine),
        )


def attend(
    query: Float[Tensor, "batch h q e"],
    key: Float[Tensor, "batch h k e"],
    value: Float[Tensor, "batch h k e"],
    mask: Float[Tensor, "batch h q k"],
) -> Float[Tensor, "batch q d"]:
    """Masked multi-head attention, with the heads laid side by side again.

    Args:
        query: Queries of each head.
        key: Keys of each head.
        value: Values of each head.
        mask: Added to the logits: 0 allows attention, `MASKED` forbids it.
    """
    mask = mask.to(query.dtype)
    if query.dtype == torch.bfloat16 and query.device.type == "cpu":
        mixed = _attend_by_products(query, key, value, mask)
    else:
        mixed = functional.scaled_dot_product_attention(query, key, value, attn_mask=mask)
    return mixed.transpose(1, 2).flatten(2)


def _attend_by_products(query: Tensor, key: Tensor, value: Tensor, mask: Tensor) -> Tensor:
    # Forward and backward, torch's fused attention takes three times as long in bfloat16 on a CPU
    # as plain products (2.13, 16 x 4 heads x 128 x 128: 26 ms against 9 ms).
    scaled = (query * query.shape[-1] ** -0.5).flatten(0, 1)
    logits = torch.baddbmm(mask.flatten(0, 1), scaled, key.flatten(0, 1).transpose(1, 2))
    mixed = torch.bmm(logits.softmax(-1), value.flatten(0, 1))
    return mixed.unflatten(0, query.shape[:2])
