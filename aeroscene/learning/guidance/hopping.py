"""Objects that pushing cannot free take a short hop to the nearest free place that they have.

Pushes are local: a chair between two walls that stand too near is pushed to and fro. It has room
elsewhere in the room, and a hop finds it.
"""

from __future__ import annotations

from math import cos, pi, sin

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.guidance.contacts import Pairs, near_pairs, overlap, pairs_of
from aeroscene.learning.guidance.pushing import Movable
from aeroscene.learning.guidance.tree import turn
from aeroscene.learning.tokens.decode import Boxes

_REACHES_M = (0.2, 0.4, 0.7, 1.1, 1.6, 2.3, 3.2, 4.5)
_N_DIRECTIONS = 16
_CROWDED = 1e3
"""Cost of a metre of overlap relative to a metre of way."""


def hop(
    boxes: Boxes, movable: Movable, may_hop: Bool[Tensor, "batch n"], *, tolerance_m: float
) -> Float[Tensor, "batch n 3"]:
    """Displacements of the lighter one of each overlapping pair, in the axes of the parents, m.

    Overlaps up to the tolerance are left.
    """
    hopped = torch.zeros_like(movable.low_m)
    family = movable.lineage | movable.lineage.transpose(1, 2)
    token = _hoppers(near_pairs(boxes, family, 0.0), movable, may_hop, tolerance_m)
    if len(token) == 0:
        return hopped
    way = _ways(token, movable)
    depth = _worst_overlap(boxes, family, token, movable, way)
    length = way.norm(dim=-1)
    cost = length + _CROWDED * (depth - tolerance_m).clamp(min=0)
    best = cost.argmin(dim=1, keepdim=True)
    is_free = depth.gather(1, best) <= tolerance_m
    chosen = way.gather(1, best[..., None].expand(-1, -1, 3)).squeeze(1)
    hopped.view(-1, 3)[token] = torch.where(is_free, chosen, 0.0)
    return hopped


def _hoppers(
    pairs: Pairs, movable: Movable, may_hop: Tensor, tolerance_m: float
) -> Int[Tensor, " k"]:
    """The lighter of each pair that overlaps, where it may hop, else the other."""
    overlaps = overlap(pairs) > tolerance_m
    first, second = pairs.first[overlaps], pairs.second[overlaps]
    may_hop, lightness = may_hop.reshape(-1), movable.lightness.reshape(-1)
    is_second = (lightness[second] >= lightness[first]) & may_hop[second] | ~may_hop[first]
    token = torch.where(is_second, second, first)
    return token[may_hop[token]].unique()


def _ways(token: Int[Tensor, " k"], movable: Movable) -> Float[Tensor, "k ways 3"]:
    """Where each could hop to, within its bounds, in the axes of its parent."""
    circle = [2 * pi * i / _N_DIRECTIONS for i in range(_N_DIRECTIONS)]
    ways = [(r * cos(a), r * sin(a), 0.0) for r in _REACHES_M for a in circle]
    low, high = movable.low_m.reshape(-1, 3)[token], movable.high_m.reshape(-1, 3)[token]
    return torch.clamp(low.new_tensor(ways), low[:, None], high[:, None])


def _worst_overlap(
    boxes: Boxes,
    family: Bool[Tensor, "batch n n"],
    token: Int[Tensor, " k"],
    movable: Movable,
    way: Float[Tensor, "k ways 3"],
) -> Float[Tensor, "k ways"]:
    """The deepest overlap that each would have after each way, 0 where it has none."""
    n = boxes.mask.shape[1]
    scene, slot = token // n, token % n
    center, reach = boxes.center_enu_m, boxes.size_m[..., :2].norm(dim=-1) / 2
    apart = (center[scene] - center[scene, slot][:, None])[..., :2].norm(dim=-1)
    near = apart < reach[scene] + reach[scene, slot][:, None] + _REACHES_M[-1]
    near &= boxes.mask[scene] & ~family[scene, slot]
    row, other = near.nonzero(as_tuple=True)
    pairs = pairs_of(boxes, token[row], scene[row] * n + other)
    in_world = turn(way, movable.heading.reshape(-1, 2)[token][:, None])
    along = (pairs.axes * pairs.offset_m[:, None]).sum(-1)
    shift = pairs.axes @ in_world.transpose(1, 2)[row]
    depth = (pairs.reach_m[..., None] - (along[..., None] - shift).abs()).amin(dim=1)
    worst = torch.zeros(len(token), way.shape[1], dtype=way.dtype, device=way.device)
    rows = row[:, None].expand(-1, way.shape[1])
    return worst.scatter_reduce(0, rows, depth, "amax")
