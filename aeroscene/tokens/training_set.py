"""A corpus as batches for training: shuffled, each scene in a random symmetry of the square."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aeroscene.scene import Scene
from aeroscene.tokens.batch import Collator, TokenBatch
from aeroscene.tokens.examples import Example, encode_corpus, random_symmetry
from aeroscene.tokens.kinds import Vocabulary, count_kinds
from aeroscene.tokens.statistics import Statistics


@dataclass(frozen=True)
class TrainingSet:
    """Scenes as tokens with what standardises them."""

    vocabulary: Vocabulary
    statistics: Statistics
    examples: tuple[Example, ...]

    @cached_property
    def collator(self) -> Collator:
        """Makes batches of these scenes."""
        return Collator(self.vocabulary, self.statistics)

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that differ between corpora."""
        digest = hashlib.sha256(self.vocabulary.digest.encode())
        for example in self.examples:
            digest.update(np.round(example.x0, 4).astype("<f4").tobytes())
        return digest.hexdigest()[:16]

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Scenes drawn with replacement, each turned and mirrored at random."""
        picked = rng.integers(len(self.examples), size=size)
        return self.collator.examples([random_symmetry(self.examples[i], rng) for i in picked])

    def in_order(self, start: int, size: int) -> TokenBatch:
        """Scenes as they are, for measuring."""
        return self.collator.examples(self.examples[start : start + size])


def training_set(scenes: Sequence[Scene]) -> TrainingSet:
    """The scenes of a corpus, its own kinds and statistics."""
    vocabulary = count_kinds(scenes)
    examples, statistics = encode_corpus(scenes, vocabulary)
    return TrainingSet(vocabulary, statistics, tuple(examples))
