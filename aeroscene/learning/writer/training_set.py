"""Programs of a corpus in batches for training: for the writer, and for the denoiser."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Int

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.program.batch import program_batch
from aeroscene.learning.writer.batch import LessonBatch, lesson_batch
from aeroscene.learning.writer.examples import ProgramEncoder, Written
from aeroscene.learning.writer.language import Language

_WINDOW = 4
"""Number of batches in a window of programs of similar size."""


@dataclass(frozen=True, eq=False)
class ProgramSet:
    """Programs with their language, in batches for the denoiser."""

    language: Language
    examples: tuple[Written, ...]

    @property
    def known(self) -> Language:
        """Language of the scenes, which a checkpoint stores."""
        return self.language

    @property
    def kinds_json(self) -> str:
        """Kinds of tokens as text."""
        return self.language.to_json()

    @property
    def encoder(self) -> ProgramEncoder:
        """Function that turns another scene into an example of the same language.

        It does not hold the examples, so it can be sent to another process cheaply.
        """
        return ProgramEncoder(self.language)

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that differ between corpora."""
        # Rounded below, so that the last bits of another machine do not change the digest.
        digest = hashlib.sha256(self.kinds_json.encode())
        for each in self.examples:
            digest.update(each.example.skeleton.kind_id.astype("<i4").tobytes())
            digest.update(np.round(each.example.x0, 4).astype("<f4").tobytes())
        return digest.hexdigest()[:16]

    @property
    def lessons(self) -> LessonSet:
        """The same programs for the writer."""
        return LessonSet(self.examples)

    def with_examples(self, examples: Sequence[Written]) -> ProgramSet:
        """Return a set of other programs of the same language."""
        return replace(self, examples=tuple(examples))

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Draw programs of similar size, from a random window of four batches.

        Args:
            size: Number of programs.
            rng: Source of the draw.
        """
        return self._batch([self.examples[i] for i in _window(self._by_size, size, rng)])

    def in_order(self, start: int, size: int) -> TokenBatch:
        """Return programs from a place on, for measuring."""
        return self._batch(self.examples[start : start + size])

    def _batch(self, chosen: Sequence[Written]) -> TokenBatch:
        wishes = [each.wish for each in chosen]
        return program_batch([each.example for each in chosen], wishes, self.language.statistics)

    @cached_property
    def _by_size(self) -> Int[np.ndarray, " scenes"]:
        return _windowed([len(each.example.skeleton) for each in self.examples])


@dataclass(frozen=True, eq=False)
class LessonSet:
    """Programs in batches for the writer."""

    examples: tuple[Written, ...]

    def with_examples(self, examples: Sequence[Written]) -> LessonSet:
        """Return a set of other programs of the same language."""
        return LessonSet(tuple(examples))

    def sample_batch(self, size: int, rng: np.random.Generator) -> LessonBatch:
        """Draw programs of similar size, from a random window of four batches.

        Programs in a batch are padded to the longest one, so similar sizes save time.
        """
        picked = _window(self._by_size, size, rng)
        return lesson_batch([self.examples[i].lesson for i in picked])

    def in_order(self, start: int, size: int) -> LessonBatch:
        """Return programs from a place on, for measuring."""
        return lesson_batch([each.lesson for each in self.examples[start : start + size]])

    @cached_property
    def _by_size(self) -> Int[np.ndarray, " scenes"]:
        return _windowed([len(each.lesson) for each in self.examples])


def _windowed(sizes: Sequence[int]) -> Int[np.ndarray, " scenes"]:
    """Order programs by size, rising and then falling, so that no window spans a jump."""
    # Every second program rises, the others fall: the ends meet at similar sizes.
    order = np.argsort(sizes, kind="stable")
    return np.concatenate([order[::2], order[1::2][::-1]])


def _window(by_size: Int[np.ndarray, " scenes"], size: int, rng: np.random.Generator) -> list[int]:
    """Draw the numbers of programs of similar size.

    Padding then takes 8% of a batch of 16, instead of 24%. Windows reach over both ends, so that
    all programs are drawn equally often.
    """
    n = len(by_size)
    start = int(rng.integers(n))
    return by_size[(start + rng.integers(min(_WINDOW * size, n), size=size)) % n].tolist()
