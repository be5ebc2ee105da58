"""`bench generate --scenes`: quality of existing scenes, whoever made them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from aeroscene.corpus.dataset import DatasetError
from aeroscene.corpus.scene_files import open_folder
from aeroscene.corpus.shipped import open_shipped
from aeroscene.corpus.summary import SceneSet
from aeroscene.metrics.classifier import N_FOLDS
from aeroscene.scene import Scene
from scenarios.bench.configs import GenerateBenchCfg
from scenarios.bench.quality import FEASIBLE, LEAST_SOUND, comparison, statistics_rows
from scenarios.bench.reference import Splits, group_figures, open_corpus
from scenarios.bench.row import OnProgress, Row, higher
from scenarios.bench.soundness import fault

SHIPPED = "shipped"
"""Name of the scenes that come with the package."""
MOST_CHECKED = 256
"""Greatest number of scenes to check for soundness, at a quarter of a second each. Of more scenes
an even choice is checked, because every scene of a dataset was validated when it was made."""


def rows(cfg: GenerateBenchCfg, on_progress: OnProgress) -> Iterator[Row]:
    """Judge finished scenes by the figures that `bench generate` gives after feasibility.

    Args:
        cfg: Options of the benchmark, with `scenes`.
        on_progress: Called before each part.

    Raises:
        SceneError: If scenes or corpus cannot be used.
    """
    corpus = open_corpus(cfg.data)
    scenes = _read(cfg, on_progress)
    yield from _soundness_rows(scenes, on_progress)
    on_progress("reading the corpus", 0.7)
    real = Splits.from_corpus(corpus)
    yield from comparison(
        group_figures(
            {FEASIBLE: scenes},
            real,
            cfg.seed,
            lambda what, share: on_progress(what, 0.75 + 0.25 * share),
        )
    )
    yield from statistics_rows(scenes)


def _read(cfg: GenerateBenchCfg, on_progress: OnProgress) -> list[Scene]:
    readers = _readers(cfg.scenes or SHIPPED)
    wanted = len(readers) if cfg.count is None else cfg.count
    # The classifier needs a scene in each of its folds.
    if not N_FOLDS <= wanted <= len(readers):
        raise DatasetError(
            f"{wanted} scenes of {cfg.scenes!r} are asked for, which has {len(readers)}; "
            f"valid: from {N_FOLDS} to as many as there are"
        )
    scenes = []
    for number, read in enumerate(readers[:wanted]):
        on_progress(f"reading scene {number + 1} of {wanted}", 0.1 * number / wanted)
        scenes.append(read())
    return scenes


def _readers(name: str) -> list[Callable[[], Scene]]:
    """Return functions that read the scenes, in order."""
    if name == SHIPPED:
        return _readers_of(open_shipped())
    return _readers_of(open_folder(name))


def _readers_of(scenes: SceneSet[Any]) -> list[Callable[[], Scene]]:
    return [partial(scenes.read, entry) for entry in scenes.entries]


def _soundness_rows(scenes: Sequence[Scene], on_progress: OnProgress) -> Iterator[Row]:
    # The step is rounded up, so that at most `MOST_CHECKED` are chosen.
    chosen = scenes[:: -(-len(scenes) // MOST_CHECKED)]
    n_sound = 0
    for number, scene in enumerate(chosen):
        on_progress("checking that scenes are sound", 0.1 + 0.6 * number / len(chosen))
        n_sound += fault(scene) is None
    yield higher("scenes checked", len(chosen), f"of {len(scenes)}")
    yield higher(f"scenes sound, {FEASIBLE}", 100 * n_sound / len(chosen), "%", LEAST_SOUND)
