"""Who is first: by the better end of each column, and told apart by intervals."""

import pytest

from aeroscene.metrics.scorecard import Metric
from scenarios.evaluation.leads import leads_markdown, leads_of
from scenarios.evaluation.rows import Row

METRICS = {
    "FD": Metric(title="distance", unit="-"),
    "coverage": Metric(title="coverage", unit="%", better="higher"),
    "objects": Metric(title="objects", unit="-", better=None),
}


def row(method, metric, value, half=1.0):
    interval = None if value is None else (value - half, value + half)
    return Row(method=method, metric=metric, value=value, interval_95=interval, n=8)


ROWS = [
    row("ours", "FD", 10.0),
    row("near", "FD", 11.5),
    row("far", "FD", 40.0),
    row("ours", "coverage", 30.0),
    row("near", "coverage", 20.0),
    row("far", "coverage", 60.0),
    row("ours", "objects", 9.0),
    row("near", "objects", 9.0),
]


def test_a_lead_is_over_the_best_of_the_others_by_the_better_end_of_the_column():
    distance, coverage = leads_of("ours", ("near", "far"), ROWS, METRICS)
    assert (distance.other, distance.is_apart) == ("near", False)
    assert distance.lead_percent == pytest.approx(100 * 1.5 / 11.5)
    assert (coverage.other, coverage.is_apart) == ("far", False)
    assert coverage.lead_percent == pytest.approx(-50.0)
    (apart, _) = leads_of("ours", ("far",), ROWS, METRICS)
    assert apart.is_apart
    lines = leads_markdown([distance, apart], {"near": "Near", "far": "Far"}).splitlines()
    assert lines[2:] == [
        "| `FD` | 10 | Near | 11.5 | 13 | overlap or behind |",
        "| `FD` | 10 | Far | 40 | 75 | apart |",
    ]


def test_columns_without_a_rival_or_a_figure_are_left_out():
    rows = [row("ours", "FD", 3.0), row("near", "FD", None), row("ours", "coverage", 1.0)]
    assert leads_of("ours", ("near",), rows, METRICS) == []
    rows = [row("ours", "FD", 3.0), row("near", "FD", 0.0)]
    (behind,) = leads_of("ours", ("near",), rows, METRICS)
    assert (behind.lead_percent, behind.is_apart) == (None, False)
