"""The paper's coarse-to-fine guidance, L_c2f, and a form that leaves room within the region."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.paper.guidance.config import RegionDistance
from aeroscene.learning.paper.guidance.layout import Layout

_LEAST_DISTANCE_M = 1e-4
"""Lower bound of the distance to a point, at which it has no slope."""


def coarse_to_fine_loss(
    layout: Layout,
    distance: RegionDistance,
    is_hollow: Bool[Tensor, " categories"] | None = None,
) -> Float[Tensor, " batch"]:
    """Sum over fine objects of their distance to the region of the nearest coarse object, m.

    Args:
        layout: Objects of a batch.
        distance: `centroid` is the distance to the coarse object's centre, as in the paper; it
            draws all fine objects into one point. `border` is the horizontal distance to its box, 0
            within its footprint.
        is_hollow: Categories that hold anything, by number. Only these are regions, in scenes that
            have one: the wall that is nearest to a chair is not its region.

    Returns:
        One value for each scene; 0 for a scene without coarse objects.

    Source: the paper's L_c2f(x_t), section "Coarse-to-Fine Guidance". The region R_coarse(o_i) is
    that of the coarse object whose centre is nearest, as there. If a layout knows its regions,
    these count instead.
    """
    fine = layout.mask & ~layout.is_coarse
    coarse = layout.mask & layout.is_coarse
    if is_hollow is not None:
        holds = coarse & is_hollow.to(coarse.device)[layout.category]
        coarse = torch.where(holds.any(-1, keepdim=True), holds, coarse)
    offset = layout.center_enu_m[:, :, None] - layout.center_enu_m[:, None]
    away = offset.square().sum(-1).clamp(min=_LEAST_DISTANCE_M**2).sqrt()
    # The choice of the region has no slope; the distance to it has one.
    own = away.masked_fill(~coarse[:, None], torch.inf).argmin(dim=-1)
    if layout.region is not None:
        own = torch.where(layout.region >= 0, layout.region, own)
    if distance == "centroid":
        to_region = away.gather(2, own[..., None]).squeeze(-1)
    else:
        to_region = _to_border(layout, offset, own)
    has_region = fine & coarse.any(dim=-1, keepdim=True)
    return torch.where(has_region, to_region, 0.0).sum(-1)


def _to_border(layout: Layout, offset: Tensor, nearest: Tensor) -> Float[Tensor, "batch n"]:
    """Horizontal distance to the footprint of the region's object; 0 inside."""
    pick = nearest[..., None, None].expand(-1, -1, 1, 3)
    x, y = offset.gather(2, pick).squeeze(2)[..., :2].unbind(-1)
    cos, sin = layout.heading.gather(1, nearest[..., None].expand(-1, -1, 2)).unbind(-1)
    half = layout.size_m.gather(1, nearest[..., None].expand(-1, -1, 3))[..., :2] / 2
    local = torch.stack([cos * x + sin * y, cos * y - sin * x], dim=-1)
    outside = (local.abs() - half).clamp(min=0)
    squared = outside.square().sum(-1)
    # The inner `where` keeps the square root away from 0, where its slope is infinite.
    is_outside = squared > 0
    return torch.where(is_outside, torch.where(is_outside, squared, 1.0).sqrt(), 0.0)
