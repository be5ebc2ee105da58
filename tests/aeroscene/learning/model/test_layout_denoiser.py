"""The paper's network as a whole."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import LossCfg, ScheduleCfg
from aeroscene.learning.diffusion.loss import diffusion_loss
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.paper.network.attention import ScaleAttention
from aeroscene.learning.paper.network.layout_denoiser import LayoutDenoiser
from aeroscene.learning.paper.training_set import FlatTrainingSet, flat_training_set
from aeroscene.learning.training.paper_preset import paper_cfg
from aeroscene.scene import Scene
from tests.aeroscene.conftest import SAMPLE, cached_scene

SCHEDULE = Schedule(ScheduleCfg(kind="log_snr"))
CFG = replace(
    paper_cfg(70), width=16, unet_widths=(16, 24), grid_shape=(4, 4, 3), grid_channels=6, blocks=2
)


@pytest.fixture(scope="module", params=[False, True], ids=["paper", "progressive"])
def data(request: pytest.FixtureRequest) -> FlatTrainingSet:
    return flat_training_set([cached_scene(n) for n in SAMPLE], has_regions=request.param)


def denoiser(data: FlatTrainingSet, cfg: ModelCfg = CFG, *, is_new: bool = False) -> LayoutDenoiser:
    torch.manual_seed(0)
    network = LayoutDenoiser(cfg, data.statistics, SCHEDULE)
    if not is_new:
        for parameter in network.parameters():
            parameter.data += 0.1 * torch.randn_like(parameter)
    return network


def noisy(batch: TokenBatch, time: float) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    is_free = batch.weight > 0
    eps = torch.randn(batch.x0.shape, generator=torch.Generator().manual_seed(3)) * is_free
    t = torch.full((batch.n_scenes,), time)
    return SCHEDULE.forward_noise(batch.x0 * is_free, t, eps), t, eps


@pytest.mark.parametrize("time", [0.02, 0.3, 0.7, 1.0])
def test_an_untrained_network_is_the_formula_and_better_than_nothing(
    data: FlatTrainingSet, time: float
) -> None:
    """eps = sigma x_t / (alpha_bar v + sigma^2), which no other object is needed for."""
    batch = data.in_order(0, 4)
    x_t, t, eps = noisy(batch, time)
    with torch.no_grad():
        output = denoiser(data, is_new=True)(x_t, t, batch).output
    alpha_bar = SCHEDULE.alpha_bar(t.double())[0].float()
    variance = torch.as_tensor(data.statistics.variance, dtype=torch.float32)[batch.kind]
    formula = (1 - alpha_bar).sqrt() * x_t / (alpha_bar * variance + 1 - alpha_bar)
    is_free = batch.weight > 0
    torch.testing.assert_close(output[is_free], formula[is_free], rtol=1e-3, atol=1e-4)
    error = ((output - eps) ** 2)[is_free].mean()
    assert error < 1.02 * (eps**2)[is_free].mean()
    assert error < 1.02 * ((x_t - eps) ** 2)[is_free].mean()


def test_padding_changes_nothing(data: FlatTrainingSet) -> None:
    network = denoiser(data)
    both, alone = data.in_order(0, 3), [data.in_order(n, 1) for n in (0, 2)]
    x_t, t, _ = noisy(both, 0.4)
    x_t[~both.mask] = 50.0
    with torch.no_grad():
        out = network(x_t, t, both).output
        assert (out[~both.mask] == 0).all()
        for row, single in zip((0, 2), alone, strict=True):
            there = both.mask[row]
            shown = x_t[row][there].unsqueeze(0)
            exact = network(shown, t[:1], single).output[0]
            torch.testing.assert_close(out[row][there], exact, rtol=1e-2, atol=1e-3)


def test_every_parameter_learns_the_threshold_too(data: FlatTrainingSet) -> None:
    batch, network = data.in_order(0, 4), denoiser(data)
    x_t, t, _ = noisy(batch, 0.4)
    with torch.no_grad():
        tau = network(x_t, t, batch).tokenizability
        network.routing.gamma.fill_(tau[batch.mask].median())
    network(x_t, t, batch).output.square().sum().backward()
    for name, parameter in network.named_parameters():
        assert parameter.grad is not None, name
        assert parameter.grad.abs().sum() > 0, name


def test_tokenizability_is_reported_for_real_tokens(data: FlatTrainingSet) -> None:
    batch = data.in_order(0, 3)
    tau = denoiser(data)(*noisy(batch, 0.5)[:2], batch).tokenizability
    assert ((tau > 0) == batch.mask).all()
    assert (tau <= 1).all()


def test_what_is_given_is_seen_clean_whatever_stands_in_its_place(scenes: list[Scene]) -> None:
    data = flat_training_set(scenes, has_regions=True)
    batch, network = data.in_order(0, 1), denoiser(data)
    assert batch.given.any()
    x_t, t, _ = noisy(batch, 0.5)
    with torch.no_grad():
        expected = network(x_t, t, batch).output
        x_t[batch.given] = 7.0
        torch.testing.assert_close(network(x_t, t, batch).output, expected)
        moved = replace(batch, x0=torch.where(batch.given.unsqueeze(-1), batch.x0 + 0.5, batch.x0))
        assert not torch.allclose(network(x_t, t, moved).output, expected)


@pytest.mark.parametrize("routing", ["learned", "given"])
@pytest.mark.parametrize("coarse_branch", ["cnn", "attention"])
@pytest.mark.parametrize("fine_branch", ["radius_gnn", "siblings"])
def test_parts_can_be_exchanged_one_by_one(
    data: FlatTrainingSet, routing: str, coarse_branch: str, fine_branch: str
) -> None:
    cfg = replace(CFG, routing=routing, coarse_branch=coarse_branch, fine_branch=fine_branch)
    batch, network = data.in_order(4, 1), denoiser(data, cfg)
    prediction = network(*noisy(batch, 0.5)[:2], batch)
    assert prediction.output.isfinite().all()
    assert prediction.output.shape == batch.x0.shape
    assert (prediction.tokenizability is None) == (routing == "given")
    assert isinstance(network.coarse, ScaleAttention) == (coarse_branch == "attention")
    assert isinstance(network.fine, ScaleAttention) == (fine_branch == "siblings")


def test_a_few_steps_beat_the_formula_in_every_group(scenes: list[Scene]) -> None:
    """A network that can do no worse soon does better: places, heights, headings and sizes."""
    data = flat_training_set(scenes[:1])
    batch = data.in_order(0, 1)
    cfg = replace(CFG, width=32, unet_widths=(48,))
    torch.manual_seed(0)
    network = LayoutDenoiser(cfg, data.statistics, SCHEDULE)
    optimiser = torch.optim.Adam(network.parameters(), lr=3e-3)
    loss_cfg = LossCfg(parameterisation="eps", log_snr_mean=1.0, weighting="velocity")
    generator = torch.Generator().manual_seed(0)
    many = replace(
        batch,
        **{
            name: value.expand(4, *value.shape[1:])
            for name, value in vars(batch).items()
            if isinstance(value, torch.Tensor)
        },
    )
    for _ in range(60):
        loss = diffusion_loss(network, many, SCHEDULE, loss_cfg, generator).total
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    x_t, t, eps = noisy(batch, 0.6)
    fresh = LayoutDenoiser(cfg, data.statistics, SCHEDULE)
    is_free = batch.weight > 0
    for channels in (slice(0, 2), slice(2, 3), slice(7, 10)):
        errors = []
        for each in (network, fresh):
            with torch.no_grad():
                off = (each(x_t, t, batch).output - eps)[..., channels]
            errors.append(float((off**2)[is_free[..., channels]].mean()))
        assert errors[0] < errors[1], channels


def test_paper_preset_has_at_most_seven_million_parameters(data: FlatTrainingSet) -> None:
    network = LayoutDenoiser(paper_cfg(70), data.statistics, SCHEDULE)
    assert network.cfg.channels == 10
    assert sum(parameter.numel() for parameter in network.parameters()) < 7e6
