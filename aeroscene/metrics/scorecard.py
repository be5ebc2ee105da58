"""Every figure about layouts of one group of scenes, each with its 95% interval.

    yardstick = Yardstick.from_scenes(train)
    for key, figure in layout_figures(scenes, yardstick, rng).items():
        print(METRICS[key].title, figure.value, figure.low, figure.high)

Scenes are compared with the training split, because a method was given nothing else. The real
scenes to compare with are then the test split, which no method has seen. Copying shows in the
distance to the nearest training scene, which should be as large as the test split's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.arrays import SceneArrays, scene_arrays
from aeroscene.metrics.classifier import N_FOLDS, accuracy_figure
from aeroscene.metrics.collision import Among, collisions, overlaps
from aeroscene.metrics.consistency import consistency
from aeroscene.metrics.discrepancy import (
    N_NEAREST,
    TooFewScenesError,
    layout_kernel,
    squared_distances,
    squared_mmd,
)
from aeroscene.metrics.diversity import Sketches, layout_of, sketches_of
from aeroscene.metrics.features import layout_features
from aeroscene.metrics.frequencies import Frequencies, frequencies, kl_divergence
from aeroscene.metrics.intervals import (
    Figure,
    mean_figure,
    median_figure,
    ratio_figure,
    resamples,
    set_figure,
)
from aeroscene.metrics.novelty import training_distances
from aeroscene.metrics.orientation import TurnFrequencies
from aeroscene.metrics.places.checks import CHECKS, PlaceCheck
from aeroscene.metrics.places.top_view import TopView
from aeroscene.metrics.semantics import NeighbourFrequencies
from aeroscene.scene import Scene

LEAST_SCENES = N_FOLDS
"""Least size of a group: a classifier needs a scene for each fold."""
# Draws for figures about the group as a whole, which take longer than means.
_N_DRAWS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """Title, unit and direction of a figure."""

    title: str
    unit: str
    better: Literal["lower", "higher"] | None = "lower"
    """Direction of better values; None if the value of real scenes is best."""


def _of_check(check: PlaceCheck) -> Metric:
    return Metric(title=check.title, unit=check.unit, better=check.better)


METRICS: Mapping[str, Metric] = {
    "CR": Metric(title="collision rate, all pairs", unit="%"),
    "CFC": Metric(title="coarse-to-fine consistency, to the border", unit="half diagonals"),
    "CFC-centroid": Metric(
        title="coarse-to-fine consistency, to the centroid", unit="half diagonals"
    ),
    "SP": Metric(title="semantic plausibility", unit="nats / pair"),
    "OP": Metric(title="orientation plausibility", unit="nats / object"),
    "colliding_objects": Metric(title="objects in collision, not parent and child", unit="%"),
    "objects_in_strangers": Metric(title="objects over 1 cm deep in a stranger", unit="%"),
    "category_kl": Metric(title="KL of categories", unit="nats"),
    "cooccurrence_kl": Metric(title="KL of co-occurrence", unit="nats"),
    "mmd": Metric(title="layout MMD", unit="1e-3"),
    "classifier_accuracy": Metric(title="real-or-generated classifier's accuracy", unit="%"),
    "coverage": Metric(title="coverage of training scenes", unit="%", better="higher"),
    "training_distance": Metric(
        title="distance to the nearest training scene, median", unit="radii", better=None
    ),
    "objects": Metric(title="objects a scene", unit="objects", better=None),
    **{check.key: _of_check(check) for check in CHECKS},
}
"""Figures by key, in the order in which they are printed."""


@dataclass(frozen=True, slots=True, eq=False)
class Yardstick:
    """Training scenes in the forms with which figures compare other scenes."""

    neighbours: NeighbourFrequencies
    turns: TurnFrequencies
    sketches: Sketches
    features: Float[np.ndarray, "n f"]
    frequencies: Frequencies

    @classmethod
    def from_scenes(cls, train: Sequence[Scene]) -> Yardstick:
        """Measure training scenes; a thousand take some seconds.

        Raises:
            TooFewScenesError: If there are fewer than `LEAST_SCENES`.
        """
        _check_enough(train, "the training split")
        arrays = [scene_arrays(scene) for scene in train]
        return cls(
            neighbours=NeighbourFrequencies.of_arrays(arrays),
            turns=TurnFrequencies.of_arrays(arrays),
            sketches=sketches_of([layout_of(scene) for scene in train]),
            features=layout_features(arrays),
            frequencies=frequencies(arrays),
        )


def layout_figures(
    scenes: Sequence[Scene], yardstick: Yardstick, rng: np.random.Generator
) -> dict[str, Figure]:
    """Return all figures of `METRICS`; nan if there is nothing to judge.

    Args:
        scenes: A group of scenes.
        yardstick: Training scenes to compare with.
        rng: Draws resamplings and folds.

    Raises:
        TooFewScenesError: If there are fewer than `LEAST_SCENES`.
    """
    _check_enough(scenes, "a group")
    group = [scene_arrays(scene) for scene in scenes]
    figures = _scene_figures(group, yardstick, rng) | _set_figures(group, yardstick, rng)
    sketches = sketches_of([layout_of(scene) for scene in scenes])
    away = training_distances(sketches, yardstick.sketches)
    figures["training_distance"] = median_figure([away[i : i + 1] for i in range(len(away))], rng)
    return figures | place_figures(scenes, rng)


def _check_enough(scenes: Sequence[Scene], what: str) -> None:
    if len(scenes) < LEAST_SCENES:
        raise TooFewScenesError(f"{what} of {len(scenes)} scenes; valid: {LEAST_SCENES} or more")


def _scene_figures(
    group: Sequence[SceneArrays], yardstick: Yardstick, rng: np.random.Generator
) -> dict[str, Figure]:
    """Figures that are means over scenes."""
    found = [overlaps(arrays) for arrays in group]

    # A scene of one object has no pair that collides or is implausible. It is not judged, or it
    # would count as perfect.
    is_judged = np.array([arrays.n_objects > 1 for arrays in group])

    def of_collisions(among: Among, figure: str) -> Figure:
        shares = np.array([getattr(collisions(each, among), figure) for each in found])
        return mean_figure(np.where(is_judged, 100.0 * shares, np.nan), rng)

    fits = [consistency(arrays) for arrays in group]
    has_fine = [not arrays.is_coarse.all() for arrays in group]
    surprise = [yardstick.turns.surprise(arrays) for arrays in group]
    values = {
        "CFC": [fit.border if has else np.nan for fit, has in zip(fits, has_fine, strict=True)],
        "CFC-centroid": [
            fit.centroid if has else np.nan for fit, has in zip(fits, has_fine, strict=True)
        ],
        "SP": [
            yardstick.neighbours.plausibility(arrays).total if judged else np.nan
            for arrays, judged in zip(group, is_judged, strict=True)
        ],
        "OP": [float(each.mean()) if len(each) else np.nan for each in surprise],
        "objects": [arrays.n_objects for arrays in group],
    }
    return {
        "CR": of_collisions("all", "rate"),
        "colliding_objects": of_collisions("not parent and child", "object_share"),
        "objects_in_strangers": of_collisions("strangers", "deep_object_share"),
    } | {key: mean_figure(np.array(each, dtype=float), rng) for key, each in values.items()}


def _set_figures(
    group: Sequence[SceneArrays], yardstick: Yardstick, rng: np.random.Generator
) -> dict[str, Figure]:
    """Figures about the group as a whole."""
    n, features = len(group), layout_features(group)
    times = resamples(n, rng, _N_DRAWS)
    return {
        "category_kl": _kl_figure(group, yardstick, times, "category"),
        "cooccurrence_kl": _kl_figure(group, yardstick, times, "cooccurrence"),
        "mmd": _mmd_figure(features, yardstick.features, times),
        "classifier_accuracy": accuracy_figure(features, yardstick.features, rng),
        "coverage": _coverage_figure(features, yardstick.features, times),
    }


def _kl_figure(
    group: Sequence[SceneArrays],
    yardstick: Yardstick,
    times: np.ndarray,
    what: Literal["category", "cooccurrence"],
) -> Figure:
    # Counts of a resampled group are a product with the counts of each scene, so
    # nothing is counted anew.
    per_scene = np.array([getattr(frequencies([arrays]), what) for arrays in group])
    reference = getattr(yardstick.frequencies, what)
    draws = np.array([kl_divergence(reference, each @ per_scene) for each in times])
    return set_figure(kl_divergence(reference, per_scene.sum(axis=0)), draws, len(group))


def _mmd_figure(features: np.ndarray, reference: np.ndarray, times: np.ndarray) -> Figure:
    n, m = len(features), len(reference)
    kernel = layout_kernel(np.concatenate([features, reference]), reference)
    # One scene many times over has no pairs of different scenes.
    times = times[(times > 0).sum(axis=1) > 1]
    rows = np.concatenate([np.ones((1, n)), times.astype(float)])
    first = np.hstack([rows, np.zeros((len(rows), m))])
    second = np.hstack([np.zeros((len(rows), n)), np.ones((len(rows), m))])
    value, *draws = 1e3 * squared_mmd(kernel, first, second)
    return set_figure(float(value), np.array(draws), n, least=None)


def _coverage_figure(features: np.ndarray, reference: np.ndarray, times: np.ndarray) -> Figure:
    """Coverage as `aeroscene.metrics.discrepancy.coverage`, in percent."""
    within = squared_distances(reference, reference)
    np.fill_diagonal(within, np.inf)
    radius = np.sort(within, axis=1)[:, min(N_NEAREST, len(reference) - 1) - 1]
    is_near = squared_distances(reference, features) <= radius[:, None]
    draws = [100.0 * float(is_near[:, each > 0].any(axis=1).mean()) for each in times]
    # Resampled groups have fewer different scenes and cover less, so their mean is not the figure.
    value = 100.0 * float(is_near.any(axis=1).mean())
    return set_figure(value, np.array(draws), len(features))


def place_figures(scenes: Sequence[Scene], rng: np.random.Generator) -> dict[str, Figure]:
    """Return the checks of places with their intervals.

    Args:
        scenes: Scenes to judge.
        rng: Draws the bootstrap.

    Returns:
        A figure for each of `aeroscene.metrics.places.checks.CHECKS`, by key.
    """
    views = [TopView(scene) for scene in scenes]
    return {check.key: _place_figure(check, views, rng) for check in CHECKS}


def _place_figure(check: PlaceCheck, views: Sequence[TopView], rng: np.random.Generator) -> Figure:
    scale = 100.0 if check.unit == "%" else 1.0
    values = [scale * check.judge(view).astype(float) for view in views]
    if check.is_median:
        return median_figure(values, rng)
    # Objects of one scene are not independent, so whole scenes are resampled.
    means = np.array([each.mean() if len(each) else np.nan for each in values])
    return ratio_figure(means, np.array([len(each) for each in values], dtype=float), rng)
