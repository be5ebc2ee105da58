"""Distance between two sets of scenes as sets of points: maximum mean discrepancy, coverage.

    MMD^2 = mean k(x, x') + mean k(y, y') - 2 mean k(x, y)      over pairs of different scenes

k is the mean of three Gaussian kernels whose widths are 1/2, 1 and 2 of the median distance within
the reference. The estimate is unbiased: if both sets are drawn alike it is 0 on average, and below
zero as often as above. Its noise comes from resampling the scenes (bootstrap), and is up to twice
too wide if the sets are alike. Its floor comes from exchanging scenes between the sets
(permutations).

Coverage is the share of reference scenes that have a scene of the set among their nearest: within
the distance of their fifth nearest reference scene.

Source: Gretton et al. 2012, "A Kernel Two-Sample Test"; Naeem et al. 2020, "Reliable Fidelity and
Diversity Metrics for Generative Models".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

_WIDTHS = (0.5, 1.0, 2.0)
N_NEAREST = 5
# Draws of the bootstrap and of the permutations.
_N_DRAWS = 200
_FLOOR_QUANTILE = 0.95


class TooFewScenesError(ValueError):
    """A set is too small for a figure about its distribution."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Discrepancy:
    """Squared maximum mean discrepancy of two sets."""

    mmd: float
    """Unbiased estimate, which may be negative."""
    noise: float
    """Standard error of `mmd`, rather too wide near zero."""
    floor: float
    """Value below which 95% of sets drawn alike stay."""


def squared_distances(
    first: Float[np.ndarray, "n f"], second: Float[np.ndarray, "m f"]
) -> Float[np.ndarray, "n m"]:
    """Return the squared distance of every row of one array from every row of another."""
    square = (first**2).sum(axis=1)[:, None] + (second**2).sum(axis=1)
    # Rounding can make the difference of large squares negative.
    return np.maximum(square - 2.0 * first @ second.T, 0.0)


def discrepancy(
    scenes: Float[np.ndarray, "n f"], reference: Float[np.ndarray, "m f"], rng: np.random.Generator
) -> Discrepancy:
    """Return the MMD of two sets of `aeroscene.metrics.features`, with its noise and its floor.

    Args:
        scenes: Features of the set.
        reference: Features of the reference.
        rng: Draws bootstraps and permutations.

    Raises:
        TooFewScenesError: If a set has fewer than two scenes.
    """
    n, m = _enough(scenes), _enough(reference)
    kernel = layout_kernel(np.concatenate([scenes, reference]), reference)
    is_first = np.arange(n + m) < n
    drawn = np.hstack([_resampled(n, rng), _resampled(m, rng)])
    exchanged = rng.permuted(np.tile(is_first, (_N_DRAWS, 1)), axis=1).astype(float)
    return Discrepancy(
        mmd=float(squared_mmd(kernel, is_first[None] * 1.0, ~is_first[None] * 1.0)[0]),
        noise=float(squared_mmd(kernel, drawn * is_first, drawn * ~is_first).std(ddof=1)),
        floor=float(np.quantile(squared_mmd(kernel, exchanged, 1.0 - exchanged), _FLOOR_QUANTILE)),
    )


def _enough(points: np.ndarray) -> int:
    if len(points) < 2:
        raise TooFewScenesError(f"a set of {len(points)} scenes; valid: two or more")
    return len(points)


def _resampled(count: int, rng: np.random.Generator) -> Float[np.ndarray, "draws n"]:
    """Number of times each scene is drawn with replacement, at least two different ones."""
    times = rng.multinomial(count, np.full(count, 1 / count), _N_DRAWS).astype(float)
    # One scene many times over has no pairs of different scenes; such a
    # draw takes every scene once.
    return np.where((times > 0).sum(axis=1, keepdims=True) > 1, times, 1.0)


def layout_kernel(points: np.ndarray, reference: np.ndarray) -> Float[np.ndarray, "k k"]:
    """Return the kernel of all points with each other; the reference decides its widths."""
    within = squared_distances(reference, reference)[np.triu_indices(len(reference), 1)]
    # Equal reference scenes would give a width of 0.
    median = max(float(np.median(within)), 1e-12)
    apart = squared_distances(points, points)
    return np.mean([np.exp(-apart / (2.0 * width**2 * median)) for width in _WIDTHS], axis=0)


def squared_mmd(
    kernel: Float[np.ndarray, "k k"],
    first: Float[np.ndarray, "draws k"],
    second: Float[np.ndarray, "draws k"],
) -> Float[np.ndarray, " draws"]:
    """Squared discrepancy, for each draw of how often each scene is in either set.

    Args:
        kernel: Kernel of all scenes of both sets with each other.
        first: How often each is in the first set, in each draw.
        second: How often each is in the second set.
    """
    across = ((first @ kernel) * second).sum(axis=1)
    return (
        _mean_within(kernel, first)
        + _mean_within(kernel, second)
        - 2.0 * across / (first.sum(axis=1) * second.sum(axis=1))
    )


def _mean_within(kernel: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Mean over pairs of different scenes; a scene that is drawn twice is no pair with itself."""
    of_itself = (weight**2) @ kernel.diagonal()
    total = ((weight @ kernel) * weight).sum(axis=1) - of_itself
    return total / (weight.sum(axis=1) ** 2 - (weight**2).sum(axis=1))


def coverage(scenes: Float[np.ndarray, "n f"], reference: Float[np.ndarray, "m f"]) -> float:
    """Share of reference scenes with a scene of the set as near as their fifth nearest.

    Args:
        scenes: Features of the set.
        reference: Features of the reference.

    Raises:
        TooFewScenesError: If a set has fewer than two scenes.
    """
    n_nearest = min(N_NEAREST, _enough(reference) - 1)
    _enough(scenes)
    within = squared_distances(reference, reference)
    np.fill_diagonal(within, np.inf)
    radius = np.sort(within, axis=1)[:, n_nearest - 1]
    return float((squared_distances(reference, scenes).min(axis=1) <= radius).mean())
