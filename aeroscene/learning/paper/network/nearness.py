"""A bias of the attention among boxes, from the way in which they lie to each other."""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.paper.guidance.layout import Layout
from aeroscene.learning.paper.network.embedding import level_extent_m

_SCALES_M = (0.1, 1.0, 8.0)
_WIDTH = 16


class NearnessBias(nn.Module):
    """Logits that every self-attention of the UNet adds, from the gaps between two boxes.

    A gap along an axis is negative if the boxes overlap along it. Gaps are seen on three scales, so
    that touching, near, and in the same part of the site differ. Three more inputs say whether one
    box is the other's region, and whether both have the same region.
    """

    def __init__(self, heads: int) -> None:
        super().__init__()
        self.mlp = nn.Sequential(
            nn.Linear(3 * len(_SCALES_M) + 3, _WIDTH), nn.SiLU(), nn.Linear(_WIDTH, heads)
        )

    def forward(self, boxes: Layout, batch: TokenBatch) -> Float[Tensor, "batch heads n n"]:
        """Return the bias of queries (rows) for keys (columns).

        Args:
            boxes: Boxes of the formula's clean layout.
            batch: Its parents give the regions.
        """
        center, extent = boxes.center_enu_m, level_extent_m(boxes)
        apart = (center.unsqueeze(2) - center.unsqueeze(1)).abs()
        gap = apart - (extent.unsqueeze(2) + extent.unsqueeze(1)) / 2
        # The hyperbolic tangent resolves gaps about its scale and saturates beyond.
        scaled = [torch.tanh(gap / scale) for scale in _SCALES_M]
        related = _related(batch).to(gap)
        return self.mlp(torch.cat([*scaled, related], dim=-1)).permute(0, 3, 1, 2)


def _related(batch: TokenBatch) -> Tensor:
    """True if the key is the query's region, if the query is the key's, if both have the same."""
    slot = torch.arange(batch.mask.shape[1], device=batch.mask.device)
    is_region = batch.parent.unsqueeze(2) == slot
    same = (batch.parent.unsqueeze(2) == batch.parent.unsqueeze(1)) & (batch.parent >= 0).unsqueeze(
        1
    )
    return torch.stack([is_region, is_region.transpose(1, 2), same], dim=-1)
