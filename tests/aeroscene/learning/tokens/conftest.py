"""A small corpus as tokens."""

from __future__ import annotations

import pytest

from aeroscene.learning.tokens.training_set import TrainingSet, training_set
from aeroscene.scene import Scene


@pytest.fixture(scope="session")
def known(scenes: list[Scene]) -> TrainingSet:
    """The sampled scenes as a training set."""
    return training_set(scenes)
