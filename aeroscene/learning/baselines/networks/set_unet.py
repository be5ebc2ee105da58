"""UNet over a set: blocks of pointwise layers and attention among all places, with skips.

Convolutions along the list have a kernel of one, and no level is shorter than another: "1D" in
DiffuScene's name for the network means the list. A set has no order, so a learned embedding tells
the places apart.

Source: Tang et al. 2024, "DiffuScene", section 3.2 and figure 3.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.model.encoding import TimeEmbedding
from aeroscene.learning.paper.network.attention import MaskedAttention
from aeroscene.scene import DOMAINS


class SetUnet(nn.Module):
    """Predicts noise, velocity or clean values of a noisy set, given time and domain.

    Args:
        channels: Numbers of a place.
        places: Number of places; every input has exactly so many.
        width: Width of a place inside of the network.
        levels: Blocks on the way down, and as many on the way up.
        heads: Attention heads; they divide `width`.
    """

    def __init__(self, channels: int, places: int, width: int, levels: int, heads: int) -> None:
        super().__init__()
        self.time = TimeEmbedding(width)
        self.domain = nn.Embedding(len(DOMAINS), width)
        self.inward = nn.Linear(channels, width)
        self.place = nn.Parameter(torch.randn(places, width))
        self.down = nn.ModuleList(SetBlock(width, width, heads) for _ in range(levels))
        self.middle = SetBlock(width, width, heads)
        self.up = nn.ModuleList(SetBlock(2 * width, width, heads) for _ in range(levels))
        self.norm = nn.LayerNorm(width)
        self.outward = nn.Linear(2 * width, channels)
        # The untrained network predicts zero.
        nn.init.zeros_(self.outward.weight)
        nn.init.zeros_(self.outward.bias)

    def forward(
        self, x_t: Float[Tensor, "batch n c"], t: Float[Tensor, " batch"], batch: TokenBatch
    ) -> Prediction:
        """Predict for all places, empty ones among them.

        Args:
            x_t: Noisy values.
            t: Time of each scene, 0 clean to 1 noise.
            batch: Its `domain` is read, and nothing else.
        """
        condition = self.time(t) + self.domain(batch.domain)
        place = first = self.inward(x_t) + self.place
        kept: list[Tensor] = []
        for block in self.down:
            place = block(place, condition)
            kept.append(place)
        place = self.middle(place, condition)
        for block, skip in zip(self.up, reversed(kept), strict=True):
            place = block(torch.cat([place, skip], dim=-1), condition)
        # The input goes straight to the last layer: at high noise nearly
        # all of the target is in it.
        place = torch.cat([functional.silu(self.norm(place)), first], dim=-1)
        return Prediction(self.outward(place))


class SetBlock(nn.Module):
    """Two pointwise layers with the condition between them, then attention among all places."""

    def __init__(self, inward: int, width: int, heads: int) -> None:
        super().__init__()
        self.first_norm = nn.LayerNorm(inward)
        self.first = nn.Linear(inward, width)
        self.condition = nn.Linear(width, 2 * width)
        self.second_norm = nn.LayerNorm(width)
        self.second = nn.Linear(width, width)
        self.skip = nn.Linear(inward, width) if inward != width else nn.Identity()
        self.attention = MaskedAttention(width, heads)

    def forward(
        self, place: Float[Tensor, "batch n c"], condition: Float[Tensor, "batch d"]
    ) -> Float[Tensor, "batch n w"]:
        """Update all places; `condition` scales and shifts each channel between the layers."""
        scale, shift = self.condition(condition).unsqueeze(1).chunk(2, dim=-1)
        inner = self.first(functional.silu(self.first_norm(place)))
        inner = self.second_norm(inner) * (1 + scale) + shift
        place = self.skip(place) + self.second(functional.silu(inner))
        everywhere = torch.ones((1, 1, place.shape[1]), dtype=torch.bool, device=place.device)
        return self.attention(place, place, everywhere)
