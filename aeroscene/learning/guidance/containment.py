"""Within what bears them: objects keep their middle over their parent, roots keep within the site.

The paper pulls fine objects towards the centre of their region instead (L_c2f), which piles them up
there; here nothing moves that is within.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.guidance.tree import turn_back
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes, Footprints

_INSIDE_M = 0.02
"""Least distance of a middle from the outline of its parent, within it."""


def reach_of_middle(
    footprints: Footprints, boxes: Boxes, batch: TokenBatch, keeps_within: Bool[Tensor, "batch n"]
) -> Float[Tensor, "batch n 2"]:
    """How far from the middle of its parent, along its axes, each token may be.

    Tokens of `keeps_within` keep the whole of their outline within their parent's.
    """
    half, reach = footprints.parent_half_m, footprints.reach_m
    inset = torch.where(keeps_within[..., None], reach, torch.full_like(reach, _INSIDE_M))
    limit = (half - inset).clamp_min(0.0)
    is_root = (batch.depth == 1)[..., None]
    # What fits in every heading fits; what is farther out already goes no farther.
    room = _room_in_site(boxes) / boxes.heading[:, :1].abs().sum(-1, keepdim=True)
    return torch.where(is_root, torch.maximum(room, footprints.middle_m.abs()), limit)


def contained(
    footprints: Footprints, boxes: Boxes, batch: TokenBatch, keeps_within: Bool[Tensor, "batch n"]
) -> Footprints:
    """The outlines moved by as little as brings them within; arguments as `reach_of_middle`."""
    limit = reach_of_middle(footprints, boxes, batch, keeps_within)
    middle = torch.maximum(torch.minimum(footprints.middle_m, limit), -limit)
    middle = torch.where((batch.depth > 1)[..., None], middle, footprints.middle_m)
    is_root = (batch.depth == 1)[..., None]
    return replace(footprints, middle_m=torch.where(is_root, _in_site(middle, boxes), middle))


def _in_site(middle: Float[Tensor, "batch n 2"], boxes: Boxes) -> Float[Tensor, "batch n 2"]:
    """Middles of roots, in the axes of the site, moved into the flight volume."""
    limit, place = _room_in_site(boxes), boxes.center_enu_m[..., :2]
    shift = torch.maximum(torch.minimum(place, limit), -limit) - place
    flat = torch.cat([shift, torch.zeros_like(shift[..., :1])], dim=-1)
    site = boxes.heading[:, :1].expand_as(boxes.heading)
    return middle + turn_back(flat, site)[..., :2]


def _room_in_site(boxes: Boxes) -> Float[Tensor, "batch n 2"]:
    """How far east and north of the middle of the site each box may be."""
    cos, sin = boxes.heading.abs().unbind(-1)
    length, width = boxes.size_m[..., 0], boxes.size_m[..., 1]
    reach = torch.stack([cos * length + sin * width, sin * length + cos * width], dim=-1) / 2
    # The flight volume is never turned, see `aeroscene.learning.tokens.channels.site_growth`.
    growth = boxes.heading[:, :1].abs().sum(-1, keepdim=True)
    return (boxes.size_m[:, :1, :2] * growth / 2 - reach).clamp_min(0.0)
