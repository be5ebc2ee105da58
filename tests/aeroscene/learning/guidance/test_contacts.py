import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.learning.guidance.contacts import near_pairs, overlap, pairs_of
from aeroscene.learning.tokens.decode import Boxes
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.geometry import penetration_depth as reference_depth


def _boxes(seed: int, n: int, n_scenes: int = 2) -> Boxes:
    generator = torch.Generator().manual_seed(seed)

    def rand(*shape: int) -> torch.Tensor:
        return torch.rand(n_scenes, n, *shape, generator=generator, dtype=torch.float64)

    yaw = 6.3 * rand()
    return Boxes(
        center_enu_m=rand(3) * torch.tensor([8.0, 8.0, 2.0]),
        heading=torch.stack([yaw.cos(), yaw.sin()], dim=-1),
        size_m=0.1 + 3 * rand(3),
        play_m=torch.ones(n_scenes, n, 2),
        rise_m=torch.ones(n_scenes, n),
        openings_m=torch.zeros(n_scenes, n, 7),
        mask=rand() < 0.9,
    )


def _reference(boxes: Boxes, token: int) -> tuple:
    scene, slot = divmod(token, boxes.mask.shape[1])
    yaw = float(torch.atan2(*boxes.heading[scene, slot].flip(0)))
    center, size = boxes.center_enu_m[scene, slot], boxes.size_m[scene, slot]
    return center.tolist(), quat_from_yaw(yaw), size.tolist()


@settings(max_examples=20)
@given(st.integers(0, 1000))
def test_depth_is_that_of_the_geometry_module(seed):
    boxes = _boxes(seed, 6)
    first, second = torch.tensor([0, 0, 3, 6, 8]), torch.tensor([1, 5, 4, 7, 11])
    got = overlap(pairs_of(boxes, first, second))
    pairs = zip(first.tolist(), second.tolist(), strict=True)
    expected = [reference_depth(*_reference(boxes, a), *_reference(boxes, b)) for a, b in pairs]
    assert got.tolist() == pytest.approx(np.array(expected).tolist(), abs=1e-7)


@settings(max_examples=20)
@given(st.integers(0, 1000))
def test_near_pairs_miss_no_overlap_and_hold_nothing_excluded(seed):
    n = 10
    boxes = _boxes(seed, n)
    excluded = torch.zeros(2, n, n, dtype=torch.bool)
    excluded[:, 2, 3] = excluded[:, 3, 2] = True
    pairs = near_pairs(boxes, excluded, 0.0)
    found = set(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True))
    for scene in range(2):
        for i in range(n):
            for j in range(i + 1, n):
                a, b = scene * n + i, scene * n + j
                depth = float(overlap(pairs_of(boxes, torch.tensor([a]), torch.tensor([b]))))
                is_there = bool(boxes.mask[scene, i] and boxes.mask[scene, j])
                is_wanted = depth > 0 and is_there and (i, j) != (2, 3)
                if is_wanted:
                    assert (a, b) in found
                if not is_there or (i, j) == (2, 3):
                    assert (a, b) not in found


def test_margin_widens_what_is_watched():
    boxes = _boxes(0, 12)
    none = torch.zeros(2, 12, 12, dtype=torch.bool)
    counts = [len(near_pairs(boxes, none, margin)) for margin in (0.0, 1.0, 100.0)]
    there = boxes.mask.sum(1)
    assert counts[0] < counts[1] < counts[2] == int((there * (there - 1) // 2).sum())
