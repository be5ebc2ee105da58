"""Histograms: every value in a bin, the axis in round numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.reports.charts import histogram, nice_step

VALUES = st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=60)


@given(VALUES, VALUES)
def test_no_value_is_lost_and_the_highest_bar_is_as_high_as_the_chart(landed, failed):
    chart = histogram(np.array(landed), np.array(failed))
    heights = [(bar.landed, bar.failed) for bar in chart.bars]
    assert sum(good for good, _ in heights) * chart.most == pytest.approx(len(landed))
    assert sum(bad for _, bad in heights) * chart.most == pytest.approx(len(failed))
    assert max(good + bad for good, bad in heights) == pytest.approx(1.0)
    assert all(0.0 <= place <= 1.0 for place, _ in chart.ticks)
    assert sum(bar.width for bar in chart.bars) == pytest.approx(1.0)


def test_outliers_are_in_the_outermost_bin_and_the_axis_says_so():
    chart = histogram(np.linspace(0.0, 1.0, 200), np.array([50.0]), limit=0.5)
    assert chart.bars[-1].failed > 0.0
    assert chart.ticks[-1] == (1.0, "≥ 1")
    assert chart.limit == pytest.approx(0.5)
    assert histogram(np.linspace(0.0, 1.0, 200), np.empty(0), limit=3.0).limit is None


def test_one_value_alone_and_none_at_all():
    assert sum(bar.landed for bar in histogram(np.zeros(3), np.empty(0)).bars) == 1.0
    assert histogram(np.empty(0), np.empty(0)) is None


@pytest.mark.parametrize(
    ("least", "step"), [(0.11, 0.2), (0.2, 0.2), (3.0, 5.0), (60.0, 100.0), (1.0, 1.0)]
)
def test_steps_are_round(least, step):
    assert nice_step(least) == pytest.approx(step)
