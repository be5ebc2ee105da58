import math

import pytest
import torch

from aeroscene.learning.diffusion.config import DiffusionError, ScheduleCfg
from aeroscene.learning.diffusion.schedule import Schedule, normal_like

KINDS = ("linear", "cosine")


@pytest.mark.parametrize("kind", KINDS)
def test_forward_process_in_one_step_has_the_moments_of_single_steps(kind):
    """The paper's q(x_t | x_(t-1)), applied step by step to 20,000 copies of one layout."""
    cfg = ScheduleCfg(kind=kind, n_steps=40)
    schedule = Schedule(cfg)
    generator = torch.Generator().manual_seed(0)
    x0 = torch.tensor([[[1.5, -0.7]]], dtype=torch.float64).expand(20_000, 1, 2)
    x = x0
    log = schedule.log_alpha_bar
    for step in range(1, 31):
        beta = -torch.expm1(log[step] - log[step - 1])
        x = (1 - beta).sqrt() * x + beta.sqrt() * normal_like(x, generator)
    time = torch.full((len(x0),), 30 / 40, dtype=torch.float64)
    at_once = schedule.forward_noise(x0, time, normal_like(x0, generator))
    assert torch.allclose(x.mean(0), at_once.mean(0), atol=0.03)
    assert torch.allclose(x.std(0), at_once.std(0), atol=0.03)
    alpha, sigma = schedule.signal_and_noise(time[:1])
    assert torch.allclose(at_once.mean(0), alpha * x0[0], atol=0.03)
    assert torch.allclose(at_once.std(0), sigma.expand(1, 2), atol=0.03)


@pytest.mark.parametrize("kind", KINDS)
def test_alpha_bar_falls_from_one_to_noise(kind):
    alpha_bar = Schedule(ScheduleCfg(kind=kind)).alpha_bar(torch.linspace(0, 1, 2001).double())
    assert alpha_bar[0] == 1
    assert alpha_bar[-1] < 1e-4
    assert (alpha_bar.diff() <= 0).all()


def test_linear_schedule_is_that_of_ho_et_al():
    beta = torch.linspace(1e-4, 0.02, 1000, dtype=torch.float64)
    time = torch.arange(1, 1001, dtype=torch.float64) / 1000
    expected = (1 - beta).cumprod(0)
    assert torch.allclose(Schedule(ScheduleCfg(kind="linear")).alpha_bar(time), expected)


def test_cosine_schedule_is_that_of_nichol_and_dhariwal():
    def power(t: float) -> float:
        return math.cos((t + 0.008) / 1.008 * math.pi / 2) ** 2

    got = Schedule(ScheduleCfg()).alpha_bar(torch.tensor([0.25, 0.5, 0.9], dtype=torch.float64))
    expected = [power(t) / power(0) for t in (0.25, 0.5, 0.9)]
    # But for the trace of signal that is left at t = 1.
    assert got.tolist() == pytest.approx(expected, abs=1.1e-5)


@pytest.mark.parametrize("n_steps", [100, 250, 4000])
def test_linear_schedule_ends_in_the_same_noise_at_any_number_of_steps(n_steps):
    last = Schedule(ScheduleCfg(kind="linear", n_steps=n_steps)).log_alpha_bar[-1]
    assert float(last) == pytest.approx(-10.1, abs=1.1)


def test_stratified_times_fall_one_into_each_part():
    schedule = Schedule()
    time = schedule.draw_time(50, torch.Generator().manual_seed(1), stratified=True)
    # A time is a step's upper end.
    parts = ((time - 0.5 / 1000) * 50).floor()
    assert sorted(parts.tolist()) == list(range(50))
    free = schedule.draw_time(4000, torch.Generator().manual_seed(1), stratified=False)
    assert free.min() >= 1 / 1000
    assert free.max() <= 1
    assert float(free.mean()) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.25, 1.0])
def test_small_noise_has_its_share_of_the_times(kind, share):
    """Each doubling of sigma has as many times as another, beside those that are uniform."""
    schedule = Schedule(ScheduleCfg(kind=kind, n_steps=10_000))
    n = 40_000
    generator = torch.Generator().manual_seed(0)
    time = schedule.draw_time(n, generator, stratified=True, small_noise_share=share)
    assert time.min() >= 1 / 10_000
    assert time.max() <= 1
    _, sigma = schedule.signal_and_noise(time.double())
    every = torch.arange(1, 10_001, dtype=torch.float64) / 10_000
    _, known = schedule.signal_and_noise(every)
    edges = torch.tensor([0.04, 0.08, 0.16, 0.32, 0.64], dtype=torch.float64)
    found = torch.histogram(sigma, edges).hist / n
    uniform = torch.histogram(known, edges).hist / len(known)
    beside = (found - (1 - share) * uniform) / share
    assert beside.max() - beside.min() < 0.004
    assert beside.min() > 0.08


def test_small_noise_is_drawn_from_equal_parts_too():
    schedule = Schedule()
    draws = [
        schedule.draw_time(
            100, torch.Generator().manual_seed(seed), stratified=True, small_noise_share=0.4
        ).sort()[0]
        for seed in range(2)
    ]
    # The same parts of the distribution, so the k-th of each are neighbours.
    _, sigma = schedule.signal_and_noise(torch.stack(draws).double())
    assert (sigma[0, 1:] >= sigma[1, :-1] - 1e-9).all()
    assert (sigma[1, 1:] >= sigma[0, :-1] - 1e-9).all()


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"kind": "square"}, "schedule.kind is 'square'; valid: linear, cosine, log_snr"),
        ({"n_steps": 1}, "schedule.n_steps 1 is out of range; valid: 2 to 10000"),
        (
            {"kind": "linear", "beta_first": 0.03},
            "schedule.beta_first and beta_last are 0.03 and 0.02; valid: 0 < first <= last < 1",
        ),
    ],
)
def test_settings_out_of_range_say_what_is_valid(setting, message):
    with pytest.raises(DiffusionError) as error:
        ScheduleCfg(**setting)
    assert str(error.value) == message


@pytest.mark.parametrize("even_share", [0.0, 0.5])
def test_times_may_be_normal_in_log_snr_and_partly_even(even_share):
    schedule = Schedule(ScheduleCfg(kind="log_snr"))
    generator = torch.Generator().manual_seed(0)
    time = schedule.draw_time(20_000, generator, stratified=True, log_snr=(1.0, 2.0, even_share))
    alpha_bar = schedule.alpha_bar(time.double())
    ratio = torch.log(alpha_bar) - torch.log1p(-alpha_bar)
    first, last = schedule.cfg.log_snr_first, schedule.cfg.log_snr_last
    middle, width = (first + last) / 2, first - last
    mean = 1.0 + even_share * (middle - 1.0)
    within = (1 - even_share) * 4.0 + even_share * width**2 / 12
    variance = within + even_share * (1 - even_share) * (middle - 1.0) ** 2
    assert float(ratio.mean()) == pytest.approx(mean, abs=0.1)
    assert float(ratio.var()) == pytest.approx(variance, rel=0.05)
    # Where the normal density has nothing, the even share trains alone.
    beyond = float((ratio > 9.0).double().mean())
    assert beyond == pytest.approx(even_share * (first - 9.0) / width, abs=0.01)
