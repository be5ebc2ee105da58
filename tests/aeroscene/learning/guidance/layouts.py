"""Layouts and boxes made by hand or at random for tests of guidance."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from aeroscene.learning.paper.guidance.layout import Layout
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import Boxes
from tests.aeroscene.learning.diffusion.layouts import blank_batch


def random_layout(
    seed: int, n: int = 12, n_coarse: int = 4, n_categories: int = 5, n_scenes: int = 2
) -> Layout:
    """Crowded turned boxes."""
    generator = torch.Generator().manual_seed(seed)

    def rand(*shape: int) -> Tensor:
        return torch.rand(n_scenes, n, *shape, generator=generator, dtype=torch.float64)

    yaw = 6.3 * rand()
    return Layout(
        center_enu_m=4 * rand(3) * torch.tensor([1.0, 1.0, 0.3]),
        heading=torch.stack([yaw.cos(), yaw.sin()], dim=-1),
        size_m=0.4 + 2.5 * rand(3),
        category=rand(n_categories),
        mask=torch.arange(n).expand(n_scenes, n) != n - 1,
        is_coarse=torch.arange(n) < n_coarse,
    )


def world_batch(parent: list[int], n_coarse: int) -> TokenBatch:
    """One scene below a site by hand: every channel of the place but the height is free."""
    n = len(parent)
    depth = [0]
    for place in parent[1:]:
        depth.append(depth[place] + 1)
    batch = blank_batch(1, n, 3, n_coarse=n_coarse)
    weight = torch.ones(1, n, 3)
    weight[..., 2] = 0
    weight[:, 0] = 0
    return replace(batch, parent=torch.tensor([parent]), depth=torch.tensor([depth]), weight=weight)


def decode_metres(size_m: Tensor, heading: Tensor, low_m: Tensor):
    """A decoder whose channels are metres in the axes of the parents."""

    def decode(x0: Tensor, batch: TokenBatch) -> Boxes:
        center = torch.zeros_like(x0)
        for slot, place in enumerate(batch.parent[0].tolist()):
            offset = x0[:, slot].clone()
            if slot:
                c, s = heading[:, place].unbind(-1)
                x, y = offset[:, 0], offset[:, 1]
                offset = torch.stack([c * x - s * y, s * x + c * y, offset[:, 2]], dim=-1)
                offset = offset + center[:, place]
            center = torch.cat([center[:, :slot], offset[:, None], center[:, slot + 1 :]], dim=1)
        up = torch.zeros_like(center)
        up[..., 2] = low_m + size_m[..., 2] / 2
        return Boxes(
            center_enu_m=center + up,
            heading=heading,
            size_m=size_m,
            play_m=torch.ones_like(x0[..., :2]),
            rise_m=torch.ones_like(x0[..., 0]),
            openings_m=torch.zeros(*x0.shape[:2], 7),
            mask=batch.mask,
        )

    return decode
