"""Recoding of the channels of any codec to those of the default, differentiable."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes
from aeroscene.learning.tokens.channels import HEADING, PLACE, SIZE
from aeroscene.learning.tokens.codec import CodecCfg

_LEAST_EXTENT = 0.02
"""Linear extents of a noisy layout may come out negative."""


def default_channels(
    values: Float[Tensor, "batch n 15"],
    codec: CodecCfg,
    batch: TokenBatch,
    place: Callable[[Tensor], Boxes],
) -> Float[Tensor, "batch n 15"]:
    """Channels, not standardised, as the default codec has them for the same layout.

    `place` makes boxes of the default's channels; headings and sizes do not depend on places.
    """
    if codec.size == "linear":
        values = _with(values, SIZE, values[..., SIZE].clamp_min(_LEAST_EXTENT).log())
    if codec.yaw == "angle":
        angle = values[..., HEADING.stop - 1] * (pi / 2)
        vector = torch.stack([angle.cos(), angle.sin()], dim=-1)
        is_site = (batch.depth == 0)[..., None]
        values = _with(values, HEADING, torch.where(is_site, values[..., HEADING], vector))
    if codec.frame == "play":
        return values
    boxes = place(values)
    return _with(values, PLACE, _offset_m(values[..., PLACE], codec, batch, boxes) / boxes.play_m)


def _offset_m(
    place: Float[Tensor, "batch n 2"], codec: CodecCfg, batch: TokenBatch, boxes: Boxes
) -> Float[Tensor, "batch n 2"]:
    """Offset from the middle of the parent, along its axes."""
    parent = batch.parent[..., None].expand_as(place)
    half_m = boxes.size_m[..., :2] / 2
    if codec.frame == "parent":
        return place * half_m.gather(1, parent)
    in_site_m = place * half_m[:, :1] * (batch.depth > 0)[..., None]
    x, y = (in_site_m - in_site_m.gather(1, parent)).unbind(-1)
    # From the axes of the site to those of the parent.
    a, b = boxes.heading.gather(1, parent).unbind(-1)
    c, s = boxes.heading[:, :1].unbind(-1)
    cos, sin = a * c + b * s, b * c - a * s
    return torch.stack([cos * x + sin * y, cos * y - sin * x], dim=-1)


def _with(values: Tensor, channels: slice, new: Tensor) -> Tensor:
    return torch.cat([values[..., : channels.start], new, values[..., channels.stop :]], dim=-1)
