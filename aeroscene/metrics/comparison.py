"""Groups of scenes side by side: every figure of this package, one column for each group.

    reference = Reference.measure(train, test)
    for row in comparison_table({"test": test, "generated": scenes}, reference, rng):
        print(row.title, row.values)

Real scenes belong in every such table, as many as there are judged scenes: the test split, and a
part of the training split. They show the value of each figure for scenes that could not be better.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.arrays import SceneArrays, scene_arrays
from aeroscene.metrics.classifier import classifier_accuracy
from aeroscene.metrics.collision import Among, Collisions, collisions, overlaps, total
from aeroscene.metrics.consistency import Consistency, consistency, mean_consistency
from aeroscene.metrics.discrepancy import Discrepancy, coverage, discrepancy
from aeroscene.metrics.diversity import Sketches, layout_of, sketches_of
from aeroscene.metrics.features import layout_features
from aeroscene.metrics.frequencies import Divergences, Frequencies, divergences, frequencies
from aeroscene.metrics.novelty import (
    KnownSkeletons,
    Nearness,
    Recurrence,
    nearness,
    training_distances,
)
from aeroscene.metrics.places.checks import CHECKS, place_figures
from aeroscene.metrics.semantics import NeighbourFrequencies, Plausibility, mean_plausibility
from aeroscene.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Reference by which scenes are judged, made once: four seconds for 812 and 204 scenes."""

    neighbours: NeighbourFrequencies
    """Frequencies of neighbours in training."""
    training: Sketches
    """Layouts of training, for distances to them."""
    known: KnownSkeletons
    """Skeletons of training."""
    features: Float[np.ndarray, "n f"]
    """Features of the test split."""
    frequencies: Frequencies
    """Frequencies in the test split."""
    training_distances: Float[np.ndarray, " n"]
    """Distances of the test split from training."""

    @classmethod
    def measure(
        cls,
        train: Sequence[Scene],
        test: Sequence[Scene],
        neighbours: NeighbourFrequencies | None = None,
    ) -> Reference:
        """Measure both splits of the corpus.

        Args:
            train: Training split, against which copies and neighbours are judged.
            test: Test split, against which distributions are judged.
            neighbours: Frequencies of training, if they are known already.
        """
        trained = [scene_arrays(scene) for scene in train]
        tested = [scene_arrays(scene) for scene in test]
        training = sketches_of([layout_of(scene) for scene in train])
        # Distances of the test split are the measure for copies, see `novelty`.
        sketches = sketches_of([layout_of(scene) for scene in test])
        return cls(
            neighbours=neighbours or NeighbourFrequencies.of_arrays(trained),
            training=training,
            known=KnownSkeletons.from_scenes(trained),
            features=layout_features(tested),
            frequencies=frequencies(tested),
            training_distances=training_distances(sketches, training),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Figures:
    """Every figure of one group of scenes."""

    n_scenes: int
    collisions: Mapping[Among, Collisions]
    consistency: Consistency
    plausibility: Plausibility
    divergences: Divergences
    discrepancy: Discrepancy
    coverage: float
    classifier_accuracy: float
    nearness: Nearness
    recurrence: Recurrence
    places: Mapping[str, float]
    """Figures of the checks of places under their keys; nan if a check judges nothing."""


def figures_of(scenes: Sequence[Scene], reference: Reference, rng: np.random.Generator) -> Figures:
    """Measure a group of scenes.

    Args:
        scenes: Five scenes or more.
        reference: Reference by which they are judged.
        rng: Draws bootstraps, permutations and folds.

    Raises:
        TooFewScenesError: If there are fewer.
    """
    group = [scene_arrays(scene) for scene in scenes]
    features = layout_features(group)
    sketches = sketches_of([layout_of(scene) for scene in scenes])
    distances = training_distances(sketches, reference.training)
    return Figures(
        n_scenes=len(group),
        collisions=_collisions(group),
        consistency=mean_consistency([consistency(arrays) for arrays in group]),
        plausibility=mean_plausibility([reference.neighbours.plausibility(each) for each in group]),
        divergences=divergences(frequencies(group), reference.frequencies),
        discrepancy=discrepancy(features, reference.features, rng),
        coverage=coverage(features, reference.features),
        classifier_accuracy=classifier_accuracy(features, reference.features, rng),
        nearness=nearness(distances, reference.training_distances),
        recurrence=reference.known.recurrence(group),
        places=place_figures(scenes),
    )


def _collisions(group: Sequence[SceneArrays]) -> dict[Among, Collisions]:
    found = [overlaps(arrays) for arrays in group]
    # Pairs are found once for each scene, and counted three times.
    kinds: tuple[Among, ...] = ("all", "not parent and child", "strangers")
    return {among: total([collisions(each, among) for each in found]) for among in kinds}


Better = Literal["lower", "higher"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonRow:
    """One figure of every group."""

    key: str
    """Name of the figure for programs."""
    title: str
    unit: str
    better: Better | None
    """Direction of better values; None if the value of real scenes is best."""
    values: Mapping[str, float]
    """Figures under the names of the groups; nan if a check of places judges nothing."""


# Key, title, unit, direction of better values, and the figure.
_ROWS: tuple[tuple[str, str, str, Better | None, Callable[[Figures], float]], ...] = (
    ("collision_rate", "collision rate, all pairs", "%", "lower",
     lambda f: 100 * f.collisions["all"].rate),
    ("collision_rate_without_family", "collision rate, not parent and child", "%", "lower",
     lambda f: 100 * f.collisions["not parent and child"].rate),
    ("colliding_objects", "objects in collision, all pairs", "%", "lower",
     lambda f: 100 * f.collisions["all"].object_share),
    ("colliding_objects_without_family", "objects in collision, not parent and child", "%", "lower",
     lambda f: 100 * f.collisions["not parent and child"].object_share),
    ("colliding_scenes_without_family", "scenes with any, not parent and child", "%", "lower",
     lambda f: 100 * f.collisions["not parent and child"].scene_share),
    ("collision_depth", "depth of a collision, all pairs", "m", "lower",
     lambda f: f.collisions["all"].mean_depth_m),
    ("collision_depth_without_family", "depth of a collision, not parent and child", "m", "lower",
     lambda f: f.collisions["not parent and child"].mean_depth_m),
    ("objects_in_strangers", "objects over 1 cm deep in a stranger", "%", "lower",
     lambda f: 100 * f.collisions["strangers"].deep_object_share),
    ("consistency", "coarse-to-fine consistency, to the border", "half diagonals", "lower",
     lambda f: f.consistency.border),
    ("consistency_centroid", "coarse-to-fine consistency, to the centroid", "half diagonals",
     "lower", lambda f: f.consistency.centroid),
    ("astray", "fine objects outside their region", "%", "lower",
     lambda f: 100 * f.consistency.astray_share),
    ("plausibility", "semantic plausibility", "nats / pair", "lower",
     lambda f: f.plausibility.total),
    ("plausibility_category", "plausibility of what stands there", "nats / pair", "lower",
     lambda f: f.plausibility.category),
    ("plausibility_place", "plausibility of where it stands", "nats / pair", "lower",
     lambda f: f.plausibility.place),
    ("category_kl", "KL of categories", "nats", "lower", lambda f: f.divergences.category),
    ("cooccurrence_kl", "KL of co-occurrence", "nats", "lower",
     lambda f: f.divergences.cooccurrence),
    ("hierarchy_kl", "KL of who carries whom", "nats", "lower", lambda f: f.divergences.hierarchy),
    ("mmd", "layout MMD", "1e-3", "lower", lambda f: 1e3 * f.discrepancy.mmd),
    ("mmd_noise", "layout MMD, standard error", "1e-3", None, lambda f: 1e3 * f.discrepancy.noise),
    ("mmd_floor", "layout MMD that 95% of real sets are below", "1e-3", None,
     lambda f: 1e3 * f.discrepancy.floor),
    ("coverage", "coverage of the test split", "%", "higher", lambda f: 100 * f.coverage),
    ("classifier_accuracy", "real-or-generated classifier's accuracy", "%", "lower",
     lambda f: 100 * f.classifier_accuracy),
    ("training_distance", "distance to the nearest training scene, median", "radii", None,
     lambda f: f.nearness.median),
    ("least_training_distance", "distance to the nearest training scene, least", "radii", None,
     lambda f: f.nearness.least),
    ("copied", "scenes nearer to training than any of the test split", "%", "lower",
     lambda f: 100 * f.nearness.copied_share),
    ("known_contents", "contents that occur in training", "%", None,
     lambda f: 100 * f.recurrence.content),
    ("known_skeletons", "skeletons that occur in training", "%", None,
     lambda f: 100 * f.recurrence.tree),
    ("known_coarse_skeletons", "coarse skeletons that occur in training", "%", None,
     lambda f: 100 * f.recurrence.coarse_tree),
    # The checks of places follow in their own order.
    *(
        (check.key, check.title, check.unit, check.better, lambda f, key=check.key: f.places[key])
        for check in CHECKS
    ),
)  # fmt: skip


def comparison_table(
    groups: Mapping[str, Sequence[Scene]],
    reference: Reference,
    rng: np.random.Generator,
    on_group: Callable[[str], object] = lambda _: None,
) -> tuple[ComparisonRow, ...]:
    """Return the rows for groups of scenes; 64 scenes take a second.

    Args:
        groups: Groups of five scenes or more, under the names of their columns.
        reference: Reference by which they are judged.
        rng: Draws bootstraps, permutations and folds.
        on_group: Called with the name of each group before it is measured.

    Raises:
        TooFewScenesError: If a group is too small.
    """
    figures = {}
    for name, scenes in groups.items():
        on_group(name)
        figures[name] = figures_of(scenes, reference, rng)
    return comparison_rows(figures)


def comparison_rows(figures: Mapping[str, Figures]) -> tuple[ComparisonRow, ...]:
    """Return the rows for groups that are measured already."""
    return tuple(
        ComparisonRow(
            key=key,
            title=title,
            unit=unit,
            better=better,
            values={name: value(of_group) for name, of_group in figures.items()},
        )
        for key, title, unit, better, value in _ROWS
    )
