"""Semantic plausibility: how common in training each pair of neighbours is, and its displacement.

    SP = - mean over objects i and their neighbours j of log P(c_j, r_ij | c_i)
       = - mean log P(c_j | c_i)  -  mean log P(r_ij | c_i, c_j)
            category part               place part

    symbol  name                                                                 unit
    c_i     category of object i                                                 -
    r_ij    displacement from i to j in bins, see `aeroscene.metrics.neighbours` -
    SP      negative log-likelihood, less is more plausible                      nats a pair

P are frequencies in the training split. Rare or absent pairs and places fall back on general
frequencies: P(c_j), then P(r | c_j), then P(r).

The paper says "the negative log-likelihood under empirical pairwise category distributions from the
training set" and leaves the pairs open. Most pairs of a scene are far from each other and have no
relation, so only neighbours count. P is conditioned on c_i, so that a scene is not judged by its
most frequent categories.

Source: AeroScene, "Evaluation Metrics", SP, and "Semantic Constraint Guidance".
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from statistics import fmean

import numpy as np
from jaxtyping import Float, Int

from aeroscene.files import replacing
from aeroscene.metrics.arrays import N_CATEGORIES, SceneArrays, scene_arrays
from aeroscene.metrics.neighbours import N_PLACES, neighbours_of
from aeroscene.scene import Scene, SceneError

_VERSION = 2
"""Format version; raise it if the bins of `aeroscene.metrics.neighbours` change."""
_SHAPE = (N_CATEGORIES, N_CATEGORIES, N_PLACES)
_CATEGORY_WEIGHT = 5.0
"""Number of observed pairs that the general share of a category is worth."""
# The same for a place among pairs of two categories, and among all pairs of the second one.
_PLACE_WEIGHT = 5.0
_GENERAL_WEIGHT = 20.0


class NeighbourFrequenciesError(SceneError):
    """A file holds no neighbour frequencies; one line has place, fault and valid files."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plausibility:
    """Negative log-likelihood in nats for each pair of neighbours; less is better."""

    category: float
    """Surprise at the neighbour's category."""
    place: float
    """Surprise at the neighbour's place, given its category."""

    @property
    def total(self) -> float:
        """SP, the sum of both parts."""
        return self.category + self.place


@dataclass(frozen=True, eq=False)
class NeighbourFrequencies:
    """Frequencies of categories and displacements of neighbours in training scenes."""

    counts: Int[np.ndarray, "c c places"]
    """Ordered pairs of neighbours by category, neighbour's category and place."""

    @classmethod
    def fit(cls, scenes: Iterable[Scene]) -> NeighbourFrequencies:
        """Count the neighbours in scenes; 812 scenes take a second.

        See `of_arrays` for scenes that are unpacked already.
        """
        return cls.of_arrays(map(scene_arrays, scenes))

    @classmethod
    def of_arrays(cls, scenes: Iterable[SceneArrays]) -> NeighbourFrequencies:
        """Count the neighbours in scenes that are arrays already.

        Callers with several figures unpack each scene once.
        """
        counts = np.zeros(np.prod(_SHAPE), dtype=np.int32)
        for arrays in scenes:
            np.add.at(counts, np.ravel_multi_index(_cells(arrays), _SHAPE), 1)
        return cls(counts.reshape(_SHAPE))

    def plausibility(self, scene: Scene | SceneArrays) -> Plausibility:
        """Return the plausibility of one scene.

        A scene with fewer than two objects has no neighbours and gets zeros.
        """
        arrays = scene_arrays(scene) if isinstance(scene, Scene) else scene
        first, second, place = _cells(arrays)
        if not len(first):
            return Plausibility(category=0.0, place=0.0)
        return Plausibility(
            category=-float(self._log_category[first, second].mean()),
            place=-float(self._log_place[first, second, place].mean()),
        )

    @cached_property
    def _log_category(self) -> Float[np.ndarray, "c c"]:
        """Logarithm of P(c_j | c_i)."""
        pairs = self.counts.sum(axis=2).astype(float)
        # One pseudo-count of each category keeps every logarithm finite.
        general = (pairs.sum(axis=0) + 1.0) / (pairs.sum() + N_CATEGORIES)
        seen = pairs.sum(axis=1, keepdims=True)
        return np.log((pairs + _CATEGORY_WEIGHT * general) / (seen + _CATEGORY_WEIGHT))

    @cached_property
    def _log_place(self) -> Float[np.ndarray, "c c places"]:
        """Logarithm of P(r | c_i, c_j)."""
        of_second = self.counts.sum(axis=0)
        everywhere = (of_second.sum(axis=0) + 1.0) / (of_second.sum() + N_PLACES)
        seen = of_second.sum(axis=1, keepdims=True)
        # Place of the second category at any neighbour, with the place of all pairs as its prior.
        general = (of_second + _GENERAL_WEIGHT * everywhere) / (seen + _GENERAL_WEIGHT)
        seen = self.counts.sum(axis=2, keepdims=True)
        return np.log((self.counts + _PLACE_WEIGHT * general) / (seen + _PLACE_WEIGHT))

    def save(self, path: str | Path) -> None:
        """Write the counts, compressed, whole or not at all.

        Raises:
            OSError: If the file cannot be written.
        """
        # Most cells are 0, so the others are written with their numbers.
        cells = np.flatnonzero(self.counts)
        with replacing(Path(path)) as file:
            np.savez_compressed(
                file, version=_VERSION, shape=_SHAPE, cells=cells, counts=self.counts.flat[cells]
            )

    @classmethod
    def load(cls, path: str | Path) -> NeighbourFrequencies:
        """Read a file of `save`.

        Raises:
            NeighbourFrequenciesError: If the file is missing, damaged, or of other bins or
                categories.
        """
        try:
            with Path(path).open("rb") as opened, np.load(opened, allow_pickle=False) as file:
                version, shape = int(file["version"]), tuple(file["shape"].tolist())
                cells, found = file["cells"], file["counts"]
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise NeighbourFrequenciesError(
                f"neighbour frequencies {str(path)!r} cannot be read ({error}); "
                "valid: a file that NeighbourFrequencies.save has written"
            ) from None
        if (version, shape) != (_VERSION, _SHAPE):
            raise NeighbourFrequenciesError(
                f"neighbour frequencies {str(path)!r}: version and shape are {version} and "
                f"{shape}; valid: {_VERSION} and {_SHAPE}; fit it again"
            )
        counts = np.zeros(_SHAPE, dtype=np.int32)
        counts.flat[cells] = found
        return cls(counts)


def mean_plausibility(parts: Sequence[Plausibility]) -> Plausibility:
    """Average plausibilities over scenes, each scene alike."""
    return Plausibility(
        category=fmean(part.category for part in parts), place=fmean(part.place for part in parts)
    )


def _cells(arrays: SceneArrays) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Category, neighbour's category and place of each pair of neighbours."""
    near = neighbours_of(arrays)
    return arrays.category[near.first], arrays.category[near.second], near.place
