"""Kinds of tokens as vectors."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn


class KindEmbedding(nn.Module):
    """Kinds as vectors: one of their own, plus one for each of their traits.

    A kind that is rare in training thereby shares what is known of its category and attributes.
    """

    traits: Tensor

    def __init__(self, traits: Bool[Tensor, "kinds traits"], width: int) -> None:
        super().__init__()
        # One more row stands for "no kind".
        none = traits.new_zeros((1, traits.shape[1]))
        self.register_buffer("traits", torch.cat([traits, none]), persistent=False)
        self.own = nn.Parameter(0.1 * torch.randn(len(traits) + 1, width))
        self.shared = nn.Parameter(0.1 * torch.randn(traits.shape[1], width))

    def forward(self) -> Float[Tensor, "kinds_and_none width"]:
        """Return the vectors of all kinds, and that of "no kind" at the end."""
        return self.own + self.traits.to(self.own.dtype) @ self.shared
