"""Reference for generated scenes: a corpus in a folder, and the figures of its splits.

Distances between sets depend on the sets' sizes. The figures of generated scenes therefore stand
beside those of as many training scenes, which show what real scenes reach.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aeroscene.corpus.dataset import Dataset, DatasetError, open_dataset
from aeroscene.metrics.classifier import N_FOLDS
from aeroscene.metrics.comparison import Figures, Reference, figures_of
from aeroscene.scene import Scene
from scenarios.bench.quality import TEST, TRAIN


@dataclass(frozen=True, slots=True)
class Splits:
    """Real scenes of both splits."""

    train: Sequence[Scene]
    test: Sequence[Scene]

    @classmethod
    def from_corpus(cls, corpus: Dataset) -> Splits:
        """Read all scenes of both splits of a corpus."""
        return cls(*(list(corpus.of_split(split).scenes()) for split in ("train", "test")))


def open_corpus(folder: Path) -> Dataset:
    """Open the scenes to compare with, and check their number before any work.

    Args:
        folder: Folder of a dataset.

    Raises:
        DatasetError: If the folder holds no dataset, or too few scenes of a split.
    """
    corpus = open_dataset(folder)
    for split in ("train", "test"):
        count = len(corpus.of_split(split).entries)
        if count < N_FOLDS:
            raise DatasetError(
                f"folder {str(folder)!r} has {count} scenes of the {split} split; valid: "
                f"{N_FOLDS} or more; aeroscene dataset build makes all"
            )
    return corpus


def group_figures(
    groups: Mapping[str, Sequence[Scene]],
    real: Splits,
    seed: int,
    on_group: Callable[[str, float], object],
) -> dict[str, Figures]:
    """Return every figure of groups of scenes, of the test split and of some training scenes.

    Args:
        groups: Scenes by group name; groups of fewer than `N_FOLDS` are left out.
        real: Reference scenes.
        seed: Seed of bootstraps, folds and the choice of as many training scenes as the largest
            group has.
        on_group: Called before each group with its name and the share done.
    """
    rng = np.random.default_rng(seed)
    # It measures every training scene, and counts as that much work below.
    on_group("what the corpus is like", 0.0)
    reference = Reference.measure(real.train, real.test)
    count = min(max(map(len, groups.values())), len(real.train))
    # Drawn by chance, because the first scenes of a corpus need not be like the others.
    chosen = rng.choice(len(real.train), count, replace=False).tolist()
    judged = {**groups, TEST: real.test, TRAIN: [real.train[i] for i in chosen]}
    sizes = {name: len(scenes) for name, scenes in judged.items() if len(scenes) >= N_FOLDS}
    done, total = len(real.train), len(real.train) + sum(sizes.values())
    figures = {}
    for name, size in sizes.items():
        on_group(f"comparing with the corpus: {name}", done / total)
        figures[name] = figures_of(judged[name], reference, rng)
        done += size
    return figures
