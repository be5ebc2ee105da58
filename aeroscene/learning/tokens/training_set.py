"""A corpus as batches for training: shuffled, each scene in a random symmetry of the square."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Int

from aeroscene.learning.tokens.batch import Collator, TokenBatch
from aeroscene.learning.tokens.codec import DEFAULT_CODEC, CodecCfg
from aeroscene.learning.tokens.examples import (
    Example,
    TreeEncoder,
    encode_corpus,
    random_symmetry,
)
from aeroscene.learning.tokens.kinds import Vocabulary, count_kinds
from aeroscene.learning.tokens.statistics import Statistics
from aeroscene.scene import Scene

_WINDOW = 4
"""Batches that a window of scenes of like size holds."""


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

    @property
    def encoder(self) -> TreeEncoder:
        """From other scenes to examples like these, without these."""
        return TreeEncoder(self.vocabulary, self.statistics)

    def with_examples(self, examples: Sequence[Example]) -> TrainingSet:
        """Other scenes, standardised as these are; the collator stays, with what it knows."""
        other = replace(self, examples=tuple(examples))
        other.__dict__["collator"] = self.collator
        return other

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that differ between corpora."""
        digest = hashlib.sha256(self.vocabulary.digest.encode())
        for example in self.examples:
            digest.update(np.round(example.x0, 4).astype("<f4").tobytes())
        return digest.hexdigest()[:16]

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Scenes of like size, each turned and mirrored at random.

        They are drawn from a random window of the scenes in order of size, four batches wide: that
        leaves 8% of a batch of 16 to padding, where any scenes leave 24%.
        """
        n_window = min(_WINDOW * size, len(self.examples))
        # Windows reach over both ends, so that all scenes are drawn alike.
        start = int(rng.integers(len(self.examples)))
        picked = (start + rng.integers(n_window, size=size)) % len(self.examples)
        chosen = [self.examples[self._by_size[i]] for i in picked]
        codec = self.statistics.codec
        return self.collator.examples([random_symmetry(each, rng, codec) for each in chosen])

    @cached_property
    def _by_size(self) -> Int[np.ndarray, " scenes"]:
        """Numbers of the scenes, the smallest first, then down again: no window spans a jump."""
        order = np.argsort([len(e.skeleton) - e.skeleton.n_coarse for e in self.examples])
        return np.concatenate([order[::2], order[1::2][::-1]])

    def in_order(self, start: int, size: int) -> TokenBatch:
        """Scenes as they are, for measuring."""
        return self.collator.examples(self.examples[start : start + size])


def training_set(scenes: Sequence[Scene], codec: CodecCfg = DEFAULT_CODEC) -> TrainingSet:
    """The scenes of a corpus, its own kinds and statistics."""
    vocabulary = count_kinds(scenes)
    examples, statistics = encode_corpus(scenes, vocabulary, codec)
    return TrainingSet(vocabulary, statistics, tuple(examples))
