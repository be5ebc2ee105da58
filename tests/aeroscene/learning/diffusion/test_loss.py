from dataclasses import replace
from typing import get_args

import pytest
import torch

from aeroscene.learning.diffusion.config import DiffusionError, LossCfg, Parameterisation
from aeroscene.learning.diffusion.loss import Prediction, diffusion_loss, gate_cross_entropy
from aeroscene.learning.diffusion.schedule import Schedule
from tests.aeroscene.learning.diffusion.layouts import GaussianDenoiser, blank_batch

KINDS = get_args(Parameterisation)


def _generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def _batch(n_scenes: int = 16, n: int = 40):
    batch = blank_batch(n_scenes, n, 3, n_coarse=10)
    x0 = 0.8 + 0.4 * torch.randn(n_scenes, n, 3, dtype=torch.float64, generator=_generator(9))
    return replace(batch, x0=x0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("gamma", [None, 5.0])
def test_no_denoiser_beats_the_exact_one(kind, gamma):
    schedule, batch = Schedule(), _batch()
    cfg = LossCfg(parameterisation=kind, min_snr_gamma=gamma)

    def loss(mean: float, spread: float) -> float:
        model = GaussianDenoiser(mean, spread, schedule, kind)
        return float(diffusion_loss(model, batch, schedule, cfg, _generator()).total)

    best = loss(0.8, 0.4)
    assert best < min(loss(0.9, 0.4), loss(0.7, 0.4), loss(0.8, 0.5), loss(0.8, 0.3))


def test_a_silent_network_loses_the_variance_of_the_noise():
    """The paper's L_rec of eps_theta = 0."""

    def silent(x_t, time, batch):
        return Prediction(torch.zeros_like(x_t))

    cfg = LossCfg(parameterisation="eps")
    terms = diffusion_loss(silent, _batch(64), Schedule(), cfg, _generator())
    assert float(terms.reconstruction) == pytest.approx(1.0, abs=0.05)
    assert torch.equal(terms.total, terms.reconstruction)


def test_what_has_no_weight_is_neither_seen_nor_judged():
    batch = _batch()
    weight = batch.weight.clone()
    weight[:, 30:] = 0
    weight[:, :, 1] = 0
    seen = []

    def wrong_there(x_t, time, _):
        seen.append(x_t)
        return Prediction(torch.where(weight > 0, 0.0, 1e6))

    spoilt = torch.where(weight > 0, batch.x0, 1e6)
    cfg = LossCfg(parameterisation="x0")
    whole = replace(batch, weight=weight, x0=spoilt)
    terms = diffusion_loss(wrong_there, whole, Schedule(), cfg, _generator())
    expected = batch.x0[weight > 0].square().mean()
    assert float(terms.total) == pytest.approx(float(expected))
    assert (seen[0][weight == 0] == 0).all()


def test_gate_is_taught_that_tau_is_small_at_coarse_tokens():
    batch = _batch(2, 40)
    right = torch.full((2, 40), 0.9)
    right[:, :10] = 0.1
    assert float(gate_cross_entropy(right, batch)) == pytest.approx(0.105, abs=0.001)
    assert float(gate_cross_entropy(1 - right, batch)) == pytest.approx(2.303, abs=0.001)
    saturated = (right > 0.5).float()
    assert float(gate_cross_entropy(saturated, batch)) < 1e-4
    padded = replace(batch, mask=torch.arange(40).expand(2, 40) < 10)
    assert float(gate_cross_entropy(torch.full((2, 40), 0.1), padded)) < 0.11


def test_guidance_and_gate_enter_with_their_weights():
    batch = _batch()

    def model(x_t, time, _):
        return Prediction(torch.zeros_like(x_t), torch.full(batch.mask.shape, 0.5, dtype=x_t.dtype))

    def guide(x0, _):
        return x0.square().sum((1, 2))

    cfg = LossCfg(parameterisation="eps", guide_weight=0.01, gate_weight=0.1)
    terms = diffusion_loss(model, batch, Schedule(), cfg, _generator(), guide)
    assert float(terms.guide) > 0
    assert float(terms.gate) == pytest.approx(0.693, abs=0.001)
    total = terms.reconstruction + 0.01 * terms.guide + 0.1 * terms.gate
    assert torch.allclose(terms.total, total)


def test_guidance_on_some_scenes_is_its_mean_over_them():
    batch, seen = _batch(), []

    def model(x_t, time, _):
        return Prediction(torch.zeros_like(x_t))

    def guide(x0, some):
        seen.append((len(x0), some.n_scenes))
        return x0.square().sum((1, 2))

    schedule = Schedule()
    cfg = LossCfg(parameterisation="eps", guide_weight=0.01, guide_scenes=2)
    some = diffusion_loss(model, batch, schedule, cfg, _generator(), guide)
    whole = diffusion_loss(
        model, batch, schedule, replace(cfg, guide_scenes=None), _generator(), guide
    )
    assert seen == [(2, 2), (batch.n_scenes, batch.n_scenes)]
    assert 0 < float(some.guide) != float(whole.guide)
    assert torch.equal(some.reconstruction, whole.reconstruction)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("coarse_weight", -1.0),
        ("guide_weight", float("nan")),
        ("min_snr_gamma", 0.0),
        ("guide_scenes", 0),
        ("small_noise_share", 1.5),
    ],
)
def test_what_is_minimised_stays_in_range(field, value):
    with pytest.raises(DiffusionError, match=rf"{field} .* is out of range; valid: "):
        LossCfg(**{field: value})


def test_gradients_reach_the_network_through_every_term():
    batch = _batch()
    gain = torch.tensor(0.3, dtype=torch.float64, requires_grad=True)

    def model(x_t, time, _):
        return Prediction(gain * x_t, torch.sigmoid(gain * x_t[..., 0]))

    cfg = LossCfg(guide_weight=0.01, gate_weight=0.1)
    terms = diffusion_loss(
        model, batch, Schedule(), cfg, _generator(), lambda x0, _: x0.square().sum((1, 2))
    )
    for term in (terms.reconstruction, terms.guide, terms.gate):
        (slope,) = torch.autograd.grad(term, gain, retain_graph=True)
        assert slope != 0


def test_network_meets_small_noise_as_often_as_is_asked():
    seen = []

    def model(x_t, time, _):
        seen.append(float((time < 0.1).double().mean()))
        return Prediction(torch.zeros_like(x_t))

    batch = _batch(n_scenes=200)
    for share in (0.0, 0.5):
        diffusion_loss(model, batch, Schedule(), LossCfg(small_noise_share=share), _generator())
    assert seen[0] == pytest.approx(0.1, abs=0.01)
    # Log sigma from 0.0064 to 1: about two thirds are below the sigma at t = 0.1, 0.16.
    assert seen[1] == pytest.approx(0.5 * 0.1 + 0.5 * 0.68, abs=0.05)


def test_same_seed_same_loss():
    schedule, batch = Schedule(), _batch()
    model = GaussianDenoiser(0.0, 1.0, schedule, "v")
    first, again, other = (
        float(diffusion_loss(model, batch, schedule, LossCfg(), _generator(seed)).total)
        for seed in (1, 1, 2)
    )
    assert first == again
    assert first != other


def test_a_batch_without_layouts_cannot_be_learned():
    with pytest.raises(ValueError, match=r"batch\.x0 is None; valid: the clean layouts"):
        diffusion_loss(
            lambda *_: Prediction(torch.zeros(1)),
            blank_batch(1, 2, 3),
            Schedule(),
            LossCfg(),
            _generator(),
        )
