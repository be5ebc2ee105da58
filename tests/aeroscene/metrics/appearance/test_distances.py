"""Fréchet and kernel distances against their definitions, computed in other ways."""

import numpy as np
import pytest
from scipy.linalg import sqrtm

from aeroscene.metrics.appearance.frechet import (
    LEAST_PICTURES,
    frechet_distance,
    frechet_figure,
)
from aeroscene.metrics.appearance.kernel_distance import kernel_distance, kernel_figure
from aeroscene.metrics.discrepancy import TooFewScenesError

F = 6


def pair(n=40, m=50, seed=0, shift=0.5, stretch=1.5, f=F):
    rng = np.random.default_rng(seed)
    mix = rng.normal(size=(f, f))
    return rng.normal(size=(n, f)) @ mix, stretch * rng.normal(size=(m, f)) @ mix + shift


def by_sqrtm(first, second):
    away = first.mean(axis=0) - second.mean(axis=0)
    one, two = np.cov(first, rowvar=False), np.cov(second, rowvar=False)
    root = sqrtm(one @ two)
    return float(away @ away + np.trace(one) + np.trace(two) - 2 * np.trace(root).real)


def by_loops(first, second):
    def k(x, y):
        return (x @ y / len(x) + 1) ** 3

    n, m = len(first), len(second)
    one = np.mean([k(first[i], first[j]) for i in range(n) for j in range(n) if i != j])
    two = np.mean([k(second[i], second[j]) for i in range(m) for j in range(m) if i != j])
    return one + two - 2 * np.mean([k(x, y) for x in first for y in second])


@pytest.mark.parametrize("seed", range(4))
def test_frechet_distance_is_that_of_the_matrix_square_root(seed):
    first, second = pair(seed=seed)
    assert frechet_distance(first, second) == pytest.approx(by_sqrtm(first, second), rel=1e-6)


def test_frechet_distance_is_exact_with_fewer_pictures_than_features():
    # In the plane that the pictures span, where both covariances have full rank.
    first, second = pair(n=20, m=25, f=4)
    basis, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(60, 4)))
    wide = first @ basis.T, second @ basis.T
    assert frechet_distance(*wide) == pytest.approx(by_sqrtm(first, second), rel=1e-6)


def test_frechet_distance_of_a_shift_is_its_square():
    first, _ = pair()
    assert frechet_distance(first, first) == pytest.approx(0.0, abs=1e-4)
    assert frechet_distance(first, first + 3.0) == pytest.approx(9.0 * F, rel=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_kernel_distance_is_the_mean_over_pairs(seed):
    first, second = pair(n=12, m=15, seed=seed)
    assert kernel_distance(first, second) == pytest.approx(by_loops(first, second), rel=1e-9)


@pytest.mark.parametrize("figure_of", [frechet_figure, kernel_figure])
def test_intervals_hold_the_value_and_shrink_with_more_pictures(figure_of):
    widths = []
    for n in (20, 160):
        first, second = pair(n=n, m=60)
        figure = figure_of(first, second, np.random.default_rng(0))
        assert figure.low <= figure.value <= figure.high
        assert figure.n == n
        widths.append(figure.high - figure.low)
    assert widths[1] < 0.6 * widths[0]


def test_a_resampled_set_has_the_distance_of_its_pictures_taken_so_often():
    from aeroscene.metrics.appearance.frechet import _Pair

    first, second = pair(n=12)
    times = np.array([0, 3, 1, 1, 2, 0, 1, 1, 0, 1, 1, 1])
    repeated = np.repeat(first, times, axis=0)
    found = _Pair(first, second, least=2).distance(times)
    assert found == pytest.approx(by_sqrtm(repeated, second), rel=1e-6)


def test_too_few_pictures_are_refused_with_the_number_that_would_do():
    first, second = pair(n=LEAST_PICTURES - 1)
    with pytest.raises(TooFewScenesError, match=f"7 pictures; valid: {LEAST_PICTURES} or more"):
        frechet_figure(first, second, np.random.default_rng(0))


def test_features_of_two_networks_are_refused():
    first, second = pair()
    for distance in (frechet_distance, kernel_distance):
        with pytest.raises(ValueError, match="6 and 5 numbers, of two networks"):
            distance(first, second[:, :5])
