"""Standard normals for the sensors, drawn in blocks: a kernel pays 11 ns for one, Python far more.

Every sensor has its own stream, so that another rate or another number of draws in one leaves
the errors of the others as they were.
"""

from __future__ import annotations

import numpy as np


class NormalBlocks:
    """For each sensor the standard normals of one second, a row for each of its samples."""

    def __init__(self, seeds: list[np.random.SeedSequence], shapes: list[tuple[int, int]]) -> None:
        """Make the blocks, still empty.

        Args:
            seeds: One for each sensor.
            shapes: Samples a second and normals a sample, for each sensor.
        """
        self._generators = [np.random.default_rng(seed) for seed in seeds]
        self.blocks = tuple(np.zeros(shape) for shape in shapes)

    def draw(self) -> None:
        """Fill every block anew, in place."""
        for generator, block in zip(self._generators, self.blocks, strict=True):
            generator.standard_normal(out=block)
