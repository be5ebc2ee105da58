"""The paper's collision avoidance guidance, L_col."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from aeroscene.learning.paper.guidance.config import IouKind
from aeroscene.learning.paper.guidance.layout import Layout
from aeroscene.learning.paper.guidance.overlap import BoxPairs, exact_iou, penetration_m, soft_iou


def collision_loss(
    layout: Layout,
    *,
    tolerance: float,
    kind: IouKind,
    softness_m: float,
    is_hollow: Bool[Tensor, " categories"] | None = None,
) -> Float[Tensor, " batch"]:
    """Sum over ordered pairs of what their IoU exceeds the tolerance delta_d by.

    The IoU is the exact one, or a surrogate with a slope everywhere, as the paper's training asks
    for ("smooth surrogates such as soft IoU, signed distance functions"), or the depth by which the
    boxes reach into each other, m, which sees a slab and a thin wall. Categories that `is_hollow`
    marks by their numbers, as rooms and buildings, collide with their like alone: the rest is
    within them.

    Source: the paper's L_col(x_t), section "Collision Avoidance Guidance".
    """
    scene, first, second = _near(layout, 4 * softness_m if kind == "soft" else 0.0, is_hollow)
    pairs = BoxPairs(
        *(
            (values[scene, first], values[scene, second])
            for values in (layout.center_enu_m, layout.heading, layout.size_m)
        )
    )
    if kind == "depth":
        iou = penetration_m(pairs)
    else:
        iou = exact_iou(pairs) if kind == "exact" else soft_iou(pairs, softness_m)
    excess = (iou - tolerance).clamp(min=0)
    hits = torch.nn.functional.one_hot(scene, len(layout.mask)).to(excess)
    return 2 * excess @ hits


def _near(
    layout: Layout, margin_m: float, is_hollow: Tensor | None
) -> tuple[Tensor, Tensor, Tensor]:
    """Pairs whose boxes may overlap: scene, first, second."""
    center, size = layout.center_enu_m.detach(), layout.size_m.detach()
    reach = size[..., :2].norm(dim=-1) / 2
    both = reach[:, :, None] + reach[:, None] + margin_m
    apart = (center[:, :, None, :2] - center[:, None, :, :2]).square().sum(-1)
    near = apart < both**2
    height = (size[:, :, None, 2] + size[:, None, :, 2]) / 2 + margin_m
    near &= (center[:, :, None, 2] - center[:, None, :, 2]).abs() < height
    near &= layout.mask[:, :, None] & layout.mask[:, None]
    if is_hollow is not None:
        category, holds = layout.category, is_hollow.to(near.device)[layout.category]
        differ = category[:, :, None] != category[:, None]
        near &= ~(differ & (holds[:, :, None] | holds[:, None]))
    scene, first, second = near.triu(1).nonzero(as_tuple=True)
    return scene, first, second
