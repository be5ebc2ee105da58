"""Conversion of a layout's channels to boxes in the world, differentiably.

Guidance needs gradients by channels, but overlaps and distances are defined for boxes in metres. A
reader is the bridge between the two.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.paper.channels import POSITION, SCALE, FlatStatistics

_LOG_SIZE = (-4.6, 5.7)
"""Logarithms of the least and greatest extent that is read, 1 cm and 300 m."""


@dataclass(frozen=True)
class Layout:
    """Objects of a batch in the world, differentiable."""

    center_enu_m: Float[Tensor, "batch n 3"]
    heading: Float[Tensor, "batch n 2"]
    """Cosine and sine of the yaw. Layouts have no tilt."""
    size_m: Float[Tensor, "batch n 3"]
    """Full extents."""
    category: Int[Tensor, "batch n"]
    """Numbers of the catalogue, from 1."""
    mask: Bool[Tensor, "batch n"]
    """True in slots that hold an object; a site is none."""
    is_coarse: Bool[Tensor, " n"]
    region: Int[Tensor, "batch n"] | None = None
    """Slot of the coarse object that each fine one belongs to; negative if unknown."""


Reader = Callable[[Tensor, TokenBatch], Layout]
"""Function from channels to the objects that they stand for."""


class FlatReader:
    """Reads the channels of `aeroscene.learning.paper.channels`, given categories and frames."""

    def __init__(self, statistics: FlatStatistics, device: torch.device | str = "cpu") -> None:
        mean, spread = statistics.mean, statistics.spread
        self._mean = torch.as_tensor(mean, dtype=torch.float32, device=device)
        self._spread = torch.as_tensor(spread, dtype=torch.float32, device=device)

    def __call__(self, x: Tensor, batch: TokenBatch) -> Layout:
        """Return the boxes of a batch's channels; given objects are read from the batch."""
        assert batch.frame is not None
        assert batch.turn is not None
        if batch.given is not None and batch.x0 is not None:
            x = torch.where(batch.given[..., None], batch.x0.to(x), x)
        rows = x * self.spread_of(batch).to(x) + self._mean[batch.kind].to(x)
        frame = batch.frame.to(x)
        along = turn_on(rows[..., :2] * frame[..., 5:7], frame[..., 3:5])
        size = rows[..., SCALE].clamp(*_LOG_SIZE).exp()
        up = rows[..., 2] + size[..., 2] / 2 + frame[..., 2]
        center = torch.cat([along + frame[..., :2], up[..., None]], dim=-1)
        # Double angle: the channels hold cosine and sine of half of the remainder.
        w, z = rows[..., 3], rows[..., 6]
        rest = torch.stack([w * w - z * z, 2 * w * z], dim=-1)
        rest = rest / rest.norm(dim=-1, keepdim=True).clamp(min=1e-6)
        # Remainder, then quarter turn, then the frame's yaw.
        heading = turn_on(turn_on(rest, _QUARTERS.to(x)[batch.turn]), frame[..., 3:5])
        is_coarse = _is_coarse(batch)
        return Layout(center, heading, size, batch.kind, batch.mask, is_coarse, batch.parent)

    def spread_of(self, batch: TokenBatch) -> Float[Tensor, "batch n 10"]:
        """Spread of each channel of each object, in the channel's own unit."""
        return self._spread[batch.kind]

    def metres_of(self, batch: TokenBatch) -> Float[Tensor, "batch n 3"]:
        """Metres by which a step of one in each position channel moves an object."""
        assert batch.frame is not None
        spread = self.spread_of(batch)[..., POSITION]
        return torch.cat([spread[..., :2] * batch.frame[..., 5:7], spread[..., 2:]], dim=-1)


# Cosine and sine of 0 to 3 quarter turns.
_QUARTERS = torch.tensor([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


def turn_on(
    vector: Float[Tensor, "*batch 2"], heading: Float[Tensor, "*batch 2"]
) -> Float[Tensor, "*batch 2"]:
    """Turn horizontal vectors by a heading, given as cosine and sine."""
    (x, y), (c, s) = vector.unbind(-1), heading.unbind(-1)
    return torch.stack([c * x - s * y, s * x + c * y], dim=-1)


def turn_back(
    vector: Float[Tensor, "*batch 3"], heading: Float[Tensor, "*batch 2"]
) -> Float[Tensor, "*batch 3"]:
    """Express vectors of the world in frames that are turned about the vertical."""
    x, y, z = vector.unbind(-1)
    c, s = heading.unbind(-1)
    return torch.stack([c * x + s * y, c * y - s * x, z.expand_as(c * x)], dim=-1)


def _is_coarse(batch: TokenBatch) -> Bool[Tensor, " n"]:
    slot = torch.arange(batch.mask.shape[1], device=batch.mask.device)
    return slot < batch.n_coarse_slots
