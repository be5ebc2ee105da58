"""Intervals by resampling: as wide as theory says, and the same on every call."""

import numpy as np
import pytest

from aeroscene.metrics.intervals import (
    mean_figure,
    median_figure,
    ratio_figure,
    resampled_figure,
)


def test_the_interval_of_a_mean_is_two_standard_errors_on_each_side():
    values = np.random.default_rng(0).normal(3.0, 2.0, 400)
    figure = mean_figure(values, np.random.default_rng(1))
    error = values.std(ddof=1) / 20
    assert figure.value == pytest.approx(values.mean())
    assert figure.high - figure.low == pytest.approx(2 * 1.96 * error, rel=0.2)
    assert mean_figure(values, np.random.default_rng(1)) == figure


def test_intervals_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(2)
    figures = [mean_figure(rng.normal(0.0, 1.0, 40), rng) for _ in range(200)]
    assert 0.88 <= np.mean([figure.low <= 0.0 <= figure.high for figure in figures]) <= 0.99


def test_scenes_without_a_value_do_not_count():
    figure = mean_figure(np.array([1.0, np.nan, 3.0]), np.random.default_rng(0))
    assert (figure.value, figure.n) == (2.0, 2)
    nothing = mean_figure(np.array([np.nan]), np.random.default_rng(0))
    assert np.isnan(nothing.value)
    assert nothing.n == 0


def test_things_count_alike_whichever_scene_they_are_in():
    figure = ratio_figure(np.array([1.0, 0.0]), np.array([1.0, 3.0]), np.random.default_rng(0))
    assert figure.value == pytest.approx(0.25)


def test_the_median_is_over_all_things_together():
    figure = median_figure(
        [np.array([1.0, 9.0]), np.zeros(0), np.array([2.0])], np.random.default_rng(0)
    )
    assert (figure.value, figure.n) == (2.0, 2)
    assert figure.low <= 2.0 <= figure.high


def test_a_figure_of_a_set_is_not_below_what_it_can_be():
    figure = resampled_figure(
        lambda times: float(times.max() - 1) / 10, 9, np.random.default_rng(0)
    )
    assert (figure.value, figure.low) == (0.0, 0.0)
    assert figure.high > 0.0
