"""Sizes and looks drawn from a stream of random numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aeroscene.scene import Vector3
from aeroscene.scene.catalogue import by_name


class Draw:
    """One stream of randomness, with the questions that the grammar asks.

    Numbers come in whole centimetres, so that files have few digits.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def between(self, low: float, high: float) -> float:
        """Draw a uniform number in whole centimetres."""
        return round(float(self._rng.uniform(low, high)), 2)

    def count(self, low: int, high: int) -> int:
        """Draw a whole number from low to high, both included."""
        return int(self._rng.integers(low, high + 1))

    def chance(self, probability: float) -> bool:
        """Return true with a probability, 0 to 1."""
        return bool(self._rng.random() < probability)

    def one_of(self, options: Sequence[str]) -> str:
        """Draw one of some names; a name that occurs twice is twice as likely."""
        return options[int(self._rng.integers(len(options)))]

    def shuffled(self, options: Sequence[int]) -> list[int]:
        """Return the same numbers in another order."""
        return [int(i) for i in self._rng.permutation(options)]

    def size_of(self, name: str, shrink: float = 0.2) -> Vector3:
        """Draw a size from the middle of a category's ranges.

        Args:
            name: Category.
            shrink: Share of each range that is cut off at both ends, so that extremes stay rare.
        """
        category = by_name()[name]
        spans = (category.length_m, category.width_m, category.height_m)
        x, y, z = (
            self.between(low + shrink * (high - low), high - shrink * (high - low))
            for low, high in spans
        )
        return (x, y, z)
