"""Layouts and boxes made by hand or at random for tests of guidance."""

from __future__ import annotations

import torch
from torch import Tensor

from aeroscene.learning.paper.guidance.layout import Layout


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
        category=1 + (n_categories * rand()).long(),
        mask=torch.arange(n).expand(n_scenes, n) != n - 1,
        is_coarse=torch.arange(n) < n_coarse,
    )
