"""Quality of generated scenes: rows computed from scenes alone, whoever made them.

A figure such as a collision rate means little by itself. Each row therefore stands beside the same
figure of the corpus, which is the target where generated scenes should be as good as real ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.corpus.summary import summarise
from aeroscene.feasibility.validity import validity
from aeroscene.metrics.comparison import ComparisonRow, Figures, comparison_rows
from aeroscene.metrics.displacement import displacement
from aeroscene.metrics.paper_table import paper_table
from aeroscene.metrics.places.checks import CHECKS
from aeroscene.scene import Scene
from scenarios.bench.row import Row, higher, lower
from scenarios.bench.soundness import fault

LEAST_SOUND = 99.0
MOST_MEDIAN_M = 0.5
MOST_DROPPED = 1.0
MOST_DEVIATION = 10.0
LEAST_DISTANCE_SHARE = 0.9
"""Least share of the test split's median distance from training."""
RAW, FEASIBLE, TEST, TRAIN = "before", "after", "test split", "training split"
"""Groups of scenes: before and after feasibility, and the corpus."""

_BY_SCENE = (
    "collision_rate",
    "collision_rate_without_family",
    "colliding_objects_without_family",
    "colliding_scenes_without_family",
    "collision_depth_without_family",
    "objects_in_strangers",
    "consistency",
    "consistency_centroid",
    "astray",
    "plausibility",
    "plausibility_place",
)
"""Figures of single scenes, whose reference is the test split."""
_OF_SETS = (
    "category_kl",
    "cooccurrence_kl",
    "hierarchy_kl",
    "mmd",
    "coverage",
    "classifier_accuracy",
)
"""Distances of a set from the test split; their reference is as many training scenes."""
_OF_COPIES = (
    "training_distance",
    "least_training_distance",
    "copied",
    "known_contents",
    "known_skeletons",
    "known_coarse_skeletons",
)
_COLLISIONS = _BY_SCENE[:6]  # lower is better, and the test split sets the target
_OF_PLACES = tuple(check.key for check in CHECKS)
_GOALS = {
    "plausibility": 6.65,
    "classifier_accuracy": 65.0,
    **{check.key: check.goal for check in CHECKS},
}
"""Targets of figures for which the corpus's own value is not the target."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """One draw of the generator, before and after feasibility."""

    raw: Scene
    """Scene as sampled."""
    projected: Scene
    """Scene after feasibility."""
    is_rejected: bool


def validity_rows(scenes: Sequence[Scene], where: str, target: float | None) -> Iterator[Row]:
    """Yield the shares of objects that are free of others and supported as required.

    Args:
        scenes: Raw scenes, or real ones.
        where: Name of the scenes, for the titles.
        target: Least percentage of objects that should be both.
    """
    verdicts = [validity(scene) for scene in scenes]
    for what, shares, least in (
        ("valid", [verdict.is_valid for verdict in verdicts], target),
        ("free of others", [verdict.is_free for verdict in verdicts], None),
        ("rightly supported", [verdict.is_supported for verdict in verdicts], None),
    ):
        share = float(100 * np.concatenate(shares).mean())
        yield higher(f"objects {what}, {where}", share, "%", least)


def feasibility_rows(draws: Sequence[Drawn], on_scene: Callable[[], object]) -> Iterator[Row]:
    """Yield results and displacements of the projection, for all draws and rejected ones too.

    Args:
        draws: Draws of the generator.
        on_scene: Called after each soundness check, which takes a quarter of a second.
    """
    n_sound = 0
    for draw in draws:
        n_sound += fault(draw.projected) is None
        on_scene()
    yield higher("draws sound, after", 100 * n_sound / len(draws), "%", LEAST_SOUND)
    rejected = 100 * sum(draw.is_rejected for draw in draws) / len(draws)
    yield lower("draws rejected", rejected, "%")
    by = displacement([draw.raw for draw in draws], [draw.projected for draw in draws])
    yield lower("displacement, median", by.median_m, "m", MOST_MEDIAN_M)
    yield lower("displacement, mean", by.mean_m, "m")
    yield lower("displacement, p95", by.p95_m, "m")
    yield lower("objects moved by over 1 cm", 100 * by.moved_share, "%")
    yield lower("objects resized by over 1 cm", 100 * by.resized_share, "%")
    yield lower("objects dropped", 100 * by.dropped_share, "%", MOST_DROPPED)


def comparison(figures: Mapping[str, Figures]) -> Iterator[Row]:
    """Compare every figure before and after feasibility with the corpus's own.

    If a group has nothing to judge for a figure, such as bridges, it gets no row.

    Args:
        figures: Figures by group: `TEST` and `TRAIN` always, `RAW` if the scenes before feasibility
            are known, `FEASIBLE` if enough scenes were not rejected.
    """
    table = {row.key: row for row in comparison_rows(figures)}
    parts = ((_BY_SCENE, TEST), (_OF_SETS, TRAIN), (_OF_COPIES, TEST), (_OF_PLACES, TEST))
    for keys, truth in parts:
        for key in keys:
            for group in (RAW, FEASIBLE, truth):
                # NaN stands for a figure with nothing to judge.
                if group in figures and not math.isnan(table[key].values[group]):
                    yield _compared(table[key], group, _target(key, group, table))


def _target(key: str, group: str, table: Mapping[str, ComparisonRow]) -> float | None:
    if group != FEASIBLE:
        return None
    if key in _COLLISIONS:
        return table[key].values[TEST]
    # Feasibility may not move the scenes away from the corpus, up to the noise of the figure.
    if key == "mmd" and RAW in table[key].values:
        return table[key].values[RAW] + table["mmd_noise"].values[RAW]
    if key == "training_distance":
        return LEAST_DISTANCE_SHARE * table[key].values[TEST]
    return _GOALS.get(key)


def _compared(row: ComparisonRow, group: str, target: float | None) -> Row:
    row_of = lower if row.better == "lower" else higher
    return row_of(f"{row.title}, {group}", row.values[group], row.unit, target)


def statistics_rows(scenes: Sequence[Scene]) -> Iterator[Row]:
    """Yield averages beside those of the paper's table, with their difference.

    Args:
        scenes: Finished scenes, at least one.
    """
    summaries = [summarise(scene, index) for index, scene in enumerate(scenes)]
    categories = {i: {obj.category for obj in scene.objects} for i, scene in enumerate(scenes)}
    for row in paper_table(summaries, categories):
        if row.is_average and row.deviation is not None:
            title, value = row.title.strip().lower(), row.ours["total"] or 0.0
            yield higher(f"{title}, mean", value, f"paper {row.paper['total']:g}")
            off = 100 * abs(row.deviation)
            yield lower(f"{title}, off the paper's", off, "%", MOST_DEVIATION)
