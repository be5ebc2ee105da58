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
    """Sum over ordered pairs of the amount by which their overlap exceeds the tolerance delta_d.

    Args:
        layout: Objects of a batch.
        tolerance: delta_d, in the unit of the overlap.
        kind: `exact` is the IoU. `soft` is a surrogate with a slope everywhere, which the paper's
            training asks for ("smooth surrogates such as soft IoU, signed distance functions").
            `depth` is the depth of penetration in metres, which also sees slabs and thin walls.
        softness_m: Softness of the soft IoU.
        is_hollow: Categories such as rooms and buildings, by number, which collide with their like
            alone because other objects are within them.

    Returns:
        One value for each scene.

    Source: the paper's L_col(x_t), section "Collision Avoidance Guidance".
    """
    # Softplus is below 2% of its scale at 4 scales, so pairs further apart may be left out.
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
    # Pairs are counted once here, and twice in the paper's sum.
    return 2 * excess @ hits


def _near(
    layout: Layout, margin_m: float, is_hollow: Tensor | None
) -> tuple[Tensor, Tensor, Tensor]:
    # Circles about the footprints and heights: a cheap test that never misses an overlap.
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
