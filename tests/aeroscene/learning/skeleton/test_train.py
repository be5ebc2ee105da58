from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.learning.skeleton.config import (
    SkeletonCfg,
    SkeletonError,
    SkeletonTrainingCfg,
)
from aeroscene.learning.skeleton.model import SkeletonModel
from aeroscene.learning.skeleton.train import SkeletonProgress, TrainedSkeletonModel, train_skeleton
from tests.aeroscene.learning.skeleton.conftest import SMALL
from tests.aeroscene.learning.skeleton.toy import VOCABULARY, toy_corpus

SHORT = SkeletonTrainingCfg(batch=8, seconds=None, steps=4, looks=2)


def _train(**more) -> TrainedSkeletonModel:
    return train_skeleton(
        toy_corpus(20), VOCABULARY, np.random.default_rng(5), SMALL, SHORT, **more
    )


def test_training_learns_what_always_is(trained: TrainedSkeletonModel):
    # Nine kinds by dice are 2.2 nats an object, and depths and quotas come on top.
    assert trained.held_out < 0.8


def test_the_same_seed_gives_the_same_weights():
    one, two = _train().model.state_dict(), _train().model.state_dict()
    assert all(torch.equal(one[name], two[name]) for name in one)


def test_training_leaves_the_global_generator_alone():
    torch.manual_seed(9)
    before = torch.get_rng_state()
    _train()
    assert torch.equal(torch.get_rng_state(), before)


def test_progress_is_told_and_may_end_it():
    told: list[SkeletonProgress] = []

    def stop_at_two(progress: SkeletonProgress) -> bool:
        told.append(progress)
        return progress.step == 2

    assert _train(on_step=stop_at_two).steps == 2
    assert [p.share for p in told] == [0.25, 0.5]
    assert [p.held_out is None for p in told] == [True, False]


def test_the_clock_ends_the_training():
    ticks = iter(range(100))
    training = SkeletonTrainingCfg(batch=8, seconds=3.0)
    trained = train_skeleton(
        toy_corpus(20),
        VOCABULARY,
        np.random.default_rng(0),
        SMALL,
        training,
        clock=lambda: float(next(ticks)),
    )
    assert trained.steps == 3


def test_one_skeleton_is_too_few():
    with pytest.raises(SkeletonError, match=r"there are 1 skeletons .* valid: from 2 on"):
        train_skeleton(toy_corpus(1), VOCABULARY, np.random.default_rng(0))


def test_weights_come_back_whole(trained: TrainedSkeletonModel):
    state = trained.model.state_dict()
    again = SkeletonModel.restored(SMALL, VOCABULARY, state)
    assert all(torch.equal(value, again.state_dict()[name]) for name, value in state.items())
    assert again.grammar.max_quota == trained.model.grammar.max_quota
    np.testing.assert_array_equal(again.grammar.cap, trained.model.grammar.cap)


def test_weights_of_another_network_are_refused(trained: TrainedSkeletonModel):
    with pytest.raises(SkeletonError, match="skeleton weights do not fit"):
        SkeletonModel.restored(SkeletonCfg(width=32), VOCABULARY, trained.model.state_dict())


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SkeletonCfg(width=0), "width is 0, valid: 8 to 1024"),
        (lambda: SkeletonCfg(dropout=1.0), "dropout is 1.0, valid: 0 to 0.9"),
        (lambda: SkeletonTrainingCfg(batch=0), "batch is 0, valid: 1 to 4096"),
        (lambda: SkeletonTrainingCfg(seconds=None), "seconds and steps are None"),
        (lambda: SkeletonTrainingCfg(seconds=0.0), "seconds is 0.0, valid"),
        (lambda: SkeletonTrainingCfg(steps=0), "steps is 0, valid"),
    ],
)
def test_numbers_out_of_range_are_refused(make, message: str):
    with pytest.raises(SkeletonError, match=message):
        make()
