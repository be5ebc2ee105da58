"""The learned baselines: each learns, resumes to the bit, and draws the same scene by the seed."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch

from aeroscene.learning.baselines import diffuscene, diffusion_sdf, presets
from aeroscene.learning.baselines.atiss import Atiss
from aeroscene.learning.baselines.diffuscene import DiffuScene
from aeroscene.learning.baselines.diffusion_sdf import DiffusionSdf
from aeroscene.learning.baselines.fitting import Lessons
from aeroscene.learning.baselines.layouts import LayoutCode, LayoutSet, empty_batch, layouts_of
from aeroscene.learning.baselines.model import BaselineCfg
from aeroscene.learning.baselines.networks.mixture import HALF_BIN, draw_mixture, mixture_loss
from aeroscene.learning.baselines.networks.set_unet import SetUnet
from aeroscene.learning.baselines.physcene import PhyScene, PhysicalGuidance
from aeroscene.learning.baselines.registry import METHODS, fit
from aeroscene.learning.diffusion.loss import diffusion_loss
from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.paper.guidance.collision import collision_loss
from aeroscene.learning.training.config import Budget, TrainingError
from aeroscene.learning.training.presets import preset_sections
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.learning.training.conftest import ten_objects

LEARNED = ("atiss", "diffusion_sdf", "diffuscene", "physcene")
TINY = BaselineCfg(width=16, levels=2, heads=2, steps=4)


@cache
def some_scenes():
    """Not at import: every process of a test run imports this module."""
    return [ten_objects(cached_scene(index)) for index in (7, 42, 49, 311)]


class Patience:
    """Looks on, and stops a training after so many steps."""

    def __init__(self, steps=10**9):
        self.left = steps
        self.n_asked = 0

    def on_progress(self, stage, share, figures):
        del stage, share, figures

    def wants_stop(self):
        self.left -= 1
        self.n_asked += 1
        return self.left <= 0


def lessons(folder, steps, scenes=None):
    scenes = scenes or some_scenes()
    return Lessons(
        folder=folder, name="small", train=scenes, held_out=scenes[:1], budget=Budget(steps=steps)
    )


@pytest.mark.parametrize("name", LEARNED)
def test_a_stopped_training_goes_on_to_the_same_scene(name, tmp_path):
    whole = fit(name, lessons(tmp_path / "whole", 4), Patience(), TINY)
    stopped = fit(name, lessons(tmp_path / "parts", 4), Patience(2), TINY)
    assert not stopped.spent.is_done
    watcher = Patience()
    resumed = fit(name, lessons(tmp_path / "parts", 4), watcher, TINY)
    assert watcher.n_asked == 2
    assert resumed.spent.is_done
    assert (resumed.spent.steps, resumed.spent.parameters) == (4, whole.spent.parameters)
    made = whole.sample(5, "outdoor")
    assert made == whole.sample(5, "outdoor") == resumed.sample(5, "outdoor")
    assert made != whole.sample(6, "outdoor")
    lines = (tmp_path / "parts" / "log.jsonl").read_text().splitlines()
    assert any("held_out" in json.loads(line) for line in lines)
    # A forward pass through every parameter alone is more than this.
    assert whole.spent.flop > 4 * whole.spent.parameters


@pytest.mark.parametrize(
    ("kind", "term"),
    [(Atiss, "total"), (DiffusionSdf, "objects"), (DiffuScene, "reconstruction")],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_a_baseline_learns(kind, term):
    code = LayoutCode.from_scenes(some_scenes())
    data = LayoutSet.from_scenes(some_scenes(), code)
    torch.manual_seed(0)
    # The noise of all channels has to go through.
    model = kind(code, replace(TINY, width=96))
    optimiser = torch.optim.Adam(model.parameters(), lr=3e-3)
    batch = data.in_order(0, len(some_scenes()))

    def loss():
        with torch.no_grad():
            terms = [model(batch, torch.Generator().manual_seed(i))[term] for i in range(8)]
        return float(torch.stack(terms).mean())

    before = loss()
    for step in range(25):
        optimiser.zero_grad()
        model(batch, torch.Generator().manual_seed(100 + step))["total"].backward()
        optimiser.step()
    assert loss() < 0.9 * before


def test_other_data_and_other_sizes_are_refused_on_resuming(tmp_path):
    fit("diffuscene", lessons(tmp_path, 2), Patience(), TINY)
    with pytest.raises(TrainingError, match="is not what the training"):
        fit("diffuscene", lessons(tmp_path, 2, some_scenes()[1:]), Patience(), TINY)
    with pytest.raises(TrainingError, match="another configuration"):
        fit("diffuscene", lessons(tmp_path, 2), Patience(), replace(TINY, width=32))
    with pytest.raises(TrainingError, match="training of diffuscene"):
        fit("diffusion_sdf", lessons(tmp_path, 2), Patience(), TINY)


def test_unknown_methods_domains_and_sizes_are_refused_with_those_that_would_do(tmp_path):
    with pytest.raises(TrainingError, match=f"method is 'gan'; valid: {', '.join(METHODS)}"):
        fit("gan", lessons(tmp_path, 2), Patience(), TINY)
    indoor = [scene for scene in some_scenes() if scene.domain == "indoor"] * 2
    fitted = fit("atiss", lessons(tmp_path, 1, indoor), Patience(), TINY)
    with pytest.raises(TrainingError, match="domain is 'outdoor'; valid: indoor"):
        fitted.sample(0, "outdoor")
    with pytest.raises(TrainingError, match="width is 20; valid: a multiple of 16"):
        BaselineCfg(width=20)


def test_mixtures_sum_to_one_over_all_bins_and_draw_what_they_say():
    parameters = torch.randn(1, 1, 30, generator=torch.Generator().manual_seed(0))
    bins = torch.arange(-60, 60, 2 * HALF_BIN)[:, None]
    shares = (-mixture_loss(parameters.expand(len(bins), 1, 30), bins)).exp()
    assert float(shares.sum()) == pytest.approx(1.0, abs=1e-3)
    generator = torch.Generator().manual_seed(1)
    draws = torch.cat([draw_mixture(parameters[0], generator) for _ in range(4000)])
    mean = float((shares[:, None] * bins).sum())
    assert float(draws.mean()) == pytest.approx(mean, abs=0.15)


def test_signed_distances_are_those_of_boxes():
    code = LayoutCode.from_scenes(some_scenes())
    data = LayoutSet.from_scenes(some_scenes()[:1], code)
    batch = data.in_order(0, 1)
    (boxes,) = layouts_of(some_scenes()[:1])
    rng = np.random.default_rng(0)
    inside = boxes.center_enu_m + rng.uniform(-0.1, 0.1, boxes.size_m.shape) * boxes.size_m
    points = np.concatenate([rng.uniform(-20, 20, (30, 3)), inside])
    reader = diffusion_sdf.LayoutReader(code)
    layout = reader(batch.x0, batch)
    found = diffusion_sdf._signed_distances_m(
        layout, batch, torch.from_numpy(points).float()[None]
    )[0].numpy()
    is_coarse = np.array([obj.is_coarse for obj in some_scenes()[0].objects])
    by_category = {obj.category_id: obj.is_coarse for obj in some_scenes()[0].objects}
    for row, point in enumerate(points):
        for column, level in enumerate((True, False)):
            true = min(
                [
                    signed_distance(boxes, i, point)
                    for i in range(len(boxes.category))
                    if by_category[int(boxes.category[i])] == level
                ],
                default=4.0,
            )
            assert found[row, column] == pytest.approx(np.clip(true, -4, 4), abs=2e-3)
    assert is_coarse.any()


def signed_distance(boxes, i, point):
    c, s = np.cos(boxes.yaw_rad[i]), np.sin(boxes.yaw_rad[i])
    x, y, z = point - boxes.center_enu_m[i]
    beyond = np.abs([c * x + s * y, c * y - s * x, z]) - boxes.size_m[i] / 2
    return np.linalg.norm(np.maximum(beyond, 0)) + min(beyond.max(), 0)


def test_physical_guidance_parts_objects_in_the_last_steps_and_resizes_nothing():
    code = LayoutCode.from_scenes(some_scenes())
    model = PhyScene(code, TINY)
    batch = LayoutSet.from_scenes(some_scenes()[:1], code).in_order(0, 1)
    x = batch.x0.clone()
    # All in one place, but for their heights.
    x[..., :2] = 0.01 * torch.randn(x[..., :2].shape, generator=torch.Generator().manual_seed(0))
    guidance = model.guidance
    assert isinstance(guidance, PhysicalGuidance)

    def overlap(layout):
        read = model.read(layout, batch)
        return float(collision_loss(read, tolerance=0.0, kind="soft", softness_m=0.1))

    last = Moment(99, 100, 0.01, 0.99, None)
    moved = x
    for _ in range(10):
        moved = guidance.on_mean(moved, moved, batch, last)
    assert overlap(moved) < 0.8 * overlap(x)
    assert torch.equal(moved[..., 3:6], x[..., 3:6])
    assert torch.equal(moved[..., 8:], x[..., 8:])
    assert torch.equal(guidance.on_mean(x, x, batch, Moment(10, 100, 0.9, 0.1, None)), x)


def test_values_far_from_every_mean_still_pull_at_it():
    parameters = torch.zeros(1, 1, 30)
    parameters[..., 20:] = -4.0
    parameters.requires_grad_()
    for value in (-3.0, 3.0):
        (gradient,) = torch.autograd.grad(
            mixture_loss(parameters, torch.full((1, 1), value)).sum(), parameters
        )
        assert torch.sign(gradient[..., 10:20]).unique().item() == -np.sign(value)
    sides = [mixture_loss(parameters, torch.full((1, 1), value)).item() for value in (-3.0, 3.0)]
    assert sides[0] == pytest.approx(sides[1], rel=1e-5)


def test_atiss_reads_no_slots_that_nobody_fills():
    code = replace(LayoutCode.from_scenes(some_scenes()), n_slots=64)
    model = Atiss(code, TINY)
    read = []
    model.encoder.register_forward_pre_hook(lambda _, args: read.append(args[0].shape[1]))
    batch = LayoutSet.from_scenes(some_scenes(), code).in_order(0, len(some_scenes()))
    for seed in range(8):
        model(batch, torch.Generator().manual_seed(seed))
    # A query and the domain stand before the objects.
    assert max(read) <= 2 + int(batch.mask.sum(1).max())


def test_the_code_of_a_layout_knows_the_order_in_which_it_is_read():
    code = LayoutCode.from_scenes(some_scenes())
    model = DiffusionSdf(code, TINY)
    batch = LayoutSet.from_scenes(some_scenes()[:1], code).in_order(0, 1)
    other = batch.x0.clone()
    other[:, :2] = batch.x0[:, :2].flip(1)
    assert not torch.allclose(model._encode(batch.x0)[0], model._encode(other)[0], atol=1e-4)


def test_geometry_weighs_as_much_as_the_many_channels_of_categories(monkeypatch):
    code = LayoutCode.from_scenes(some_scenes())
    model = DiffuScene(code, TINY)
    weights = []

    def looked_at(denoiser, batch, *args):
        weights.append(batch.weight)
        return diffusion_loss(denoiser, batch, *args)

    monkeypatch.setattr(diffuscene, "diffusion_loss", looked_at)
    model(
        LayoutSet.from_scenes(some_scenes(), code).in_order(0, 4), torch.Generator().manual_seed(0)
    )
    geometry, categories = weights[0][..., :8].sum(), weights[0][..., 8:].sum()
    assert float(geometry) == pytest.approx(float(categories), rel=1e-4)


def test_the_vectors_of_a_code_are_told_apart_by_their_places():
    model = DiffusionSdf(LayoutCode.from_scenes(some_scenes()), TINY)
    code = torch.randn(1, 16, 32, generator=torch.Generator().manual_seed(0))
    assert not torch.allclose(model._decode(code), model._decode(code.flip(1)), atol=1e-4)


def test_what_is_read_soon_goes_through_to_what_is_predicted():
    torch.manual_seed(0)
    network = SetUnet(40, 8, 48, 2, 4)
    optimiser = torch.optim.Adam(network.parameters(), lr=3e-3)
    batch = empty_batch([0] * 8, 8)
    for _ in range(60):
        x_t = torch.randn(8, 8, 40)
        loss = (network(x_t, torch.ones(8), batch).output - x_t).square().mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    assert loss.item() < 0.3


def test_the_papers_preset_has_steps_enough_for_minutes():
    sections = presets._sections("paper", 360.0, 5)
    cfg = sections["training"]
    assert (cfg.batch_size, cfg.learning_rate, cfg.keep, cfg.seed) == (64, 1e-3, "best", 5)
    assert sections["loss"] == preset_sections("paper")["loss"]


def test_where_objects_stand_is_heard_in_a_new_code():
    torch.manual_seed(0)
    model = DiffusionSdf(LayoutCode.from_scenes(some_scenes()), replace(TINY, width=96))
    batch = LayoutSet.from_scenes(some_scenes(), model.code).in_order(0, len(some_scenes()))
    moved = batch.x0.clone()
    moved[..., :2] += torch.randn(moved[..., :2].shape) * batch.mask[..., None]
    (before, log_variance), (after, _) = model._encode(batch.x0), model._encode(moved)
    noise = (log_variance / 2).exp().mean()
    assert (after - before).std().item() > 0.5 * noise.item()
