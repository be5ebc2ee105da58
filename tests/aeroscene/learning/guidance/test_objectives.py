from dataclasses import replace

import numpy as np
import pytest
import torch

from aeroscene.learning.diffusion.config import DiffusionError
from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.paper.guidance.coarse_to_fine import coarse_to_fine_loss
from aeroscene.learning.paper.guidance.collision import collision_loss
from aeroscene.learning.paper.guidance.config import ObjectivesCfg, SemanticPriorCfg
from aeroscene.learning.paper.guidance.layout import FlatReader
from aeroscene.learning.paper.guidance.objectives import Objectives, _shifted
from aeroscene.learning.paper.guidance.semantic import SemanticPrior, semantic_loss
from aeroscene.learning.paper.training_set import flat_training_set
from tests.aeroscene.conftest import cached_scene

LAST = Moment(9, 10, 0.1, 0.99, None)
CFG = ObjectivesCfg(n_steps=1, semantic_weight=1.0, semantic_step_weight=1.0)


@pytest.fixture(scope="module", params=[False, True], ids=["paper", "progressive"])
def crowd(request):
    """Two scenes of which all is shaken by a metre or so, the reader, a prior."""
    data = flat_training_set([cached_scene(14), cached_scene(42)], has_regions=request.param)
    batch = data.in_order(0, 1)
    read = FlatReader(data.statistics)
    generator = torch.Generator().manual_seed(0)
    shaken = torch.randn(batch.x0.shape, generator=generator)
    x0 = batch.x0 + 0.3 * shaken * (batch.weight > 0)
    with torch.random.fork_rng():
        torch.manual_seed(0)
        prior = SemanticPrior(SemanticPriorCfg(n_categories=70, width=8))
    return batch, read, x0, prior


def test_combined_loss_is_the_sum_of_the_three(crowd):
    batch, read, x0, prior = crowd
    layout = read(x0, batch)
    expected = (
        collision_loss(layout, tolerance=0.01, kind="depth", softness_m=0.1)
        + coarse_to_fine_loss(layout, "border")
        + semantic_loss(layout, prior)
    )
    assert torch.allclose(Objectives(read, CFG, prior).loss(x0, batch), expected)


@pytest.mark.parametrize("term", ["collision", "coarse_to_fine", "semantic"])
def test_each_objective_can_be_left_out(crowd, term):
    batch, read, x0, prior = crowd
    whole = Objectives(read, CFG, prior)
    left_out = [f"{term}_weight"] + ["semantic_step_weight"] * (term == "semantic")
    without = Objectives(read, replace(CFG, **dict.fromkeys(left_out, 0.0)), prior)
    assert (without.loss(x0, batch) < whole.loss(x0, batch)).all()
    assert len(whole.steps(x0, batch)) == len(without.steps(x0, batch)) + 1


def test_gradients_are_those_of_finite_differences(crowd):
    batch, read, x0, prior = crowd
    objectives = Objectives(read, replace(CFG, iou="soft"), prior.double())
    layout = read(x0.double(), batch)
    moved = objectives._gradients(layout)
    generator = torch.Generator().manual_seed(1)
    way = torch.randn(layout.center_enu_m.shape, generator=generator, dtype=torch.float64)
    for number, (_, _, gradient) in enumerate(moved):
        ends = [_shifted(layout, sign * 1e-5 * way) for sign in (1, -1)]
        slopes = [float(list(objectives._terms(end, 1.0))[number][2].detach()) for end in ends]
        expected = float((gradient * way).sum())
        assert (slopes[0] - slopes[1]) / 2e-5 == pytest.approx(expected, rel=1e-3, abs=1e-3)
    prior.float()


