"""Rates with their intervals."""

import pyarrow as pa
import pytest

from scenarios.campaigns.store import SCHEMA
from scenarios.campaigns.summary import summarise_trials, wilson_interval


def table(*rows):
    keys = ("scene", "vehicle", "success", "code", "navigated", "wind_mps", "difficulty")
    return pa.Table.from_pylist([dict(zip(keys, row, strict=True)) for row in rows], schema=SCHEMA)


@pytest.mark.parametrize(
    ("n_successes", "n", "low", "high"),
    # Agresti and Coull 1998 name the last; the others by scipy.stats.binomtest.
    [(0, 0, 0.0, 1.0), (91, 100, 0.8377, 0.9519), (10, 10, 0.7225, 1.0), (0, 20, 0.0, 0.1611)],
)
def test_wilson_intervals(n_successes, n, low, high):
    assert wilson_interval(n_successes, n) == pytest.approx((low, high), abs=1e-4)


def test_success_overall_by_phase_by_group_and_reasons():
    found = summarise_trials(
        table(
            ("2", "iris", True, "landed", True, 1.0, "easy"),
            ("10", "iris", False, "slid", True, 3.0, "hard"),
            ("10", "hummingbird", False, "contact", False, 9.0, "hard"),
            ("10", "hummingbird", False, "no_plan", None, None, None),
            ("10", "hummingbird", None, "no_task", None, None, None),
        )
    )
    assert (found["trials"], found["successes"], found["without_task"]) == (4, 1, 1)
    assert found["success_rate"] == 0.25
    assert found["phases"]["navigation"]["success_rate"] == 0.5
    assert found["phases"]["interaction"]["success_rate"] == 0.5
    groups = found["groups"]
    assert list(groups["scene"]) == ["2", "10"]
    assert groups["vehicle"]["hummingbird"]["trials"] == 2
    assert list(groups["difficulty"]) == ["easy", "hard", "unknown"]
    assert set(groups["wind"]) == {"0 to 2 m/s", "2 to 4 m/s", "6 m/s and more", "unknown"}
    assert found["codes"] == {"landed": 1, "slid": 1, "contact": 1, "no_plan": 1, "no_task": 1}


def test_nothing_flown_is_no_rate():
    found = summarise_trials(SCHEMA.empty_table())
    assert (found["trials"], found["success_rate"]) == (0, None)
    assert found["interval_95"] == [0.0, 1.0]
