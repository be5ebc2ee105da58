"""Kernel distance between two sets of features: squared maximum mean discrepancy, unbiased.

    KID = mean k(x, x') + mean k(y, y') - 2 mean k(x, y),    k(x, y) = (x y / f + 1)^3

over pairs of different pictures, with f the number of features. Unlike the Fréchet distance it does
not depend on the number of pictures. Sets that are drawn alike are at 0 on average, and below it as
often as above.

Source: Bińkowski et al. 2018, "Demystifying MMD GANs".
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.appearance.frechet import check_features
from aeroscene.metrics.discrepancy import squared_mmd
from aeroscene.metrics.intervals import Figure, resamples, set_figure

_LEAST_PICTURES = 2


def kernel_distance(
    pictures: Float[np.ndarray, "n f"], reference: Float[np.ndarray, "m f"]
) -> float:
    """KID of two sets.

    Args:
        pictures: Features of the set.
        reference: Features of the reference.

    Raises:
        TooFewScenesError: If a set has fewer than two pictures.
        ValueError: If features are of different length, from two networks.
    """
    kernel, in_set = _kernel(pictures, reference)
    return float(squared_mmd(kernel, in_set[None], 1.0 - in_set[None])[0])


def kernel_figure(
    pictures: Float[np.ndarray, "n f"],
    reference: Float[np.ndarray, "m f"],
    rng: np.random.Generator,
) -> Figure:
    """KID of two sets with its interval, which may reach below 0.

    Args:
        pictures: Features of the set.
        reference: Features of the reference.
        rng: Draws the bootstrap.

    Raises:
        TooFewScenesError: If a set has fewer than two pictures.
        ValueError: If features are of different length, from two networks.
    """
    kernel, in_set = _kernel(pictures, reference)
    n = len(pictures)
    drawn = resamples(n, rng).astype(float)
    # One picture many times over has no pairs of different pictures.
    drawn = drawn[(drawn > 0).sum(axis=1) > 1]
    times = np.zeros((len(drawn), len(kernel)))
    times[:, :n] = drawn
    outside = np.broadcast_to(1.0 - in_set, times.shape)
    value = float(squared_mmd(kernel, in_set[None], 1.0 - in_set[None])[0])
    return set_figure(value, squared_mmd(kernel, times, outside), n, least=None)


def _kernel(pictures: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    check_features(pictures, reference, _LEAST_PICTURES)
    both = np.concatenate([pictures, reference]).astype(float)
    in_set = (np.arange(len(both)) < len(pictures)).astype(float)
    return (both @ both.T / both.shape[1] + 1.0) ** 3, in_set
