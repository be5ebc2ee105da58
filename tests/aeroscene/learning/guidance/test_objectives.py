from dataclasses import replace

import pytest
import torch

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import DiffusionError
from aeroscene.learning.paper.guidance.coarse_to_fine import coarse_to_fine_loss
from aeroscene.learning.paper.guidance.collision import collision_loss
from aeroscene.learning.paper.guidance.objectives import Objectives, ObjectivesCfg
from aeroscene.learning.paper.guidance.semantic import (
    SemanticPrior,
    SemanticPriorCfg,
    semantic_loss,
)
from tests.aeroscene.learning.diffusion.layouts import blank_batch
from tests.aeroscene.learning.guidance.layouts import random_layout

MIDWAY = Moment(5, 10, 0.5, 0.36, None)


def _read(x, batch):
    """Channels: place and the first category's weight."""
    layout = random_layout(0)
    category = torch.cat([x[..., 3:], layout.category[..., 1:]], dim=-1)
    return replace(layout, center_enu_m=x[..., :3], category=category)


def _prior() -> SemanticPrior:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        return SemanticPrior(SemanticPriorCfg(n_categories=5, width=8)).double()


def _state():
    layout = random_layout(0)
    return torch.cat([layout.center_enu_m, layout.category[..., :1]], dim=-1)


BATCH = blank_batch(2, 12, 4, n_coarse=4)


@pytest.mark.parametrize("iou", ["exact", "soft"])
@pytest.mark.parametrize("region_distance", ["centroid", "border"])
def test_gradient_of_all_three_is_that_of_finite_differences(iou, region_distance):
    objectives = Objectives(
        _read, ObjectivesCfg(iou=iou, region_distance=region_distance), _prior()
    )
    x = _state().requires_grad_()
    (gradient,) = torch.autograd.grad(objectives.loss(x, BATCH).sum(), x)
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for _ in range(10):
            direction = torch.randn(x.shape, generator=generator, dtype=x.dtype)
            step = 1e-6 * direction
            slope = (objectives.loss(x + step, BATCH) - objectives.loss(x - step, BATCH)).sum()
            expected = float((gradient * direction).sum())
            assert float(slope) / 2e-6 == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_combined_loss_is_the_sum_of_the_three():
    layout, prior = _read(_state(), BATCH), _prior()
    got = Objectives(_read, ObjectivesCfg(), prior).loss(_state(), BATCH)
    expected = (
        collision_loss(layout, tolerance=0.01, kind="soft", softness_m=0.1)
        + coarse_to_fine_loss(layout, "centroid")
        + semantic_loss(layout, prior)
    )
    assert torch.allclose(got, expected)


@pytest.mark.parametrize("term", ["collision", "coarse_to_fine", "semantic"])
def test_each_objective_can_be_left_out(term):
    whole = Objectives(_read, ObjectivesCfg(), _prior()).loss(_state(), BATCH)
    without = Objectives(_read, ObjectivesCfg(**{f"{term}_weight": 0.0}), _prior())
    assert (without.loss(_state(), BATCH) < whole).all()


def test_mean_moves_by_eta_against_the_normalised_gradient():
    """mu' = mu - eta_0 sqrt(1 - alpha_bar) g / |g|, the norm over each scene."""
    objectives = Objectives(_read, ObjectivesCfg(step_size=0.5), _prior())
    x = _state()
    mean = torch.zeros_like(x)
    moved = objectives.on_mean(mean, x, BATCH, MIDWAY)
    assert moved.flatten(1).norm(dim=1).tolist() == pytest.approx([0.5 * 0.8] * 2)
    leaf = x.clone().requires_grad_()
    (gradient,) = torch.autograd.grad(objectives.loss(leaf, BATCH).sum(), leaf)
    cosine = torch.cosine_similarity(moved.flatten(1), -gradient.flatten(1))
    assert cosine.tolist() == pytest.approx([1.0, 1.0])
    assert (objectives.loss(x + 0.1 * moved, BATCH) < objectives.loss(x, BATCH)).all()


def test_guidance_works_while_gradients_are_off():
    objectives = Objectives(_read, ObjectivesCfg())
    with torch.no_grad():
        moved = objectives.on_mean(torch.zeros_like(_state()), _state(), BATCH, MIDWAY)
    assert (moved != 0).any()
    assert not moved.requires_grad


def test_fixed_channels_feel_no_guidance():
    fixed = torch.zeros(2, 12, 4, dtype=torch.bool)
    fixed[:, :6] = True
    objectives = Objectives(_read, ObjectivesCfg())
    at = replace(MIDWAY, fixed=fixed)
    moved = objectives.on_mean(torch.zeros_like(_state()), _state(), BATCH, at)
    assert (moved[:, :6] == 0).all()
    assert (moved[:, 6:11, :3] != 0).any(-1).all()


def test_a_layout_without_fault_is_left_alone():
    cfg = ObjectivesCfg(coarse_to_fine_weight=0.0)
    x = _state() * 100
    mean = torch.ones_like(x)
    assert torch.equal(Objectives(_read, cfg).on_mean(mean, x, BATCH, MIDWAY), mean)
    assert torch.equal(Objectives(_read, cfg).on_x0(x, BATCH, MIDWAY), x)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"iou": "hard"}, "guidance.iou is 'hard', valid: exact, soft"),
        (
            {"region_distance": "edge"},
            "guidance.region_distance is 'edge', valid: centroid, border",
        ),
        ({"step_size": -1.0}, "guidance.step_size is -1, valid: from 0"),
        ({"iou_tolerance": 1.0}, "guidance.iou_tolerance is 1, valid: 0 to 1"),
    ],
)
def test_settings_out_of_range_say_what_is_valid(setting, message):
    with pytest.raises(DiffusionError) as error:
        ObjectivesCfg(**setting)
    assert str(error.value) == message
