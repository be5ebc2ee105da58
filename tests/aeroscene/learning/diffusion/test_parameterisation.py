from typing import get_args

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.diffusion.config import Parameterisation
from aeroscene.learning.diffusion.parameterisation import (
    min_snr_weight,
    predicted_x0,
    prediction_target,
)
from aeroscene.learning.diffusion.schedule import Schedule

KINDS = get_args(Parameterisation)


def _level(time: float) -> tuple[torch.Tensor, torch.Tensor]:
    return Schedule().signal_and_noise(torch.tensor([time], dtype=torch.float64))


@given(st.sampled_from(KINDS), st.floats(0.001, 0.999), st.integers(0, 1000))
def test_the_true_target_gives_layout_and_noise_back(kind, time, seed):
    x0, eps = torch.randn(
        (2, 1, 3, 2), dtype=torch.float64, generator=torch.Generator().manual_seed(seed)
    )
    alpha, sigma = _level(time)
    x_t = alpha * x0 + sigma * eps
    target = prediction_target(kind, x0, eps, alpha, sigma)
    assert torch.allclose(predicted_x0(kind, target, x_t, alpha, sigma), x0, atol=1e-9)


@given(st.sampled_from(KINDS), st.floats(0.01, 0.99), st.integers(0, 1000))
def test_min_snr_weighs_every_parameterisation_as_one_loss_on_the_layout(kind, time, seed):
    """min(SNR, gamma) |x0 - x0_hat|^2, whatever it is that the network says."""
    x0, eps, error = torch.randn(
        (3, 1, 3, 2), dtype=torch.float64, generator=torch.Generator().manual_seed(seed)
    )
    alpha, sigma = _level(time)
    x_t = alpha * x0 + sigma * eps
    target = prediction_target(kind, x0, eps, alpha, sigma)
    x0_hat = predicted_x0(kind, target + error, x_t, alpha, sigma)
    snr = (alpha / sigma) ** 2
    expected = snr.clamp(max=5.0) * (x0_hat - x0).square().sum()
    got = min_snr_weight(kind, alpha, sigma, 5.0) * error.square().sum()
    assert float(got) == pytest.approx(float(expected), rel=1e-6)
