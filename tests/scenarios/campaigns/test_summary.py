"""Rates with their intervals."""

import random
from collections import Counter

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


def test_groups_are_those_of_a_plain_loop():
    draw = random.Random(5)
    rows = [
        {
            "scene": str(draw.choice([3, 4, 5, 12])),
            "vehicle": draw.choice(["iris", "hummingbird"]),
            "success": (success := draw.choice([True, False, None])),
            "code": draw.choice(["landed", "contact"]) if success is not None else "no_task",
            "navigated": draw.choice([True, False, None]),
            "wind_mps": draw.choice([None, 0.0, 1.99, 2.0, 5.5, 7.0]),
            "difficulty": draw.choice(["easy", "hard", None]),
            "gnss": draw.choice(["rtk", "standard"]),
            "trial_cpu_seconds": draw.choice([1.0, 2.5, None]),
        }
        for _ in range(400)
    ]
    found = summarise_trials(pa.Table.from_pylist(rows, schema=SCHEMA))
    judged = [row for row in rows if row["success"] is not None]
    winds = {0.0: "0 to 2 m/s", 1.99: "0 to 2 m/s", 2.0: "2 to 4 m/s", 5.5: "4 to 6 m/s"}
    winds |= {7.0: "6 m/s and more", None: "unknown"}
    of = {
        "scene": lambda row: row["scene"],
        "kind": lambda row: ("mixed", "outdoor", "indoor")[int(row["scene"]) % 3],
        "wind": lambda row: winds[row["wind_mps"]],
        "difficulty": lambda row: row["difficulty"] or "unknown",
        "gnss": lambda row: row["gnss"],
        "map": lambda _: "unknown",
    }
    for name, group_of in of.items():
        n = Counter(map(group_of, judged))
        good = Counter(group_of(row) for row in judged if row["success"])
        for value, rate in found["groups"][name].items():
            assert (rate["successes"], rate["trials"]) == (good[value], n[value]), (name, value)
        assert set(found["groups"][name]) == set(n)
    came = [row for row in judged if row["navigated"] or row["success"]]
    assert found["phases"]["interaction"]["trials"] == len(came)
    assert found["codes"] == dict(Counter(row["code"] for row in rows).most_common())
    cpu = [row["trial_cpu_seconds"] for row in rows if row["trial_cpu_seconds"] is not None]
    assert found["cpu_seconds_per_trial"] == pytest.approx(sum(cpu) / len(cpu))


def test_goals_in_words_have_the_scores_of_the_field():
    rows = [
        {"goal": "naming", "success": True, "navigation_error_m": 0.1, "oracle_error_m": 0.1},
        {"goal": "chain", "success": False, "navigation_error_m": 12.0, "oracle_error_m": 4.0},
        {"goal": "chain", "success": False},
        {"goal": "area", "success": True},
        {"goal": "chain", "success": None},
    ]
    rows[0] |= {"spl": 0.8, "fate": "safe_down"}
    rows[1] |= {"spl": 0.0, "fate": "collided"}
    rows = [{"scene": "2", **row} for row in rows]
    found = summarise_trials(pa.Table.from_pylist(rows, schema=SCHEMA))["words"]
    counts = {name: score["successes"] for name, score in found.items() if "successes" in score}
    assert counts == {
        "success": 1,
        "within_5_m": 1,
        "oracle_within_5_m": 2,
        "within_20_m": 2,
        "oracle_within_20_m": 2,
        "collided": 1,
    }
    assert found["success"]["trials"] == 3
    assert found["success"]["interval_95"] == pytest.approx(wilson_interval(1, 3))
    assert found["spl"]["mean"] == pytest.approx(0.8 / 3)
    assert found["navigation_error_m"]["mean"] == pytest.approx(6.05)
    assert found["navigation_error_m"]["interval_95"][0] == 0.0


def test_without_goals_in_words_there_are_no_such_scores():
    found = summarise_trials(table(("2", "iris", True, "landed", True, 1.0, "easy")))
    assert found["words"] is None
