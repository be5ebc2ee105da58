"""Batches by the number of their step, and those of fixed scenes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.paper.contents.batch import SentenceBatch
from aeroscene.learning.writer.batch import LessonBatch

Batch = TokenBatch | LessonBatch | SentenceBatch
Batches = Callable[[int], Batch]
"""Function from the number of a step, from 0, to its batch on the processor. Steps are asked for in
ascending order. It raises `StoppedError` if the user wants the training to end before the batch is
made."""


class StoppedError(Exception):
    """The user wants the training to end while it waits for scenes."""


class Scenes(Protocol):
    """Scenes to train on, varied at random."""

    def sample_batch(self, size: int, rng: np.random.Generator) -> Batch:
        """Draw scenes from the set, on the processor."""
        ...


def batch_generator(seed: int, step: int) -> np.random.Generator:
    """Return the random generator of the batch of a step."""
    return np.random.default_rng([seed, step, 0])


def drawn_from(scenes: Scenes, size: int, seed: int) -> Batches:
    """Return batches of so many of these scenes."""
    return lambda step: scenes.sample_batch(size, batch_generator(seed, step))
