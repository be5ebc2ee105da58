"""Intersection over union of upright boxes, exact and soft, differentiable.

The exact IoU follows from the polygon that two footprints share and from the overlap of their
heights. It has no slope where one box lies in the other. The soft IoU and the depth of penetration
replace it where guidance needs a slope everywhere.

Source of the exact one: Zhou et al. 2019, "IoU Loss for 2D/3D Object Detection", which the paper
names for its collision guidance.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn.functional import softplus

_CORNERS = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
_TOUCH_M = 1e-6
"""A corner this far outside still counts as inside, so that equal boxes intersect."""
# Cross product of two edges below which they count as parallel.
_PARALLEL = 1e-9
_KINK = 1e-3
"""Sines and cosines below this value get a smooth absolute value."""


@dataclass(frozen=True)
class BoxPairs:
    """Pairs of upright boxes; each field holds the first and the second boxes."""

    center_m: tuple[Float[Tensor, "pairs 3"], Float[Tensor, "pairs 3"]]
    heading: tuple[Float[Tensor, "pairs 2"], Float[Tensor, "pairs 2"]]
    size_m: tuple[Float[Tensor, "pairs 3"], Float[Tensor, "pairs 3"]]


def exact_iou(pairs: BoxPairs) -> Float[Tensor, " pairs"]:
    """Shared volume over joint volume of each pair, 0 to 1.

    Its slope is zero where one box lies in the other or the two are apart.
    """
    return _over_union(pairs, footprint_intersection(pairs) * _shared_height(pairs))


def soft_iou(pairs: BoxPairs, softness_m: float) -> Float[Tensor, " pairs"]:
    """Surrogate of the IoU with a slope everywhere: `_soft_shared` over the joint volume."""
    return _over_union(pairs, _soft_shared(pairs, softness_m))


def penetration_m(pairs: BoxPairs) -> Float[Tensor, " pairs"]:
    """Distance by which one box has to move to part the two, m; negative if they are apart.

    It is the least overlap along the vertical and along the horizontal axes of either box
    (separating axes). Unlike a volume it has a slope where a thin wall stands entirely in a bed,
    and a slab counts as much as a cupboard.
    """
    overlaps = [*_overlaps(pairs, 0, 1), *_overlaps(pairs, 1, 0), _overlap_up(pairs)]
    return torch.stack(overlaps).amin(dim=0)


def _soft_shared(pairs: BoxPairs, softness_m: float) -> Float[Tensor, " pairs"]:
    """Soft shared volume, m^3.

    It is a product of soft overlaps along the axes of one box, with the other's extent along them,
    averaged over the two boxes. For parallel boxes it goes to the exact one as `softness_m` goes to
    0; for turned boxes it is larger.
    """
    lower = torch.minimum(pairs.size_m[0][:, 2], pairs.size_m[1][:, 2])
    up = _soft(_overlap_up(pairs), lower, softness_m)
    area = (_soft_area(pairs, 0, 1, softness_m) + _soft_area(pairs, 1, 0, softness_m)) / 2
    return area * up


def _over_union(pairs: BoxPairs, shared: Tensor) -> Tensor:
    volume = pairs.size_m[0].prod(-1) + pairs.size_m[1].prod(-1)
    return shared / (volume - shared).clamp(min=1e-9)


def _shared_height(pairs: BoxPairs) -> Tensor:
    low, high = (
        [c[:, 2] + side * s[:, 2] / 2 for c, s in zip(pairs.center_m, pairs.size_m, strict=True)]
        for side in (-1, 1)
    )
    return (torch.minimum(*high) - torch.maximum(*low)).clamp(min=0)


def _overlap_up(pairs: BoxPairs) -> Tensor:
    """Overlap of the heights; negative if one box is above the other."""
    apart = (pairs.center_m[0][:, 2] - pairs.center_m[1][:, 2]).abs()
    return (pairs.size_m[0][:, 2] + pairs.size_m[1][:, 2]) / 2 - apart


def _soft_area(pairs: BoxPairs, own: int, other: int, softness_m: float) -> Tensor:
    """Soft overlap of the footprints along the axes of one of the boxes."""
    sides = (pairs.size_m[own][:, 0], pairs.size_m[own][:, 1])
    shadows = _shadows(pairs, own, other)
    area = torch.ones_like(sides[0])
    for overlap, side, shadow in zip(_overlaps(pairs, own, other), sides, shadows, strict=True):
        area = area * _soft(overlap, torch.minimum(side, shadow), softness_m)
    return area


def _overlaps(pairs: BoxPairs, own: int, other: int) -> tuple[Tensor, Tensor]:
    """Overlap along the two horizontal axes of one of the boxes; negative for a gap."""
    cos, sin = pairs.heading[own].unbind(-1)
    offset = (pairs.center_m[other] - pairs.center_m[own])[:, :2]
    along = cos * offset[:, 0] + sin * offset[:, 1]
    across = cos * offset[:, 1] - sin * offset[:, 0]
    ahead, aside = _shadows(pairs, own, other)
    size = pairs.size_m[own]
    return (
        (size[:, 0] + ahead) / 2 - along.abs(),
        (size[:, 1] + aside) / 2 - across.abs(),
    )


def _shadows(pairs: BoxPairs, own: int, other: int) -> tuple[Tensor, Tensor]:
    """Extents of the other box along the horizontal axes of one box."""
    cos, sin = pairs.heading[own].unbind(-1)
    turned = pairs.heading[other]
    c = _smooth_abs(cos * turned[:, 0] + sin * turned[:, 1])
    s = _smooth_abs(cos * turned[:, 1] - sin * turned[:, 0])
    a, b = pairs.size_m[other][:, 0], pairs.size_m[other][:, 1]
    return c * a + s * b, s * a + c * b


def _smooth_abs(x: Tensor) -> Tensor:
    """Absolute value without a kink, and never smaller than the true one.

    Two boxes that should be parallel are so only up to rounding. With a kink, the sign of the
    rounding error would turn one of them.
    """
    size = x.abs()
    return torch.where(size < _KINK, (x * x / _KINK + _KINK) / 2, size)


def _soft(overlap_m: Tensor, most_m: Tensor, softness_m: float) -> Tensor:
    """Smooth form of the overlap, clipped to between 0 and the smaller extent."""
    below = softplus(overlap_m / softness_m) - softplus((overlap_m - most_m) / softness_m)
    return below * softness_m


def footprint_intersection(pairs: BoxPairs) -> Float[Tensor, " pairs"]:
    """Area that two turned rectangles share, m^2.

    The corners of the shared polygon are those corners of either rectangle that lie in the other,
    and the crossings of their edges. Sorted by angle about their mean they give the area by the
    shoelace formula.
    """
    first, second = (_corners(pairs, which) for which in (0, 1))
    crossings, crosses = _crossings(first, second)
    points = torch.cat([first, second, crossings], dim=1)
    valid = torch.cat([_is_in(first, pairs, 1), _is_in(second, pairs, 0), crosses], dim=1)
    weight = valid.to(points)[..., None]
    middle = (points * weight).sum(1, keepdim=True) / weight.sum(1, keepdim=True).clamp(min=1)
    # Points that are no corners move onto one that is, where they span no area.
    first_valid = valid.to(torch.uint8).argmax(dim=1)
    spare = points.gather(1, first_valid[:, None, None].expand(-1, 1, 2))
    points = torch.where(valid[..., None], points, spare) - middle
    # Detached: the order of the corners has no slope.
    angle = torch.atan2(points[..., 1].detach(), points[..., 0].detach())
    order = angle.argsort(dim=1)[..., None].expand(-1, -1, 2)
    ring = points.gather(1, order)
    after = ring.roll(-1, dims=1)
    area = (ring[..., 0] * after[..., 1] - ring[..., 1] * after[..., 0]).sum(1) / 2
    return torch.where(valid.sum(1) >= 3, area, 0.0).clamp(min=0)


def _corners(pairs: BoxPairs, which: int) -> Float[Tensor, "pairs 4 2"]:
    cos, sin = pairs.heading[which].unbind(-1)
    along = torch.stack([cos, sin], -1) * pairs.size_m[which][:, :1] / 2
    across = torch.stack([-sin, cos], -1) * pairs.size_m[which][:, 1:2] / 2
    corners = [a * along + b * across for a, b in _CORNERS]
    return pairs.center_m[which][:, None, :2] + torch.stack(corners, dim=1)


def _is_in(
    points: Float[Tensor, "pairs k 2"], pairs: BoxPairs, which: int
) -> Bool[Tensor, "pairs k"]:
    cos, sin = pairs.heading[which][:, None].unbind(-1)
    offset = points - pairs.center_m[which][:, None, :2]
    half = pairs.size_m[which][:, None, :2] / 2 + _TOUCH_M
    along = cos * offset[..., 0] + sin * offset[..., 1]
    across = cos * offset[..., 1] - sin * offset[..., 0]
    return (along.abs() <= half[..., 0]) & (across.abs() <= half[..., 1])


def _crossings(
    first: Float[Tensor, "pairs 4 2"], second: Float[Tensor, "pairs 4 2"]
) -> tuple[Float[Tensor, "pairs 16 2"], Bool[Tensor, "pairs 16"]]:
    """Return the points where each edge of one meets each of the other, and whether they do."""
    start, edge = first[:, :, None], (first.roll(-1, dims=1) - first)[:, :, None]
    other, other_edge = second[:, None], (second.roll(-1, dims=1) - second)[:, None]
    turn = _cross(edge, other_edge)
    is_parallel = turn.abs() < _PARALLEL
    # Parallel edges would divide by zero; their result is masked below.
    safe = torch.where(is_parallel, 1.0, turn)
    along = _cross(other - start, other_edge.expand_as(other - start)) / safe
    beside = _cross(other - start, edge.expand_as(other - start)) / safe
    meets = ~is_parallel & (along >= 0) & (along <= 1) & (beside >= 0) & (beside <= 1)
    points = start + along[..., None] * edge
    return points.flatten(1, 2), meets.flatten(1, 2)


def _cross(a: Tensor, b: Tensor) -> Tensor:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
