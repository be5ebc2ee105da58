import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.metrics.discrepancy import (
    TooFewScenesError,
    coverage,
    discrepancy,
    squared_distances,
)


def drawn(seed, count=40, shift=0.0):
    return np.random.default_rng(seed).normal(shift, 1.0, (count, 6))


@given(st.integers(0, 10**6))
@settings(max_examples=20)
def test_distances_are_those_of_the_rows(seed):
    first, second = drawn(seed, 5), drawn(seed + 1, 7)
    exact = ((first[:, None] - second) ** 2).sum(axis=-1)
    assert squared_distances(first, second) == pytest.approx(exact, abs=1e-9)


def test_is_the_mean_kernel_within_less_that_across():
    first, second = drawn(0, 4), drawn(1, 5)
    median = np.median([np.sum((a - b) ** 2) for i, a in enumerate(second) for b in second[:i]])

    def kernel(a, b):
        apart = np.sum((a - b) ** 2)
        return np.mean([np.exp(-apart / (2 * w**2 * median)) for w in (0.5, 1.0, 2.0)])

    def within(points):
        return np.mean([kernel(a, b) for i, a in enumerate(points) for b in points[:i]])

    across = np.mean([kernel(a, b) for a in first for b in second])
    found = discrepancy(first, second, np.random.default_rng(0))
    assert found.mmd == pytest.approx(within(first) + within(second) - 2 * across)


def repeated(shift):
    found = [
        discrepancy(drawn(seed, shift=shift), drawn(1000 + seed), np.random.default_rng(seed))
        for seed in range(40)
    ]
    return found, np.array([each.mmd for each in found])


def test_noise_is_the_spread_over_repetitions():
    found, values = repeated(shift=1.0)
    assert np.mean([each.noise for each in found]) == pytest.approx(values.std(), rel=0.3)


def test_of_sets_drawn_alike_is_zero_on_average_and_its_noise_not_too_narrow():
    found, values = repeated(shift=0.0)
    assert abs(values.mean()) < 3 * values.std() / np.sqrt(len(values))
    assert values.std() < np.mean([each.noise for each in found]) < 2.2 * values.std()
    # 5% by construction, of 40.
    assert sum(each.mmd > each.floor for each in found) <= 6


def test_of_unlike_sets_is_far_above_floor_and_noise():
    found = discrepancy(drawn(0, shift=0.7), drawn(1), np.random.default_rng(0))
    assert found.mmd > 3 * found.floor > 0
    assert found.mmd > 3 * found.noise


def test_the_same_draws_give_the_same_figures():
    first, second = drawn(0), drawn(1)
    assert discrepancy(first, second, np.random.default_rng(5)) == discrepancy(
        first, second, np.random.default_rng(5)
    )


def test_coverage_is_whole_for_the_reference_and_falls_where_only_a_part_is_met():
    reference = drawn(0, 60)
    assert coverage(reference, reference) == 1.0
    assert coverage(reference[:1].repeat(9, axis=0), reference) < 0.5
    assert coverage(drawn(1, 60, shift=9.0), reference) == 0.0


def test_too_few_scenes_are_named():
    with pytest.raises(TooFewScenesError, match="a set of 1 scenes"):
        discrepancy(drawn(0, 1), drawn(1), np.random.default_rng(0))
    with pytest.raises(TooFewScenesError, match="a set of 0 scenes"):
        coverage(drawn(0, 0), drawn(1))
