"""Random layouts from the marginals of training: the result of a method that learns nothing else.

Each object is drawn independently. Its category comes as often as in the domain's scenes. Its size,
its place along each axis of the site and its heading each come from another training object of that
category and domain. The number of objects is that of a random scene of the domain. Every learned
method should beat this one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aeroscene.learning.baselines.layouts import LayoutCode, layouts_of
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.layouts import FlatLayout
from aeroscene.learning.training.config import TrainingError
from aeroscene.scene import Scene, SceneDomain


class Marginals:
    """Objects of the training scenes, by domain."""

    def __init__(self, scenes: Sequence[Scene]) -> None:
        self._code = LayoutCode.from_scenes(scenes)
        self._layouts: dict[SceneDomain, list[FlatLayout]] = {}
        for layout in layouts_of(scenes):
            self._layouts.setdefault(layout.wish.domain, []).append(layout)

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        """Draw a scene of a seed, without areas.

        Raises:
            TrainingError: If there was no training scene of the domain.
        """
        if domain not in self._layouts:
            valid = ", ".join(sorted(self._layouts))
            raise TrainingError(f"domain is {domain!r}; valid: {valid}; no other was trained on")
        rng = np.random.default_rng(seed)
        layouts = self._layouts[domain]
        count = len(layouts[int(rng.integers(len(layouts)))])
        pool = _together(layouts)
        category = pool.category[rng.integers(len(pool.category), size=count)]
        # Places, sizes and headings are independent on purpose: only marginals are kept.
        picks = np.array([self._alike(pool, number, rng) for number in category.tolist()])
        center = np.stack([pool.center_enu_m[picks[:, axis], axis] for axis in range(3)], axis=1)
        boxes = FlatBoxes(category, center, pool.yaw_rad[picks[:, 4]], pool.size_m[picks[:, 3]])
        return self._code.scene(boxes, domain, seed, rng)

    @staticmethod
    def _alike(pool: FlatBoxes, category: int, rng: np.random.Generator) -> np.ndarray:
        """Five objects of a category: one for each axis, one for the size, one for the heading."""
        return rng.choice(np.flatnonzero(pool.category == category), 5)


def _together(layouts: Sequence[FlatLayout]) -> FlatBoxes:
    return FlatBoxes(
        np.concatenate([layout.category for layout in layouts]),
        np.concatenate([layout.center_enu_m for layout in layouts]),
        np.concatenate([layout.yaw_rad for layout in layouts]),
        np.concatenate([layout.size_m for layout in layouts]),
    )
