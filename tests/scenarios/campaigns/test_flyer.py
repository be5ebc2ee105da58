"""Trials in a process that stays warm: the same flights as in fresh ones."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scenarios.campaigns.equipment import Equipment
from scenarios.campaigns.flyer import Flyer, Suite, Trial
from scenarios.campaigns.recordings import Recordings
from scenarios.recording.summary import summarise
from scenarios.run.hangar import Hangar
from scenarios.tasks.recipe import Recipe
from scenarios.trial_data.reading import read_trial

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
        names = [("7", "hummingbird", 0), ("49", "iris", 0), ("7", "iris", 0)]
        return {name: flyer.fly(Trial(*name)) for name in names}


def test_a_trial_is_the_same_in_a_warm_process_and_in_a_fresh_one(flown):
    fresh = subprocess.run(
        [sys.executable, "-c", FRESH, "0"], capture_output=True, text=True, check=True
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
        assert row["flight_s"] > row["navigation_s"] > row["least_navigation_s"] > 0.0
        assert row["energy_j"] > 0.0
        assert row["replans"] >= 0
        assert row["planned_enu_m"][0] == pytest.approx(row["start"], abs=0.01)
        assert row["flown_enu_m"][0][:2] == pytest.approx(row["start"][:2], abs=0.02)
        assert row["trial_cpu_seconds"] > row["cpu_seconds"] > 0.0
    assert len({row["state_hash"] for row in flown.values()}) == len(flown)


def test_a_row_holds_the_task_itself_with_a_flight_and_without():
    """`compare` refuses pairs whose tasks differ by a rounding."""
    trial = Trial("2", "hummingbird", 0)  # Its start has four decimals.
    for pilot in ("Raising", "Idle"):
        with Flyer(Suite(pilot=f"{STUBS}:{pilot}")) as flyer:
            task, row = flyer.task(trial).to_plain(), flyer.fly(trial)
        assert {name: row[name] for name in task} == task


def test_a_trial_without_a_flight_says_why():
    with Flyer(Suite(pilot=f"{STUBS}:Raising")) as flyer:
        row = flyer.fly(Trial("7", "iris", 0))
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
        rows = [flyer.fly(Trial("7", "iris", 0)) for _ in range(2)]
    assert [row["code"] for row in rows] == ["raised", "raised"]
    assert [row["reason"] for row in rows] == ["WorldError: mine", "SceneError: mine"]


def test_a_pilot_is_judged_by_the_assigned_area():
    with Flyer(Suite(pilot=f"{STUBS}:Idle")) as flyer:
        row = flyer.fly(Trial("7", "iris", 0))
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


CAMERAS = {
    f"/world/vehicle/camera_{name}/{kind}"
    for name in ("down", "forward")
    for kind in ("rgb", "depth")
}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A trial at every level of recording: its row, and what is in its recording."""
    folder = tmp_path_factory.mktemp("levels")
    suite = Suite(
        recipe=Recipe(wind_mps=(0.0, 0.0)),
        pilot="straight",
        equipment=Equipment(camera_size="64x48"),
    )
    trial, found = Trial("field", "iris", 0), {}
    with Flyer(suite) as flyer:
        found["none"] = flyer.fly(trial), None
        for level in ("summary", "state", "interaction", "full"):
            recordings = Recordings(folder=folder / level, level=level)
            path = recordings.path(trial.id)
            path.parent.mkdir()
            path.write_bytes(b"what a process has left that was killed")
            flyer._suite = replace(suite, recordings=recordings)  # the same warm scene
            row = flyer.fly(trial)
            assert row["recording"] == str(path)
            found[level] = row, summarise(path)
    return found


@pytest.mark.timeout(600)
def test_a_trial_is_the_same_flight_at_every_level(recorded):
    assert len({row["state_hash"] for row, _ in recorded.values()}) == 1
    assert recorded["none"][0]["recording"] is None
    for level, (row, summary) in recorded.items():
        if summary is not None:
            assert summary.is_complete, level
            assert summary.verdict["state_hash"] == row["state_hash"]
            assert summary.config["record_level"] == level


@pytest.mark.timeout(600)
def test_a_level_holds_what_it_says(recorded):
    rows = {level: summary.entities for level, (_, summary) in recorded.items() if summary}
    n = round(250 * recorded["none"][0]["sim_seconds"])
    for level in ("state", "interaction", "full"):
        for entity in ("imu/acceleration", "imu/angular_rate"):
            assert rows[level][f"/sensors/{entity}"] == n
        for entity in ("/motors/command", "/motors/speed", "/world/vehicle"):
            assert rows[level][entity] == n
        for what, axis in (("position", "up"), ("velocity", "up"), ("angular_rate", "left")):
            assert rows[level][f"/state/{what}/{axis}"] == n // 5
    assert not CAMERAS & rows["state"].keys()
    assert CAMERAS & rows["interaction"].keys() == {c for c in CAMERAS if c.endswith("depth")}
    assert rows["full"].keys() >= CAMERAS
    for camera in ("down", "forward"):
        entity = f"/world/vehicle/camera_{camera}/depth"
        assert 5 <= rows["interaction"][entity] < rows["full"][entity] / 2
    assert set(rows["summary"]) <= {
        "/autopilot/statustext",
        "/contacts/touched",
        "/world/contacts",
        "/world/trajectory/executed",
    }
    assert rows["summary"]["/world/trajectory/executed"] >= n // 50
    sizes = [recorded[level][1].size_bytes for level in ("summary", "state", "interaction", "full")]
    assert sizes == sorted(sizes)
    assert sizes[0] < 100_000


@pytest.mark.timeout(600)
def test_a_recording_tells_flight_from_ground(recorded):
    trial = read_trial(Path(recorded["state"][0]["recording"]))
    touching = trial.tables["states"]["is_touching"].to_numpy()
    up_m = trial.tables["states"]["position_true_up_m"].to_numpy()
    assert touching[-1]
    assert not touching[np.argmax(up_m)]


def test_what_is_recorded_is_no_part_of_what_decides_the_outcome(tmp_path):
    suite = Suite(recordings=Recordings(folder=tmp_path, level="state"))
    assert suite == Suite()
    assert suite.to_plain() == Suite().to_plain()
