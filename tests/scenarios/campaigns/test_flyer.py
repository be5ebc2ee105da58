"""Trials in a process that stays warm: the same flights as in fresh ones."""

import json
import subprocess
import sys

import pytest

from scenarios.campaigns.flyer import Flyer, Suite, Trial
from scenarios.run.hangar import Hangar
from scenarios.tasks.recipe import Recipe

FRESH = """
import json, sys
from scenarios.campaigns.flyer import Flyer, Suite, Trial
from scenarios.tasks.recipe import Recipe
with Flyer(Suite(recipe=Recipe(depth_camera=("d435",)))) as flyer:
    print(json.dumps(flyer.fly(Trial("7", "iris", int(sys.argv[1])))))
"""
SUITE = Suite(recipe=Recipe(depth_camera=("d435",)))
STUBS = "tests.scenarios.campaigns.stub_pilots"


def without_time(row):
    row = json.loads(json.dumps(row))
    return {k: v for k, v in row.items() if "seconds" not in k or k == "sim_seconds"} | {
        "real_time_factor": None
    }


@pytest.fixture(scope="module")
def flown():
    """Rows of a process that flies in two scenes and comes back, and its flyer's."""
    with Flyer(SUITE) as flyer:
        names = [("7", "iris", 1), ("field", "iris", 0), ("7", "hummingbird", 0), ("7", "iris", 0)]
        return {name: flyer.fly(Trial(*name)) for name in names}


def test_a_trial_is_the_same_in_a_warm_process_and_in_a_fresh_one(flown):
    fresh = subprocess.run(
        [sys.executable, "-c", FRESH, "0"], capture_output=True, text=True, check=True, timeout=110
    )
    warm = flown["7", "iris", 0]
    assert warm["state_hash"] is not None
    assert without_time(json.loads(fresh.stdout)) == without_time(warm)


def test_a_row_holds_task_and_verdict(flown):
    for (scene, vehicle, number), row in flown.items():
        assert row["trial_id"] == f"{scene}/{vehicle}/{number}"
        assert (row["scene"], row["vehicle"], row["trial"]) == (scene, vehicle, number)
        assert row["success"] is True, row["reason"]
        assert row["navigated"] is True
        assert row["landed_area"] == row["area"]
        assert row["trial_cpu_seconds"] > row["cpu_seconds"] > 0.0
    assert len({row["state_hash"] for row in flown.values()}) == len(flown)


def test_a_trial_without_a_flight_says_why():
    with Flyer(Suite(pilot=f"{STUBS}:Raising")) as flyer:
        row = flyer.fly(Trial("field", "iris", 0))
    assert (row["success"], row["code"]) == (False, "raised")
    assert row["reason"] == "ZeroDivisionError: no way"
    assert row["area"] is not None
    recipe = Recipe(target="perching")
    with Flyer(Suite(recipe=recipe, pilot=f"{STUBS}:Idle")) as flyer:
        row = flyer.fly(Trial("field", "iris", 0))
    assert (row["success"], row["code"]) == (None, "no_task")
    assert "joins no start to a perching area" in row["reason"]


def test_what_a_pilot_raises_is_its_own_fault_whatever_it_is():
    with Flyer(Suite(pilot=f"{STUBS}:RaisingOurs")) as flyer:
        rows = [flyer.fly(Trial("field", "iris", 0)) for _ in range(2)]
    assert [row["code"] for row in rows] == ["raised", "raised"]
    assert [row["reason"] for row in rows] == ["WorldError: mine", "SceneError: mine"]


def test_a_pilot_is_judged_by_the_assigned_area():
    with Flyer(Suite(pilot=f"{STUBS}:Idle")) as flyer:
        row = flyer.fly(Trial("field", "iris", 0))
    assert (row["success"], row["code"], row["navigated"]) == (False, "never_flew", False)


def test_the_straight_line_lands_where_nothing_stands():
    with Flyer(Suite(recipe=Recipe(wind_mps=(0.0, 0.0)), pilot="straight")) as flyer:
        row = flyer.fly(Trial("field", "iris", 0))
    assert (row["success"], row["code"]) == (True, "landed"), row["reason"]


def test_a_hangar_opens_a_scene_once_and_forgets_the_oldest():
    with Hangar() as hangar:
        first = hangar.scene("0")
        assert hangar.scene("0") is first
        hangar.scene("1"), hangar.scene("2")
        assert hangar.scene("0") is not first
