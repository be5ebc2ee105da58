"""Boxes of a batch in the world, and their outlines in the axes of their parents."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.channels import LEAST_PLAY


@dataclass(frozen=True)
class Boxes:
    """Upright boxes of a batch in the world."""

    center_enu_m: Float[Tensor, "batch n 3"]
    heading: Float[Tensor, "batch n 2"]
    """Cosine and sine of the yaw in the world."""
    size_m: Float[Tensor, "batch n 3"]
    play_m: Float[Tensor, "batch n 2"]
    """Metres along the parent's axes by which one unit of channels 0 and 1 moves a box."""
    rise_m: Float[Tensor, "batch n"]
    """Metres by which one unit of channel 2 raises a box, 0 where its height is no channel."""
    openings_m: Float[Tensor, "batch n 7"]
    mask: Bool[Tensor, "batch n"]


@dataclass(frozen=True)
class Footprints:
    """Outlines of tokens seen along the axes of their parents."""

    middle_m: Float[Tensor, "batch n 2"]
    """Way from the middle of the parent."""
    reach_m: Float[Tensor, "batch n 2"]
    """Half the extents along the parent's axes; exact for what stands square to its parent."""
    parent_half_m: Float[Tensor, "batch n 2"]
    is_crosswise: Bool[Tensor, "batch n"]
    """Whether the own x axis lies along the parent's y axis."""

    @property
    def play_m(self) -> Float[Tensor, "batch n 2"]:
        """How far each may move from the middle, as `aeroscene.learning.tokens.channels.play_m`."""
        return torch.maximum(self.parent_half_m - self.reach_m, LEAST_PLAY * self.parent_half_m)


def footprints_of(boxes: Boxes, batch: TokenBatch) -> Footprints:
    """Outlines of boxes."""
    place = batch.parent.unsqueeze(-1)
    parent_center = boxes.center_enu_m.gather(1, place.expand_as(boxes.center_enu_m))
    parent_size = boxes.size_m.gather(1, place.expand_as(boxes.size_m))
    cos, sin = boxes.heading.gather(1, place.expand_as(boxes.heading)).unbind(-1)
    x, y = (boxes.center_enu_m - parent_center)[..., :2].unbind(-1)
    own_cos, own_sin = boxes.heading.unbind(-1)
    along, across = (cos * own_cos + sin * own_sin).abs(), (cos * own_sin - sin * own_cos).abs()
    length, width = boxes.size_m[..., 0], boxes.size_m[..., 1]
    reach = torch.stack([along * length + across * width, across * length + along * width], -1)
    return Footprints(
        torch.stack([cos * x + sin * y, cos * y - sin * x], dim=-1),
        reach / 2,
        parent_size[..., :2] / 2,
        across > along,
    )