def test_no_term_moves_an_object_further_than_the_step(crowd):
    """mu' = mu - eta_0 sum_k g_k / (|g_k| + eps), each object in metres."""
    batch, read, x0, prior = crowd
    objectives = Objectives(read, replace(CFG, step_size=0.5), prior)
    moved = objectives.on_mean(x0, x0, batch, LAST)
    before, after = read(x0, batch), read(moved, batch)
    way_m = (after.center_enu_m - before.center_enu_m)[batch.mask]
    assert way_m[:, 2].abs().max() < 1e-4
    assert way_m[:, :2].norm(dim=-1).max() <= 3 * 0.5 + 1e-4
    assert way_m[:, :2].norm(dim=-1).max() > 0.2
    np.testing.assert_allclose(after.size_m, before.size_m)


@pytest.mark.parametrize("term", ["collision", "coarse_to_fine", "semantic"])
def test_small_steps_lower_each_term(crowd, term):
    batch, read, x0, prior = crowd
    terms = ("collision", "coarse_to_fine", "semantic")
    others = {f"{each}_weight": 0.0 for each in terms if each != term}
    if term != "semantic":
        others["semantic_step_weight"] = 0.0
    alone = Objectives(read, replace(CFG, step_size=0.005, n_steps=5, **others), prior)
    moved = alone.on_mean(x0, x0, batch, LAST)
    assert (alone.loss(moved, batch) < alone.loss(x0, batch)).all()


def test_terms_have_shares_of_one_order(crowd):
    """Under one norm for all the semantic term took 93% of the step."""
    batch, read, x0, prior = crowd
    objectives = Objectives(read, CFG, prior)
    lengths = []
    for _, _, gradient in objectives._gradients(read(x0, batch)):
        step = gradient / (gradient.norm(dim=-1, keepdim=True) + CFG.slack)
        lengths.append(float(step[batch.mask].norm(dim=-1).mean()))
    shares = np.array(lengths) / sum(lengths)
    assert shares.min() > 0.05
    assert shares.max() < 0.75


def test_what_is_given_feels_no_guidance(crowd):
    batch, read, x0, prior = crowd
    moved = Objectives(read, CFG, prior).on_mean(x0, x0, batch, LAST)
    assert torch.equal(moved[batch.given], x0[batch.given])
    assert (moved != x0).any()
    assert not moved.requires_grad


@pytest.mark.parametrize("index", [0, 2, 8])
def test_calls_before_the_last_are_not_guided(crowd, index):
    batch, read, x0, prior = crowd
    at = replace(LAST, index=index)
    objectives = Objectives(read, CFG, prior)
    assert torch.equal(objectives.on_mean(x0, x0, batch, at), x0)
    assert torch.equal(objectives.on_x0(x0, batch, at), x0)


def test_rooms_do_not_collide_with_what_they_hold():
    data = flat_training_set([cached_scene(311)], has_regions=True)
    batch = data.in_order(0, 1)
    layout = FlatReader(data.statistics)(batch.x0, batch)
    hollow = torch.from_numpy(data.statistics.holds)

    def loss(is_hollow):
        return float(
            collision_loss(
                layout, tolerance=0.01, kind="depth", softness_m=0.1, is_hollow=is_hollow
            )
        )

    assert loss(hollow) < 0.7 * loss(None)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"iou": "hard"}, "guidance.iou is 'hard'; valid: exact, soft, depth"),
        (
            {"region_distance": "edge"},
            "guidance.region_distance is 'edge'; valid: centroid, border",
        ),
        ({"step_size": -1.0}, "guidance.step_size is -1, valid: from 0"),
        ({"iou_tolerance": 1.0}, "guidance.iou_tolerance is 1, valid: 0 to below 1"),
        ({"slack": 0.0}, "guidance.slack is 0, valid: above 0"),
        ({"n_steps": -1}, "guidance.n_steps is -1, valid: 0 to 10000"),
    ],
)
def test_settings_out_of_range_say_what_is_valid(setting, message):
    with pytest.raises(DiffusionError) as error:
        ObjectivesCfg(**setting)
    assert str(error.value) == message
