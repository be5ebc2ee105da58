"""What the paper's network sees of a noisy layout."""

from __future__ import annotations

import math

import pytest
import torch

from aeroscene.learning.paper.network.embedding import among_alike, fourier
from aeroscene.learning.paper.training_set import flat_training_set
from aeroscene.scene import Scene

LONGEST, BANDS = 16.0, 5


def test_waves_are_sines_and_cosines_of_what_is_known():
    value = torch.tensor([[[0.7, -2.0]]])
    found = fourier(value, torch.zeros_like(value), LONGEST, BANDS)[0, 0]
    rates = [2 * math.pi / LONGEST * 2**k for k in range(BANDS)]
    angles = [v * rate for v in (0.7, -2.0) for rate in rates]
    expected = [math.sin(a) for a in angles] + [math.cos(a) for a in angles]
    assert found.tolist() == pytest.approx(expected, abs=1e-5)


def test_waves_fade_to_their_mean_over_the_doubt():
    value, doubt = torch.full((1, 1, 1), 0.7), torch.full((1, 1, 1), 0.5)
    found = fourier(value, doubt, LONGEST, BANDS)[0, 0]
    draws = 0.7 + 0.5 * torch.randn(200_000, generator=torch.Generator().manual_seed(0))
    exact = fourier(draws[None, :, None], torch.zeros(1, len(draws), 1), LONGEST, BANDS)[0].mean(0)
    torch.testing.assert_close(found, exact, rtol=0.0, atol=5e-3)
    assert found.reshape(2, BANDS)[:, -1].abs().max() < 0.2


def test_alike_objects_are_counted_from_the_first_and_from_the_last(scenes: list[Scene]):
    batch = flat_training_set(scenes, has_regions=True).in_order(0, 2)
    before, after = among_alike(batch)
    for row in range(2):
        slots = torch.nonzero(batch.mask[row]).flatten().tolist()
        known = [
            (int(batch.kind[row, k]), int(batch.turn[row, k]), int(batch.parent[row, k]))
            for k in slots
        ]
        for i, slot in enumerate(slots):
            assert int(before[row, slot]) == known[:i].count(known[i])
            assert int(after[row, slot]) == known[i + 1 :].count(known[i])
