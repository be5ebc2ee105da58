"""What the paper's guidance sees of a noisy layout: objects with place, heading, size, category."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.paper.tokens import N_GEOMETRY, POSITION, ROTATION, SCALE, FlatStatistics
from aeroscene.learning.tokens.batch import TokenBatch

_LEAST_SIZE_M = 0.02
"""Extents of a noisy layout may come out negative."""


@dataclass(frozen=True)
class Layout:
    """Objects of a batch in the world, differentiable."""

    center_enu_m: Float[Tensor, "batch n 3"]
    heading: Float[Tensor, "batch n 2"]
    """Cosine and sine of the yaw; a tilt is left out, since the corpus stands upright."""
    size_m: Float[Tensor, "batch n 3"]
    category: Float[Tensor, "batch n categories"]
    """Weights of the categories, which a noisy layout does not know for sure."""
    mask: Bool[Tensor, "batch n"]
    """Which slots hold an object; a site is none."""
    is_coarse: Bool[Tensor, " n"]


Reader = Callable[[Tensor, TokenBatch], Layout]
"""From channels to the objects that they stand for."""


def flat_reader(statistics: FlatStatistics, device: torch.device | str = "cpu") -> Reader:
    """Reads the paper's channels, see `aeroscene.learning.paper.tokens`."""
    mean, spread = (
        torch.as_tensor(values, dtype=torch.float32, device=device)
        for values in (statistics.mean, statistics.spread)
    )

    def read(x: Tensor, batch: TokenBatch) -> Layout:
        geometry = x[..., :N_GEOMETRY] * spread.to(x) + mean.to(x)
        return Layout(
            geometry[..., POSITION],
            heading_of_quaternion(geometry[..., ROTATION]),
            geometry[..., SCALE].clamp(min=_LEAST_SIZE_M),
            x[..., N_GEOMETRY:],
            batch.mask,
            _is_coarse(batch),
        )

    return read


def heading_of_quaternion(quat_wxyz: Float[Tensor, "*batch 4"]) -> Float[Tensor, "*batch 2"]:
    """Cosine and sine of the yaw of quaternions of any norm."""
    w, x, y, z = quat_wxyz.unbind(-1)
    along = torch.stack([w * w + x * x - y * y - z * z, 2 * (w * z + x * y)], dim=-1)
    return along / along.norm(dim=-1, keepdim=True).clamp(min=1e-6)


def turn_back(
    vector: Float[Tensor, "*batch 3"], heading: Float[Tensor, "*batch 2"]
) -> Float[Tensor, "*batch 3"]:
    """Vectors of the world in frames turned about the vertical."""
    x, y, z = vector.unbind(-1)
    c, s = heading.unbind(-1)
    return torch.stack([c * x + s * y, c * y - s * x, z.expand_as(c * x)], dim=-1)


def _is_coarse(batch: TokenBatch) -> Bool[Tensor, " n"]:
    slot = torch.arange(batch.mask.shape[1], device=batch.mask.device)
    return slot < batch.n_coarse_slots
