"""Random layouts from the marginals of training: what a method that learns nothing else draws.

Every object is drawn on its own: its category as often as the domain's scenes have it; its size,
its place along each axis and its heading each from another training object of that category and
domain. How many objects there are is drawn from the domain's scenes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aeroscene.learning.baselines.layouts import Boxes, LayoutCode, boxes_of
from aeroscene.learning.training.config import TrainingError
from aeroscene.scene import Scene, SceneDomain


class Marginals:
    """Objects of training, by domain."""

    def __init__(self, scenes: Sequence[Scene]) -> None:
        self._code = LayoutCode.of(scenes)
        self._layouts: dict[SceneDomain, list[Boxes]] = {}
        for scene in scenes:
            self._layouts.setdefault(scene.domain, []).append(boxes_of(scene))

    def sample(self, seed: int, domain: SceneDomain) -> Scene:
        """A scene of a seed, without areas.

        Raises:
            TrainingError: If there was no training scene of the domain.
        """
        if domain not in self._layouts:
            valid = ", ".join(sorted(self._layouts))
            raise TrainingError(f"domain is {domain!r}, valid: {valid}; no other was trained on")
        rng = np.random.default_rng(seed)
        layouts = self._layouts[domain]
        count = len(layouts[int(rng.integers(len(layouts)))].category)
        pool = _together(layouts)
        category = pool.category[rng.integers(len(pool.category), size=count)]
        picks = np.array([self._alike(pool, number, rng) for number in category.tolist()])
        centre = np.stack([pool.centre_enu_m[picks[:, axis], axis] for axis in range(3)], axis=1)
        boxes = Boxes(category, centre, pool.size_m[picks[:, 3]], pool.yaw_rad[picks[:, 4]])
        return self._code.scene(boxes, domain, seed, rng)

    @staticmethod
    def _alike(pool: Boxes, category: int, rng: np.random.Generator) -> np.ndarray:
        """Five objects of a category: one for each axis, one for the size, one for the heading."""
        return rng.choice(np.flatnonzero(pool.category == category), 5)


def _together(layouts: Sequence[Boxes]) -> Boxes:
    return Boxes(
        np.concatenate([boxes.category for boxes in layouts]),
        np.concatenate([boxes.centre_enu_m for boxes in layouts]),
        np.concatenate([boxes.size_m for boxes in layouts]),
        np.concatenate([boxes.yaw_rad for boxes in layouts]),
    )
