from copy import deepcopy
from dataclasses import replace
from functools import cache

import pytest
import torch

from aeroscene.learning.diffusion.config import DiffusionError
from aeroscene.learning.paper.guidance.config import SemanticPriorCfg
from aeroscene.learning.paper.guidance.layout import Layout
from aeroscene.learning.paper.guidance.semantic import (
    neighbour_pairs,
    semantic_loss,
    train_semantic_prior,
)
from tests.aeroscene.learning.guidance.layouts import random_layout

TABLE, CHAIR, TREE = range(1, 4)
CFG = SemanticPriorCfg(n_categories=3, n_neighbours=3, width=24, batch_size=24, learning_rate=1e-2)


def _dinners(count: int, generator: torch.Generator) -> Layout:
    """A table with chairs before and behind it, a tree far to the side."""
    place = torch.tensor([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 9, 0]], dtype=torch.float32)
    jitter = 0.1 * torch.randn(count, 4, 3, generator=generator)
    yaw = 6.3 * torch.rand(count, generator=generator)
    cos, sin = yaw.cos()[:, None], yaw.sin()[:, None]
    x, y, z = (place + jitter).unbind(-1)
    return Layout(
        torch.stack([cos * x - sin * y, sin * x + cos * y, z], dim=-1),
        torch.stack([cos, sin], dim=-1).expand(count, 4, 2),
        torch.ones(count, 4, 3),
        torch.tensor([TABLE, CHAIR, CHAIR, TREE]).expand(count, 4),
        torch.ones(count, 4, dtype=torch.bool),
        torch.tensor([True, False, False, False]),
    )


@cache
def _trained(_run: int = 0):
    generator = torch.Generator().manual_seed(0)
    losses = []
    prior = train_semantic_prior(
        lambda count: _dinners(count, generator),
        CFG,
        300,
        torch.Generator().manual_seed(1),
        lambda _, loss: losses.append(loss),
    )
    return prior, losses


def test_prior_learns_what_stands_where():
    prior, losses = _trained()
    assert losses[-1] < losses[0] - 5
    good = _dinners(8, torch.Generator().manual_seed(5))
    moved = good.center_enu_m.clone()
    moved[:, [1, 3]] = moved[:, [3, 1]]
    bad = replace(good, center_enu_m=moved)
    # Nats of a density, which may be below zero: a tree in a chair's place costs many.
    assert (semantic_loss(bad, prior) > semantic_loss(good, prior) + 10).all()


def test_training_is_the_same_by_the_same_seeds():
    (first, losses), (again, same) = _trained(), _trained(1)
    assert losses == same
    for name, value in first.state_dict().items():
        assert torch.equal(value, again.state_dict()[name])


def test_pairs_are_the_nearest_in_the_axes_of_the_first():
    layout = random_layout(3)
    pairs = neighbour_pairs(layout, 2)
    assert len(pairs.scene) == 2 * 11 * 2
    for scene in range(2):
        center = layout.center_enu_m[scene, :11]
        for i in range(11):
            away = (center - center[i]).norm(dim=-1)
            nearest = away.argsort()[1:3]
            rows = pairs.displacement_m[(scene * 11 + i) * 2 :][:2]
            cos, sin = layout.heading[scene, i].tolist()
            for row, j in zip(rows, nearest, strict=True):
                x, y, z = (center[j] - center[i]).tolist()
                expected = [cos * x + sin * y, cos * y - sin * x, z]
                assert row.tolist() == pytest.approx(expected)


def test_layouts_of_fewer_objects_than_neighbours_have_the_pairs_there_are():
    layout = random_layout(3, n=3)
    assert len(neighbour_pairs(layout, 8).scene) == 2 * 2


def test_gradient_is_that_of_finite_differences():
    prior = deepcopy(_trained()[0]).double()
    layout = random_layout(4, n=5, n_categories=3, n_scenes=1)
    pairs = neighbour_pairs(layout, 3)

    def value(displacement):
        moved = replace(pairs, displacement_m=displacement)
        return prior(layout.category, moved).sum()

    assert torch.autograd.gradcheck(value, pairs.displacement_m.clone().requires_grad_())


def test_settings_out_of_range_say_what_is_valid():
    with pytest.raises(DiffusionError) as error:
        SemanticPriorCfg(n_categories=0)
    assert str(error.value) == "prior.n_categories is 0, valid: 1 to 4086"
