"""Recorder of the layouts during a generation, which draws them as a strip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.generation import Generated
from aeroscene.learning.generation.proposal import Proposal
from scenarios.pictures.generation.layout_view import Layout
from scenarios.pictures.generation.strip import chosen_steps, draw_strip, layout_of

_MARGIN = 1.15
"""Half of the pictures' side, relative to half of the sampled site's longer side."""


class Recorder:
    """Keeps the layouts of a few denoising steps; pass it to a generator as `on_step`."""

    def __init__(self) -> None:
        self._kept: list[tuple[str, Layout]] = []

    def __call__(self, moment: Moment, proposals: Sequence[Proposal]) -> None:
        """Keep the first scene of the batch if this step is to be drawn.

        Args:
            moment: Number and time of the step.
            proposals: Present layouts of the batch.
        """
        if moment.index in chosen_steps(moment.n_steps):
            scene = proposals[0].scene("noisy", 0, np.random.default_rng(0))
            self._kept.append((f"t = {moment.time:.2f} T", layout_of(scene)))

    def draw(self, found: Generated, out: Path) -> None:
        """Draw the steps, the sampled layout, and the finished scene.

        Args:
            found: Result of the generation.
            out: PNG file to write.

        Raises:
            OSError: If the file cannot be written.
        """
        low, high = found.raw.extent_min_enu_m, found.raw.extent_max_enu_m
        half_m = _MARGIN * max(high[axis] - low[axis] for axis in (0, 1)) / 2
        moments = [*self._kept, ("t = 0, sampled", layout_of(found.raw))]
        draw_strip(moments, half_m, found.scene, out)
