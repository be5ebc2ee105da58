"""Copies of training scenes: distance to the nearest one, and skeletons that recur.

The distance is that of `aeroscene.metrics.diversity`, the least under the eight symmetries of the
square, so that a turned or mirrored training scene is found too. Scenes that were made without a
look at training have a nearest training scene as well. The test split's own distances are therefore
the measure.

A skeleton is the tree of parents and children by category, whatever the order of siblings. Its
content is the number of objects of each category, whatever bears them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.arrays import SceneArrays
from aeroscene.metrics.diversity import Sketches, distances_between

_EXTENT = -1
"""Category of the root, which bears objects without a parent."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Nearness:
    """Distances of scenes to their nearest training scenes."""

    median: float
    """Median distance, in layout radii."""
    least: float
    copied_share: float
    """Share of scenes that are nearer than any of the test split."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recurrence:
    """Share of scenes whose skeleton occurs in training."""

    content: float
    """Share of scenes whose multiset of categories occurs."""
    tree: float
    """Share of scenes whose whole tree occurs."""
    coarse_tree: float
    """Share of scenes whose tree of coarse objects occurs."""


@dataclass(frozen=True, slots=True, eq=False)
class KnownSkeletons:
    """The skeletons of training."""

    contents: frozenset[Hashable]
    trees: frozenset[Hashable]
    coarse_trees: frozenset[Hashable]

    @classmethod
    def from_scenes(cls, scenes: Sequence[SceneArrays]) -> KnownSkeletons:
        """Collect the skeletons of scenes."""
        return cls(
            frozenset(map(_content, scenes)),
            frozenset(map(_tree, scenes)),
            frozenset(map(_coarse_tree, scenes)),
        )

    def recurrence(self, scenes: Sequence[SceneArrays]) -> Recurrence:
        """Return the shares of scenes whose contents, tree or coarse tree are known."""
        # An empty group has shares of 0.
        count = max(len(scenes), 1)
        return Recurrence(
            content=sum(_content(arrays) in self.contents for arrays in scenes) / count,
            tree=sum(_tree(arrays) in self.trees for arrays in scenes) / count,
            coarse_tree=sum(_coarse_tree(arrays) in self.coarse_trees for arrays in scenes) / count,
        )


def training_distances(scenes: Sketches, training: Sketches) -> Float[np.ndarray, " n"]:
    """Return the distance of each scene from its nearest training scene, in layout radii.

    Args:
        scenes: Sketches of the judged scenes.
        training: Sketches of the training scenes.
    """
    return distances_between(scenes, training).min(axis=1)


def nearness(
    distances: Float[np.ndarray, " n"], test_distances: Float[np.ndarray, " m"]
) -> Nearness:
    """Summarise distances from training, beside those of the test split.

    Args:
        distances: Distances of the judged scenes.
        test_distances: Distances of the test split, at least one.
    """
    return Nearness(
        median=float(np.median(distances)),
        least=float(distances.min()),
        copied_share=float((distances < test_distances.min()).mean()),
    )


def _content(arrays: SceneArrays) -> Hashable:
    return frozenset(Counter(arrays.category.tolist()).items())


def _tree(arrays: SceneArrays) -> Hashable:
    return _canonical(arrays, np.ones(arrays.n_objects, dtype=bool))


def _coarse_tree(arrays: SceneArrays) -> Hashable:
    return _canonical(arrays, arrays.is_coarse)


def _canonical(arrays: SceneArrays, is_kept: np.ndarray) -> Hashable:
    """Return nested pairs of a category and its sorted children; equal for equal trees only."""
    children: dict[int, list] = {}
    # Children come after their parents. Backwards, every subtree is complete
    # before it joins its parent.
    for row in reversed(np.flatnonzero(is_kept).tolist()):
        parent, category = int(arrays.parent[row]), int(arrays.category[row])
        subtree = (category, tuple(sorted(children.pop(row, []))))
        children.setdefault(parent, []).append(subtree)
    return (_EXTENT, tuple(sorted(children.pop(-1, []))))
