"""Real or generated: the accuracy of a classifier that tells a set of scenes from another.

Logistic regression with a ridge penalty on `aeroscene.metrics.features` is fitted by Newton steps
on four fifths of the scenes and tested on the rest, in turn. The accuracy is the mean of both sets'
own accuracies, so that 0.5 is a guess even if the sets differ in size. An accuracy of 1 means
that a set gives itself away.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.metrics.discrepancy import TooFewScenesError
from aeroscene.metrics.intervals import Figure, normal_figure

N_FOLDS = 5
_PENALTY = 0.001
"""Ridge penalty of each scene; features have a norm of about two."""
# Newton steps.
_N_STEPS = 12


def classifier_accuracy(
    scenes: Float[np.ndarray, "n f"], reference: Float[np.ndarray, "m f"], rng: np.random.Generator
) -> float:
    """Balanced accuracy, cross-validated, of telling the set's scenes from the reference's.

    Args:
        scenes: Features of the set.
        reference: Features of the reference.
        rng: Draws the folds.

    Raises:
        TooFewScenesError: If a set has fewer scenes than there are folds.
    """
    for points in (scenes, reference):
        if len(points) < N_FOLDS:
            raise TooFewScenesError(f"a set of {len(points)} scenes; valid: {N_FOLDS} or more")
    points = np.concatenate([scenes, reference])
    is_set = np.arange(len(points)) < len(scenes)
    fold = np.concatenate([_folds(len(scenes), rng), _folds(len(reference), rng)])
    is_right = np.zeros(len(points), dtype=bool)
    for number in range(N_FOLDS):
        asked = fold == number
        is_right[asked] = _predict(points[~asked], is_set[~asked], points[asked]) == is_set[asked]
    return float((is_right[is_set].mean() + is_right[~is_set].mean()) / 2)


def accuracy_figure(
    scenes: Float[np.ndarray, "n f"], reference: Float[np.ndarray, "m f"], rng: np.random.Generator
) -> Figure:
    """Return the accuracy in percent with its interval.

    The accuracy is the mean of two shares, one over each set, which gives its standard error.

    Raises:
        TooFewScenesError: If a set has fewer scenes than there are folds.
    """
    n, m = len(scenes), len(reference)
    accuracy = classifier_accuracy(scenes, reference, rng)
    error = 50.0 * float(np.sqrt(accuracy * (1 - accuracy) * (1 / n + 1 / m)))
    return normal_figure(100.0 * accuracy, error, n)


def _folds(count: int, rng: np.random.Generator) -> np.ndarray:
    return rng.permutation(count) % N_FOLDS


def _predict(
    points: np.ndarray, is_set: Bool[np.ndarray, " n"], asked: np.ndarray
) -> Bool[np.ndarray, " k"]:
    """Fit on some scenes and answer for others: True for the set."""
    middle = points.mean(axis=0)
    # The weights lie in the span of the points, so an SVD reduces the unknowns
    # to the number of scenes.
    left, scale, right = np.linalg.svd(points - middle, full_matrices=False)
    inputs = np.column_stack([left * scale, np.ones(len(points))])
    # Both sets weigh half, whatever their sizes.
    share = np.where(is_set, 0.5 / is_set.sum(), 0.5 / (~is_set).sum())
    # The last weight is the offset, which is not penalised.
    penalty = np.append(np.full(inputs.shape[1] - 1, _PENALTY), 0.0)
    weights = np.zeros(inputs.shape[1])
    for _ in range(_N_STEPS):
        probability = 1.0 / (1.0 + np.exp(-inputs @ weights))
        slope = inputs.T @ (share * (probability - is_set)) + penalty * weights
        # A lower bound keeps the Hessian invertible for scenes that are classified with certainty.
        spread = share * np.maximum(probability * (1.0 - probability), 1e-6)
        weights -= np.linalg.solve((inputs.T * spread) @ inputs + np.diag(penalty), slope)
    return np.column_stack([(asked - middle) @ right.T, np.ones(len(asked))]) @ weights > 0
