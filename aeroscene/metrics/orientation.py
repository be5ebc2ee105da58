"""Orientation plausibility: how common an object's heading is in training.

    OP = - mean over objects i of log P(b_ih, t_ih | c_i, c_h, d_ih),    h = host of i

    symbol  name                                                                      unit
    c_i     category of object i                                                      -
    d_ih    distance in the plane from i to h, in the bins of `neighbours`            -
    b_ih    bearing of h as seen from i: 0 is straight ahead, in eighths              -
    t_ih    heading of h relative to that of i, in eighths                            -
    h       the most informative of the eight nearest neighbours: least entropy of b, t
    OP      negative log-likelihood, less is more plausible                           nats / object

Semantic plausibility is the mean over all eight neighbours. Seven of them do not depend on the
heading of a chair: with 22% of real chairs turned it rose by 0.07 nats. The host of an object is
found by categories and distance alone, so turning an object does not change it: a chair's host is
its table, a car's is the road. P are frequencies in the training split. Rare combinations fall back
on c_i and c_h at any distance, then on c_i alone, then on a uniform distribution.

It stands beside the paper's SP and is no part of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from aeroscene.metrics.arrays import N_CATEGORIES, SceneArrays
from aeroscene.metrics.neighbours import N_DIRECTIONS, N_DISTANCES, N_NEIGHBOURS, neighbours_of

_N_TURNS = N_DIRECTIONS**2
"""Bearing and relative heading in one number."""
_SHAPE = (N_CATEGORIES, N_CATEGORIES, N_DISTANCES, _N_TURNS)
_WEIGHT = 8.0
"""Number of observed pairs that the more general distribution is worth."""


@dataclass(frozen=True, eq=False)
class TurnFrequencies:
    """Frequencies of headings of training objects relative to their neighbours."""

    counts: Int[np.ndarray, "c c distances turns"]

    @classmethod
    def of_arrays(cls, scenes: Iterable[SceneArrays]) -> TurnFrequencies:
        """Count the neighbours in scenes."""
        counts = np.zeros(int(np.prod(_SHAPE)), dtype=np.int32)
        for arrays in scenes:
            cells = np.ravel_multi_index(_cells(arrays), _SHAPE)
            np.add.at(counts, cells, 1)
        return cls(counts.reshape(_SHAPE))

    def plausibility(self, arrays: SceneArrays) -> float:
        """Return OP of a scene; nan if it has fewer than two objects."""
        surprise = self.surprise(arrays)
        return float(surprise.mean()) if len(surprise) else float("nan")

    def surprise(self, arrays: SceneArrays) -> Float[np.ndarray, " n"]:
        """Negative log-likelihood of each object's orientation, nats; empty with one object."""
        first, second, distance, turn = _cells(arrays)
        if not len(first):
            return np.zeros(0)
        per_object = min(N_NEIGHBOURS, arrays.n_objects - 1)
        entropy = self._entropy[first, second, distance].reshape(-1, per_object)
        # `argmin` takes the first of equally informative neighbours, which is the nearest.
        host = np.arange(arrays.n_objects) * per_object + entropy.argmin(axis=1)
        return -self._log_share[first[host], second[host], distance[host], turn[host]]

    @cached_property
    def _log_share(self) -> Float[np.ndarray, "c c distances turns"]:
        """Logarithm of P(b, t | c_i, c_h, d)."""
        of_first = self.counts.sum(axis=(1, 2))
        share = np.full(_N_TURNS, 1.0 / _N_TURNS)
        # From the most general to the most specific distribution; each is the prior of the next.
        for counts in (
            of_first[:, None, None],
            self.counts.sum(axis=2)[:, :, None],
            self.counts,
        ):
            seen = counts.sum(axis=-1, keepdims=True)
            share = (counts + _WEIGHT * share) / (seen + _WEIGHT)
        return np.log(share)

    @cached_property
    def _entropy(self) -> Float[np.ndarray, "c c distances"]:
        return -(np.exp(self._log_share) * self._log_share).sum(axis=-1)


def _cells(arrays: SceneArrays) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Category, neighbour's category, distance and turn of each pair of neighbours."""
    near = neighbours_of(arrays)
    return (
        arrays.category[near.first],
        arrays.category[near.second],
        near.distance,
        near.direction * N_DIRECTIONS + near.heading,
    )
