from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.learning.skeleton.embedding import kind_traits
from aeroscene.learning.skeleton.lesson import lesson_of
from aeroscene.learning.skeleton.loss import skeleton_loss, skeleton_surprise
from aeroscene.learning.skeleton.model import SkeletonModel
from tests.aeroscene.learning.skeleton.conftest import SMALL
from tests.aeroscene.learning.skeleton.test_grammar import GRAMMAR
from tests.aeroscene.learning.skeleton.toy import VOCABULARY, toy_corpus


@pytest.fixture(name="model")
def _model() -> SkeletonModel:
    torch.manual_seed(0)
    return SkeletonModel(SMALL, GRAMMAR, kind_traits(VOCABULARY)).eval()


def _lesson(examples: list):
    return lesson_of([s for s, _ in examples], [w for _, w in examples], GRAMMAR)


def test_a_batch_is_as_surprising_as_its_skeletons_alone(model: SkeletonModel):
    examples = toy_corpus(6, seed=1)
    together = skeleton_surprise(model, _lesson(examples))
    alone = [skeleton_surprise(model, _lesson([example])) for example in examples]
    for name, total in together.items():
        torch.testing.assert_close(total, torch.stack([one[name] for one in alone]).sum())


def test_an_untrained_model_is_about_as_surprised_as_by_dice(model: SkeletonModel):
    surprise = skeleton_surprise(model, _lesson(toy_corpus(20)))
    n_coarse = sum(wish.n_coarse for _, wish in toy_corpus(20))
    expected = n_coarse * np.log(VOCABULARY.n_kinds)
    assert surprise["coarse_kind"].item() == pytest.approx(expected, rel=0.1)


def test_every_weight_learns(model: SkeletonModel):
    skeleton_loss(model, _lesson(toy_corpus(4))).backward()
    without = [n for n, p in model.named_parameters() if p.grad is None or not p.grad.any()]
    assert without == []
