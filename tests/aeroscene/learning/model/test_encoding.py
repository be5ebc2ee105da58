"""Fixed encodings."""

from __future__ import annotations

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.model.encoding import TimeEmbedding, fourier_features, sinusoid


@given(st.integers(0, 500), st.integers(0, 7))
def test_sinusoid_is_the_transformer_encoding(position: int, i: int) -> None:
    encoding = sinusoid(torch.tensor([position]), 16)[0]
    angle = position / 10_000 ** (2 * i / 16)
    assert encoding[i] == pytest.approx(math.sin(angle), abs=1e-4)
    assert encoding[8 + i] == pytest.approx(math.cos(angle), abs=1e-4)


def test_first_fourier_band_tells_the_two_borders_apart() -> None:
    west, east = fourier_features(torch.tensor([[-1.0], [1.0]]), 3)
    assert west[0] == pytest.approx(-1.0)
    assert east[0] == pytest.approx(1.0)
    torch.testing.assert_close(west[1:3], east[1:3], atol=1e-5, rtol=0)


@given(st.floats(-1, 1), st.integers(0, 4))
def test_fourier_bands_are_octaves(value: float, band: int) -> None:
    feature = fourier_features(torch.tensor([0.0, value]), 5)
    angle = 0.5 * math.pi * 2**band * value
    assert feature[5 + band] == pytest.approx(math.sin(angle), abs=1e-5)
    assert feature[15 + band] == pytest.approx(math.cos(angle), abs=1e-5)


def test_times_are_told_apart() -> None:
    torch.manual_seed(0)
    first, second = TimeEmbedding(32)(torch.tensor([0.500, 0.501]))
    assert (first - second).abs().max() > 1e-3
