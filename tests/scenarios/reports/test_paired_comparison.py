"""Two pilots compared pair by pair."""

import json

import numpy as np
import pytest

from scenarios.campaigns.summary import wilson_interval
from scenarios.reports.paired_comparison import CompareError, compare, newcombe_interval
from tests.scenarios.in_process import in_process
from tests.scenarios.reports.campaigns import campaign, change_manifest, row, trials

TRIALS = trials(12)
GOOD_A = [True] * 9 + [False] * 3
GOOD_B = [True] * 4 + [False] * 5 + [True] + [False] * 2


@pytest.fixture
def folders(tmp_path):
    one = campaign(tmp_path / "one", [row(*each) for each in zip(TRIALS, GOOD_A, strict=True)])
    rows = [
        row(trial, good, navigation_s=10.0 + 2 * trial.number)
        for trial, good in zip(TRIALS, GOOD_B, strict=True)
    ]
    # Other order, and a trial that the first has not flown.
    rows = [*reversed(rows), row(trials(1, "8")[0], True)]
    return one, campaign(tmp_path / "two", rows, pilot="straight")


def test_the_interval_is_newcombes():
    # Worked out by hand.
    assert newcombe_interval(36, 12, 2, 0) == pytest.approx((0.0569, 0.3404), abs=5e-5)
    # Pairs that say nothing of each other: Wilson's intervals, squared and added.
    low, high = wilson_interval(32, 64)
    reach = np.hypot(0.5 - low, high - 0.5)
    assert newcombe_interval(16, 16, 16, 16) == pytest.approx((-reach, reach))
    # Pairs that always agree tell no difference; pairs that never do tell most.
    assert newcombe_interval(32, 0, 0, 32)[1] < reach / 2
    assert newcombe_interval(0, 32, 32, 0)[1] == pytest.approx(2 * (0.5 - low))
    assert newcombe_interval(0, 0, 0, 0) == (-1.0, 1.0)


def test_the_interval_covers_the_true_difference():
    rng = np.random.default_rng(8)
    shares = np.array([0.55, 0.25, 0.05, 0.15])
    draws = rng.multinomial(60, shares, size=2000).tolist()
    covered = [low <= 0.2 <= high for low, high in (newcombe_interval(*each) for each in draws)]
    assert 0.93 <= np.mean(covered) <= 0.98


def test_pairs_are_trials_of_one_name(folders):
    found = compare(*folders)
    assert found["pairs"] == 12
    assert [found[name] for name in ("both", "a_alone", "b_alone", "neither")] == [4, 5, 1, 2]
    assert found["difference"] == pytest.approx(4 / 12)
    assert (found["a"]["success_rate"], found["b"]["success_rate"]) == (9 / 12, 5 / 12)
    assert (found["a"]["without_pair"], found["b"]["without_pair"]) == (0, 1)
    assert found["b"]["pilot"] == "straight"
    # 5 of 6 that differ: twice the chance of five or six heads.
    assert found["p_value"] == pytest.approx(2 * 7 / 64)
    easy = found["groups"]["difficulty"]["easy"]
    assert (easy["a"]["successes"], easy["b"]["successes"], easy["a"]["trials"]) == (3, 3, 4)
    assert [each["trial_id"] for each in found["differing"]] == [
        f"7/iris/{number}" for number in (4, 5, 6, 7, 8, 9)
    ]
    assert found["differing"][0] == {
        "trial_id": "7/iris/4",
        "a": "landed",
        "b": "contact",
        "difficulty": "medium",
    }


def test_medians_are_of_pairs_that_both_landed(folders):
    figures = {each["figure"]: each for each in compare(*folders)["figures"]}
    time = figures["time against the least possible"]
    assert time["pairs"] == 4
    # (8, 9, 10, 11) and (10, 12, 14, 16) over 2; differences -1, -1.5, -2, -2.5.
    assert (time["a"], time["b"], time["difference"]) == (4.75, 6.5, -1.75)
    assert figures["least clearance"]["pairs"] == 12
    assert figures["least clearance"]["interval_95"][0] is not None


def test_other_tasks_are_refused(tmp_path, folders):
    one, _ = folders
    other = campaign(tmp_path / "other", [row(TRIALS[2], True, wind_mps=1.25)])
    with pytest.raises(CompareError, match=r"trial 7/iris/2 .* wind_mps is 1.25 instead of 1.5; "):
        compare(one, other)
    start = campaign(tmp_path / "start", [row(TRIALS[2], True, start=[0.0, 0.0, 0.5])])
    with pytest.raises(CompareError, match=r"start is \[0.0, 0.0, 0.5\] instead of"):
        compare(one, start)
    elsewhere = campaign(tmp_path / "elsewhere", [row(trials(1, "8")[0], True)])
    with pytest.raises(CompareError, match="share no trial; valid: two campaigns"):
        compare(one, elsewhere)
    change_manifest(other, scenes_sha256="0" * 64)
    with pytest.raises(CompareError, match="other versions of the scenes"):
        compare(one, other)


def test_a_trial_that_died_has_no_task_and_counts_as_failed(tmp_path, folders):
    one, _ = folders
    died = {"trial_id": "7/iris/0", "scene": "7", "vehicle": "iris", "trial": 0}
    died |= {"success": False, "code": "died", "reason": "its process ended"}
    found = compare(one, campaign(tmp_path / "died", [died]))
    assert (found["pairs"], found["a_alone"], found["a"]["without_pair"]) == (1, 1, 11)


def test_the_command_prints_a_table_an_object_and_a_page(tmp_path, folders, capsys):
    page = tmp_path / "page.html"
    status, out, err = in_process(capsys, "compare", *folders, "--html", page)
    assert (status, err) == (0, "")
    assert "+33.3%" in out
    assert "A alone 5, B alone 1, both 4, neither 2; p = 0.219" in out
    assert "7/iris/9" in page.read_text()
    status, out, _ = in_process(capsys, "compare", *folders, "--json")
    assert (status, json.loads(out)["pairs"]) == (0, 12)
    status, out, err = in_process(capsys, "compare", folders[0], tmp_path / "nothing")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "is no campaign's" in err
