from dataclasses import replace

import pytest
import torch

from aeroscene.learning.diffusion.config import DiffusionError, SamplerCfg, ScheduleCfg
from aeroscene.learning.diffusion.sampling import Fixed, Moment, sample, sampling_times
from aeroscene.learning.diffusion.schedule import Schedule, normal_like
from tests.aeroscene.learning.diffusion.layouts import GaussianDenoiser, blank_batch

MEAN, SPREAD = 0.8, 0.4
ALL = ("ddpm", "ddim", "dpm-solver++")


def _denoiser(schedule: Schedule, parameterisation: str = "v") -> GaussianDenoiser:
    return GaussianDenoiser(MEAN, SPREAD, schedule, parameterisation)


def _generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def _error(kind: str, n_steps: int) -> float:
    """Distance from where the exact flow takes the same noise."""
    schedule, batch = Schedule(), blank_batch(1, 50, 4)
    model = _denoiser(schedule)
    cfg = SamplerCfg(kind=kind, n_steps=n_steps)
    got = sample(model, batch, schedule, cfg, _generator())
    alpha, sigma = schedule.signal_and_noise(torch.ones(1, dtype=torch.float64))
    noise = normal_like(batch.weight, _generator())
    exact = model.endpoint(noise, float(alpha), float(sigma))
    return float((got - exact).abs().max())


def test_dpm_solver_at_twenty_steps_beats_ddim_at_eighty():
    assert _error("dpm-solver++", 20) < _error("ddim", 80) < 0.03


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("parameterisation", ["eps", "v", "x0"])
def test_samples_have_the_moments_of_the_data(kind, parameterisation):
    schedule, batch = Schedule(ScheduleCfg(kind="linear")), blank_batch(8, 300, 4)
    # The posterior's variance is that of a known x0: with wide steps it is too small.
    n_steps = 400 if kind == "ddpm" else 50
    cfg = SamplerCfg(kind=kind, n_steps=n_steps, parameterisation=parameterisation)
    got = sample(_denoiser(schedule, parameterisation), batch, schedule, cfg, _generator(3))
    assert float(got.mean()) == pytest.approx(MEAN, abs=0.03)
    assert float(got.std()) == pytest.approx(SPREAD, abs=0.03)


@pytest.mark.parametrize("kind", ALL)
def test_same_seed_same_layouts(kind):
    schedule, batch = Schedule(), blank_batch(2, 10, 3)
    cfg = SamplerCfg(kind=kind, n_steps=5, eta=0.5)
    first, again, other = (
        sample(_denoiser(schedule), batch, schedule, cfg, _generator(seed)) for seed in (4, 4, 5)
    )
    assert torch.equal(first, again)
    assert not torch.allclose(first, other, atol=0.01)


@pytest.mark.parametrize("kind", ALL)
def test_fixed_channels_come_out_exactly_and_are_noised_truth_on_the_way(kind):
    schedule, batch = Schedule(), blank_batch(3, 8, 2)
    truth = torch.rand(3, 8, 2, dtype=torch.float64, generator=_generator()) * 7 - 3
    mask = torch.zeros(3, 8, 2, dtype=torch.bool)
    mask[:, :4] = True
    mask[:, 4, 0] = True
    noises = []

    def look(at: Moment, x_t: torch.Tensor, x0: torch.Tensor) -> None:
        assert torch.equal(x0[mask], truth[mask])
        noise = (x_t - at.alpha_bar**0.5 * truth) / (1 - at.alpha_bar) ** 0.5
        noises.append(noise[mask])

    cfg = SamplerCfg(kind=kind, n_steps=6)
    got = sample(
        _denoiser(schedule),
        batch,
        schedule,
        cfg,
        _generator(),
        fixed=Fixed(mask, truth),
        on_step=look,
    )
    assert torch.equal(got[mask], truth[mask])
    assert not torch.allclose(got[~mask], truth[~mask])
    assert len(noises) == 6
    assert all(torch.allclose(noise, noises[0], atol=1e-6) for noise in noises)


def test_what_has_no_weight_stays_at_zero():
    schedule, batch = Schedule(), blank_batch(2, 6, 3)
    weight = batch.weight.clone()
    weight[:, 4:] = 0
    weight[:, :, 2] = 0
    cfg = SamplerCfg(kind="ddpm", n_steps=5)
    got = sample(_denoiser(schedule), replace(batch, weight=weight), schedule, cfg, _generator())
    assert (got[weight == 0] == 0).all()
    assert (got[weight > 0] != 0).all()


def test_prediction_is_clipped_to_the_range_of_training():
    schedule, batch = Schedule(), blank_batch(4, 50, 2)
    low, high = torch.tensor([0.5, 0.7]), torch.tensor([0.9, 1.0])
    cfg = SamplerCfg(n_steps=8)
    got = sample(_denoiser(schedule), batch, schedule, cfg, _generator(), x0_range=(low, high))
    assert (got >= low).all()
    assert (got <= high).all()
    assert (got.amin((0, 1)) == low).all()


def test_guidance_acts_on_the_prediction_and_on_the_mean():
    class Pull:
        def __init__(self, x0: float, mean: float) -> None:
            self.x0, self.mean = x0, mean
            self.seen = []

        def on_x0(self, x0, _, at):
            self.seen.append((at.index, at.is_last))
            return x0 + self.x0

        def on_mean(self, mean, _x_t, _, at):
            return mean + self.mean * (1 - at.alpha_bar) ** 0.5

    schedule, batch = Schedule(), blank_batch(1, 200, 2)
    cfg = SamplerCfg(kind="ddim", n_steps=4)
    plain = sample(_denoiser(schedule), batch, schedule, cfg, _generator())
    on_x0, on_mean = Pull(0.3, 0.0), Pull(0.0, 0.3)
    by_x0 = sample(_denoiser(schedule), batch, schedule, cfg, _generator(), guidance=on_x0)
    by_mean = sample(_denoiser(schedule), batch, schedule, cfg, _generator(), guidance=on_mean)
    assert (by_x0 > plain + 0.3).all()
    assert (by_mean > plain).all()
    assert on_x0.seen == [(0, False), (1, False), (2, False), (3, True)]


@pytest.mark.parametrize("spacing", ["time", "log_snr"])
@pytest.mark.parametrize("kind", ["linear", "cosine"])
def test_times_fall_from_one_to_zero(spacing, kind):
    schedule = Schedule(ScheduleCfg(kind=kind))
    times = sampling_times(schedule, SamplerCfg(n_steps=12, spacing=spacing))
    assert len(times) == 13
    assert times[0] == 1
    assert times[-1] == 0
    assert (times.diff() < 0).all()


def test_equal_log_snr_is_equal():
    schedule = Schedule()
    times = sampling_times(schedule, SamplerCfg(n_steps=12, spacing="log_snr"))[:-1]
    alpha_bar = schedule.alpha_bar(times)
    steps = (alpha_bar / (1 - alpha_bar)).log().diff()
    assert steps.tolist() == pytest.approx([float(steps.mean())] * 11, rel=5e-3)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"kind": "euler"}, "sampler.kind is 'euler'; valid: ddpm, ddim, dpm-solver++"),
        ({"n_steps": 0}, "sampler.n_steps 0 is out of range; valid: 1 to 1000"),
        ({"eta": 1.5}, "sampler.eta 1.5 is out of range; valid: 0 to 1"),
    ],
)
def test_settings_out_of_range_say_what_is_valid(setting, message):
    with pytest.raises(DiffusionError) as error:
        SamplerCfg(**setting)
    assert str(error.value) == message
