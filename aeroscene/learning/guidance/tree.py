"""The hierarchy as matrices: who is above whom, who turns with whom."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.tokens.batch import TokenBatch


def lineage(batch: TokenBatch) -> Bool[Tensor, "batch n n"]:
    """Entry [i, j]: whether token j is i itself or above it.

    Tokens of depth 0 have nothing above them: sites, and all tokens of the flat layouts of the
    paper's preset.
    """
    n_scenes, n = batch.parent.shape
    itself = torch.eye(n, dtype=torch.bool, device=batch.parent.device)
    above = itself.expand(n_scenes, n, n).clone()
    rows = batch.parent[..., None].expand(-1, -1, n)
    for level in range(1, int(batch.depth.max()) + 1):
        here = (batch.depth == level)[..., None]
        above = torch.where(here, above.gather(1, rows) | itself, above)
    return above


def parent_heading(
    heading: Float[Tensor, "batch n 2"], batch: TokenBatch
) -> Float[Tensor, "batch n 2"]:
    """Cosine and sine of the yaw of every token's parent; the world's where there is none."""
    of_parent = heading.gather(1, batch.parent[..., None].expand(-1, -1, 2))
    world = heading.new_tensor([1.0, 0.0])
    return torch.where((batch.depth > 0)[..., None], of_parent, world)


def turn(
    vector: Float[Tensor, "*batch 3"], heading: Float[Tensor, "*batch 2"]
) -> Float[Tensor, "*batch 3"]:
    """Vectors of frames turned about the vertical, in the world."""
    x, y, z = vector.unbind(-1)
    c, s = heading.unbind(-1)
    return torch.stack([c * x - s * y, s * x + c * y, z.expand_as(c * x)], dim=-1)


def turn_back(
    vector: Float[Tensor, "*batch 3"], heading: Float[Tensor, "*batch 2"]
) -> Float[Tensor, "*batch 3"]:
    """Vectors of the world in frames turned about the vertical."""
    c, s = heading.unbind(-1)
    return turn(vector, torch.stack([c, -s], dim=-1))
