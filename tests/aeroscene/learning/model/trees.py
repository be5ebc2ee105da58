"""Random trees of tokens, made by hand: no corpus is needed to test a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import Tensor

from aeroscene.learning.batch import TokenBatch

N_KINDS, N_SHAPES = 12, 6


def tree_batch(
    counts: Sequence[tuple[int, int]], slots: tuple[int, int], seed: int = 0, channels: int = 19
) -> TokenBatch:
    """Scenes with random trees.

    Args:
        counts: Coarse tokens (the site among them) and fine tokens of each scene.
        slots: Coarse and fine slots of the batch.
        seed: Of the draws; scene by scene, so that padding changes no draw.
        channels: Channels of x0.
    """
    scenes = [_scene(*pair, seed + i, channels) for i, pair in enumerate(counts)]
    padded = [_padded(scene, pair, slots) for scene, pair in zip(scenes, counts, strict=True)]
    whole = {name: torch.stack([scene[name] for scene in padded]) for name in padded[0]}
    generator = torch.Generator().manual_seed(seed)
    n = len(counts)
    return TokenBatch(
        **whole,
        domain=torch.randint(0, 3, (n,), generator=generator),
        wish=torch.randn(n, 3, generator=generator),
        n_coarse_slots=slots[0],
    )


def permuted(batch: TokenBatch, order: Tensor) -> TokenBatch:
    """The same scenes with slots in another order: slot i holds what slot order[i] held."""
    place = torch.empty_like(order)
    place[order] = torch.arange(len(order))
    moved = {
        name: getattr(batch, name)[:, order]
        for name in ("kind", "depth", "ordinal", "twin", "mask", "x0", "weight", "extra")
    }
    return replace(batch, **moved, parent=place[batch.parent[:, order]])


def _scene(n_coarse: int, n_fine: int, seed: int, channels: int) -> dict[str, Tensor]:
    generator = torch.Generator().manual_seed(seed)
    n = n_coarse + n_fine
    parent, depth = torch.zeros(2, n, dtype=torch.long).unbind(0)
    for i in range(1, n):
        below = i if i < n_coarse or torch.rand((), generator=generator) < 0.3 else n_coarse
        parent[i] = torch.randint(0, below, (), generator=generator)
        depth[i] = depth[parent[i]] + 1
    return {
        "kind": torch.randint(0, N_KINDS, (n,), generator=generator),
        "parent": parent,
        "depth": depth,
        "ordinal": torch.randint(0, 64, (n,), generator=generator),
        "twin": torch.randint(0, 64, (n,), generator=generator),
        "mask": torch.ones(n, dtype=torch.bool),
        "x0": torch.randn(n, channels, generator=generator),
        "weight": torch.ones(n, channels),
        "extra": torch.randint(0, N_SHAPES, (n, 3), generator=generator),
    }


def _padded(
    scene: dict[str, Tensor], counts: tuple[int, int], slots: tuple[int, int]
) -> dict[str, Tensor]:
    slot = torch.cat([torch.arange(counts[0]), slots[0] + torch.arange(counts[1])])
    scene = scene | {"parent": slot[scene["parent"]]}
    padded = {}
    for name, value in scene.items():
        padded[name] = torch.zeros((sum(slots), *value.shape[1:]), dtype=value.dtype)
        padded[name][slot] = value
    return padded
