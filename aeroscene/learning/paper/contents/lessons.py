"""Training layouts as sentences of contents, in batches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.learning.paper.contents.batch import SentenceBatch, sentence_batch
from aeroscene.learning.paper.contents.sentences import sentence_of
from aeroscene.learning.paper.layouts import FlatLayout, random_symmetry
from aeroscene.learning.paper.training_set import FlatTrainingSet


@dataclass(frozen=True, eq=False)
class ContentsLessons:
    """Training set of the contents model: the same scenes, as sentences."""

    scenes: FlatTrainingSet

    @property
    def examples(self) -> tuple[FlatLayout, ...]:
        """Layouts of the training scenes."""
        return self.scenes.examples

    def with_examples(self, examples: Sequence[FlatLayout]) -> ContentsLessons:
        """Return lessons of other scenes with the same statistics."""
        return ContentsLessons(self.scenes.with_examples(examples))

    def sample_batch(self, size: int, rng: np.random.Generator) -> SentenceBatch:
        """Draw scenes with similar numbers of objects, turned and indoors mirrored at random."""
        return self._batch([random_symmetry(each, rng) for each in self.scenes.alike(size, rng)])

    def in_order(self, start: int, size: int) -> SentenceBatch:
        """Return scenes as they are, for measuring."""
        return self._batch(self.examples[start : start + size])

    def _batch(self, layouts: Sequence[FlatLayout]) -> SentenceBatch:
        statistics = self.scenes.statistics
        return sentence_batch(
            [sentence_of(each, statistics) for each in layouts],
            [each.wish for each in layouts],
        )
