import numpy as np
import pytest

from aeroscene.metrics.classifier import classifier_accuracy
from aeroscene.metrics.discrepancy import TooFewScenesError


def accuracy(shift, counts=(40, 90), seed=0):
    rng = np.random.default_rng(seed)
    first, second = (rng.normal(0.0, 1.0, (count, 200)) for count in counts)
    first[:, :5] += shift
    return classifier_accuracy(first, second, rng)


def test_sets_drawn_alike_are_told_by_guessing():
    assert np.mean([accuracy(0.0, seed=seed) for seed in range(6)]) == pytest.approx(0.5, abs=0.08)


def test_sets_are_told_apart_the_better_the_more_unlike_they_are():
    little, more = accuracy(1.0), accuracy(3.0)
    assert 0.6 < little < more
    assert more > 0.95


def test_fewer_scenes_than_folds_are_named():
    with pytest.raises(TooFewScenesError, match="a set of 4 scenes"):
        accuracy(0.0, counts=(4, 20))
