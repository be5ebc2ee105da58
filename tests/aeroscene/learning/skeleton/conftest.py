"""A toy model, trained once for all tests of the package."""

from __future__ import annotations

import numpy as np
import pytest

from aeroscene.learning.skeleton.config import SkeletonCfg, SkeletonTrainingCfg
from aeroscene.learning.skeleton.train import TrainedSkeletonModel, train_skeleton
from tests.aeroscene.learning.skeleton.toy import VOCABULARY, toy_corpus

SMALL = SkeletonCfg(width=24, layers=1, kind_width=12, dropout=0.0)


@pytest.fixture(scope="session")
def trained(one_thread: None) -> TrainedSkeletonModel:
    """A small model that has seen sixty toy skeletons."""
    training = SkeletonTrainingCfg(batch=16, learning_rate=0.01, seconds=None, steps=120)
    rng = np.random.default_rng(0)
    return train_skeleton(toy_corpus(60), VOCABULARY, rng, SMALL, training)
