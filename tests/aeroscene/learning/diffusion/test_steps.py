import math
from itertools import pairwise

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.diffusion.config import ScheduleCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.diffusion.steps import (
    Level,
    ddim_step,
    ddpm_step,
    dpm_solver_step,
    levels,
    noise_in,
)
from tests.aeroscene.learning.diffusion.layouts import GaussianDenoiser, blank_batch

times = st.tuples(st.floats(0.02, 0.98), st.floats(0.02, 0.98)).filter(
    lambda pair: pair[0] - pair[1] > 1e-3
)


def _levels(*time: float, kind: str = "cosine") -> list[Level]:
    return levels(Schedule(ScheduleCfg(kind=kind)), torch.tensor(time, dtype=torch.float64))


def _layouts(seed: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    x, x0 = torch.randn((2, 1, 4, 3), dtype=torch.float64, generator=generator)
    return x, x0


@given(times, st.sampled_from(["linear", "cosine"]), st.integers(0, 1000))
def test_the_papers_mean_in_eps_is_the_posterior_mean_in_x0(pair, kind, seed):
    """Ho et al. 2020, eq. (7), against the paper's mu_theta."""
    at, to = _levels(*pair, kind=kind)
    x, x0 = _layouts(seed)
    abar_t, abar_s = at.alpha**2, to.alpha**2
    beta = 1 - abar_t / abar_s
    posterior = (
        abar_s**0.5 * beta / (1 - abar_t) * x0
        + (abar_t / abar_s) ** 0.5 * (1 - abar_s) / (1 - abar_t) * x
    )
    mean, std = ddpm_step(x, x0, at, to, "small")
    assert torch.allclose(mean, posterior, atol=1e-8)
    assert std**2 == pytest.approx((1 - abar_s) / (1 - abar_t) * beta, abs=1e-12)
    assert ddpm_step(x, x0, at, to, "large")[1] ** 2 == pytest.approx(beta)


@given(times, st.integers(0, 1000))
def test_the_posterior_follows_from_conditioning_a_gaussian(pair, seed):
    """q(x_s | x_t, x0) from the joint covariance of x_s and x_t given x0."""
    at, to = _levels(*pair)
    x, x0 = _layouts(seed)
    cross = at.alpha / to.alpha * to.sigma**2
    mean, std = ddpm_step(x, x0, at, to, "small")
    gain = cross / at.sigma**2
    assert torch.allclose(mean, to.alpha * x0 + gain * (x - at.alpha * x0), atol=1e-8)
    assert std**2 == pytest.approx(to.sigma**2 - gain * cross, abs=1e-10)


@given(times, st.integers(0, 1000))
def test_ddim_of_full_eta_is_ddpm(pair, seed):
    at, to = _levels(*pair)
    x, x0 = _layouts(seed)
    mean, std = ddim_step(x, x0, at, to, 1.0)
    expected, expected_std = ddpm_step(x, x0, at, to, "small")
    assert torch.allclose(mean, expected, atol=1e-8)
    assert std == pytest.approx(expected_std)


@given(times, st.integers(0, 1000))
def test_deterministic_steps_keep_a_constant_layout_and_its_noise(pair, seed):
    """With the same x0 said everywhere both first-order steps are exact, and are the same."""
    at, to = _levels(*pair)
    x, x0 = _layouts(seed)
    by_ddim = ddim_step(x, x0, at, to, 0.0)[0]
    by_solver = dpm_solver_step(x, x0, at, to, None)[0]
    assert torch.allclose(by_ddim, to.alpha * x0 + to.sigma * noise_in(x, x0, at))
    assert torch.allclose(by_solver, by_ddim, atol=1e-9)
    again = dpm_solver_step(x, x0, at, to, (x0, _levels(0.99)[0]))[0]
    assert torch.allclose(again, by_ddim, atol=1e-9)


def test_every_sampler_ends_on_the_predicted_layout():
    at, to = _levels(0.05, 0.0)
    x, x0 = _layouts(0)
    before = (x, _levels(0.1)[0])
    for mean, std in (
        ddpm_step(x, x0, at, to, "large"),
        ddim_step(x, x0, at, to, 0.5),
        dpm_solver_step(x, x0, at, to, before),
    ):
        assert torch.allclose(mean, x0)
        assert std == 0


def _flow_error(n_steps: int, *, is_second_order: bool) -> float:
    """Of following the flow of Gaussian layouts between two noisy times, at the worst token."""
    schedule = Schedule()
    model = GaussianDenoiser(0.8, 0.4, schedule, "x0")
    path = levels(schedule, torch.linspace(0.9, 0.1, n_steps + 1, dtype=torch.float64))
    start = torch.randn(1, 50, 4, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    batch = blank_batch(1, 50, 4)
    x, before = start, None
    for at, to in pairwise(path):
        x0 = model(x, torch.tensor([at.time], dtype=torch.float64), batch).output
        if is_second_order:
            x = dpm_solver_step(x, x0, at, to, before)[0]
        else:
            x = ddim_step(x, x0, at, to, 0.0)[0]
        before = (x0, at)
    quantile = (model.endpoint(start, path[0].alpha, path[0].sigma) - 0.8) / 0.4
    exact = (
        path[-1].alpha * 0.8
        + (path[-1].alpha ** 2 * 0.4**2 + path[-1].sigma ** 2) ** 0.5 * quantile
    )
    return float((x - exact).abs().max())


@pytest.mark.parametrize(("is_second_order", "order"), [(False, 1), (True, 2)])
def test_deterministic_samplers_converge_at_their_order(is_second_order, order):
    errors = [_flow_error(n, is_second_order=is_second_order) for n in (40, 80, 160)]
    for coarse, fine in pairwise(errors):
        assert math.log2(coarse / fine) == pytest.approx(order, abs=0.2)
