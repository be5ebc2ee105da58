"""Kullback-Leibler divergences of the contents of scenes from those of reference scenes.

    KL(reference || scenes) = sum over x of p(x) log p(x) / q(x)      nats

p is the share of x among the reference scenes, q among the judged ones. Each x counts half an
occurrence more in both (Jeffreys), so that an absent category costs much but not infinitely much.
For few scenes the divergence is above zero even if nothing differs: read it beside that of equally
many real ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.arrays import N_CATEGORIES, SceneArrays

# Jeffreys' prior.
_PRIOR_COUNT = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Frequencies:
    """Counts over a set of scenes."""

    category: Float[np.ndarray, " c"]
    """Objects of each category."""
    cooccurrence: Float[np.ndarray, " pairs"]
    """Scenes in which both categories of a pair appear; a category with itself counts if it appears
    at least twice."""
    hierarchy: Float[np.ndarray, " pairs"]
    """Objects of a category by the category of their parent; the last one is "no parent"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Divergences:
    """Divergences from a reference, nats."""

    category: float
    cooccurrence: float
    hierarchy: float


def frequencies(scenes: Sequence[SceneArrays]) -> Frequencies:
    """Count categories, pairs of categories in a scene, and pairs of child and parent."""
    upper = np.triu_indices(N_CATEGORIES)
    category = np.zeros(N_CATEGORIES)
    together = np.zeros((N_CATEGORIES, N_CATEGORIES))
    carried = np.zeros((N_CATEGORIES, N_CATEGORIES + 1))
    for arrays in scenes:
        counts = np.bincount(arrays.category, minlength=N_CATEGORIES)
        category += counts
        present = (counts > 0).astype(float)
        # The diagonal asks for two objects of the category.
        together += np.outer(present, present) - np.diag(present) + np.diag(counts > 1)
        carriers = np.where(arrays.parent < 0, N_CATEGORIES, arrays.category[arrays.parent])
        np.add.at(carried, (arrays.category, carriers), 1.0)
    return Frequencies(category, together[upper], carried.ravel())


def divergences(scenes: Frequencies, reference: Frequencies) -> Divergences:
    """Return KL(reference || scenes) of all three counts.

    The direction punishes what the reference has and the scenes lack.
    """
    return Divergences(
        category=kl_divergence(reference.category, scenes.category),
        cooccurrence=kl_divergence(reference.cooccurrence, scenes.cooccurrence),
        hierarchy=kl_divergence(reference.hierarchy, scenes.hierarchy),
    )


def kl_divergence(
    reference_counts: Float[np.ndarray, " n"], counts: Float[np.ndarray, " n"]
) -> float:
    """KL divergence of the shares of `counts` from those of the reference, nats; 0 if equal.

    Entries that appear in neither are left out.
    """
    appears = (reference_counts > 0) | (counts > 0)
    if not appears.any():
        return 0.0
    p = reference_counts[appears] + _PRIOR_COUNT
    q = counts[appears] + _PRIOR_COUNT
    p, q = p / p.sum(), q / q.sum()
    return float((p * np.log(p / q)).sum())
