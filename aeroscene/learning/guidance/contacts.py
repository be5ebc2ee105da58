"""Pairs of upright boxes that overlap, and how deep, by separating axes."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.tokens.boxes import Boxes


@dataclass(frozen=True)
class Pairs:
    """Pairs of boxes near each other, of all scenes of a batch in one list.

    Tokens are numbered through the batch: scene times tokens a scene, plus the slot.
    """

    first: Int[Tensor, " pairs"]
    second: Int[Tensor, " pairs"]
    axes: Float[Tensor, "pairs 5 3"]
    """Unit normals of the faces of both boxes, ENU; the last is the vertical."""
    reach_m: Float[Tensor, "pairs 5"]
    """Distance of the centres along an axis at which the boxes touch."""
    offset_m: Float[Tensor, "pairs 3"]
    """Way from the first box's centre to the second's, ENU."""

    def __len__(self) -> int:
        return len(self.first)


def near_pairs(boxes: Boxes, excluded: Bool[Tensor, "batch n n"], margin_m: float) -> Pairs:
    """Pairs nearer than a margin, but for those that may overlap: ancestors and descendants."""
    half = boxes.size_m / 2
    cos, sin = boxes.heading.abs().unbind(-1)
    width = cos * half[..., 0] + sin * half[..., 1]
    breadth = sin * half[..., 0] + cos * half[..., 1]
    near = ~excluded & boxes.mask[:, :, None] & boxes.mask[:, None]
    for place, reach in zip(
        boxes.center_enu_m.unbind(-1), (width, breadth, half[..., 2]), strict=True
    ):
        apart = (place[:, :, None] - place[:, None]).abs()
        near &= apart < reach[:, :, None] + reach[:, None] + margin_m
    scene, first, second = near.triu(1).nonzero(as_tuple=True)
    n = boxes.mask.shape[1]
    return pairs_of(boxes, scene * n + first, scene * n + second)


def pairs_of(boxes: Boxes, first: Int[Tensor, " pairs"], second: Int[Tensor, " pairs"]) -> Pairs:
    """Some pairs, by the numbers of their tokens through the batch."""
    cos, sin = boxes.heading.reshape(-1, 2).unbind(-1)
    zero, one = torch.zeros_like(cos), torch.ones_like(cos)
    along, across = torch.stack([cos, sin, zero], -1), torch.stack([-sin, cos, zero], -1)
    up = torch.stack([zero, zero, one], -1)
    own = torch.stack([along, across, up], dim=1)
    half = boxes.size_m.reshape(-1, 3) / 2
    axes = torch.cat([own[first, :2], own[second]], dim=1)
    reach = _reach(axes, own[first], half[first]) + _reach(axes, own[second], half[second])
    center = boxes.center_enu_m.reshape(-1, 3)
    return Pairs(first, second, axes, reach, center[second] - center[first])


def _reach(axes: Tensor, own: Tensor, half: Tensor) -> Tensor:
    """Half the extent of each box along each axis."""
    return ((axes @ own.transpose(1, 2)).abs() * half[:, None]).sum(-1)


def overlap(pairs: Pairs) -> Float[Tensor, " pairs"]:
    """Least translation that parts the boxes of each pair, negative when apart, m."""
    apart = (pairs.axes * pairs.offset_m[:, None]).sum(-1)
    return (pairs.reach_m - apart.abs()).min(dim=-1).values
