"""Fréchet distance between two sets of features, each taken for a normal distribution.

    d^2 = |mu_1 - mu_2|^2 + tr S_1 + tr S_2 - 2 tr (S_1 S_2)^(1/2)

    symbol  name
    mu, S   mean and covariance of a set's features

With X and Y the centred features over sqrt(n - 1), S_1 = X^T X, S_2 = Y^T Y, and the last trace is
the sum of the singular values of X Y^T. This is exact if there are fewer pictures than features.
The usual square root of the product of two singular matrices is not.

The distance of few pictures is too large, the more so the fewer there are. Compare equally many,
beside the same number of real ones.

Source: Heusel et al. 2017, "GANs Trained by a Two Time-Scale Update Rule", which calls it FID if
the features are those of the Inception network and of no other.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.discrepancy import TooFewScenesError
from aeroscene.metrics.intervals import Figure, resampled_figure

LEAST_PICTURES = 8
"""Least size of a set; fewer pictures give no useful covariance."""
# Each draw takes an eigenvalue decomposition, so there are few.
_N_DRAWS = 40


def frechet_distance(
    pictures: Float[np.ndarray, "n f"], reference: Float[np.ndarray, "m f"]
) -> float:
    """Squared Fréchet distance, the figure that is called FID.

    Args:
        pictures: Features of the set.
        reference: Features of the reference.

    Raises:
        TooFewScenesError: If a set has fewer than two pictures.
        ValueError: If features are of different length, from two networks.
    """
    return _Pair(pictures, reference, least=2).distance(np.ones(len(pictures)))


def frechet_figure(
    pictures: Float[np.ndarray, "n f"],
    reference: Float[np.ndarray, "m f"],
    rng: np.random.Generator,
) -> Figure:
    """Squared Fréchet distance with its interval.

    Args:
        pictures: Features of the set.
        reference: Features of the reference.
        rng: Draws the bootstrap.

    Raises:
        TooFewScenesError: If a set has fewer than `LEAST_PICTURES` pictures.
        ValueError: If features are of different length, from two networks.
    """
    pair = _Pair(pictures, reference, least=LEAST_PICTURES)
    return resampled_figure(pair.distance, len(pictures), rng, n_draws=_N_DRAWS)


def check_features(first: np.ndarray, second: np.ndarray, least: int) -> None:
    """Refuse sets that cannot be compared.

    Raises:
        TooFewScenesError: If a set has fewer than `least` pictures.
        ValueError: If features are of different length, from two networks.
    """
    for features in (first, second):
        if len(features) < least:
            raise TooFewScenesError(f"a set of {len(features)} pictures; valid: {least} or more")
    if first.shape[1] != second.shape[1]:
        raise ValueError(
            f"features are of {first.shape[1]} and {second.shape[1]} numbers, of two networks; "
            "valid: both of one"
        )


class _Pair:
    """Two sets, as the products of their features: a resampling needs nothing else."""

    def __init__(self, pictures: np.ndarray, reference: np.ndarray, least: int) -> None:
        check_features(pictures, reference, least)
        # Relative to the reference's mean: otherwise large numbers would cancel
        # in the differences below.
        first = pictures.astype(float) - reference.mean(axis=0, dtype=float)
        second = reference.astype(float) - reference.mean(axis=0, dtype=float)
        self._first = first
        self._square = (first**2).sum(axis=1)
        self._across = first @ second.T / np.sqrt(len(second) - 1)
        self._reference_spread = float((second**2).sum() / (len(second) - 1))

    def distance(self, times: np.ndarray) -> float:
        """Return the distance if each picture counts the given number of times."""
        is_there = times > 0
        count = times[is_there].astype(float)
        n = count.sum()
        mean = count @ self._first[is_there] / n
        away = float(mean @ mean)
        spread = (float(count @ self._square[is_there]) - n * away) / (n - 1)
        across = self._across[is_there] - count @ self._across[is_there] / n
        across *= np.sqrt(count / (n - 1))[:, None]
        # Singular values from the smaller of the two products, which is several times faster.
        square = across @ across.T if len(across) < across.shape[1] else across.T @ across
        # Rounding may make eigenvalues slightly negative.
        shared = float(np.sqrt(np.maximum(np.linalg.eigvalsh(square), 0.0)).sum())
        return max(away + spread + self._reference_spread - 2.0 * shared, 0.0)
