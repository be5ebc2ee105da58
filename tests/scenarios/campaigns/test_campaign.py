"""`aeroscene campaign`, `fly` and `report` as a user runs them, killed in between."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flightsim.testbench import TestbenchCfg
from scenarios.campaigns.campaign import (
    MANIFEST,
    CampaignError,
    open_campaign,
    read_suite,
    require_same_suite,
)
from scenarios.campaigns.equipment import MOST_CAMERA_HZ, Equipment
from scenarios.campaigns.flyer import Suite, Trial, blank_row
from scenarios.campaigns.recordings import Recordings
from scenarios.campaigns.store import JOURNAL, TABLES, open_store, read_results
from scenarios.recording.summary import summarise
from scenarios.run.cfg import MAX_CAMERA_HZ, SitlCfg
from scenarios.tasks.recipe import Recipe
from tests.scenarios.in_process import in_process

STUBS = "tests.scenarios.campaigns.stub_pilots"
TIMES = ("wall_seconds", "cpu_seconds", "trial_cpu_seconds", "real_time_factor")


def command(folder, *args):
    return [
        *(sys.executable, "-m", "aeroscene", "campaign", "--out", str(folder)),
        *("--scenes", "7", "--vehicles", "iris", "--pilot", f"{STUBS}:Slow"),
        *("--workers", "2", *args),
    ]


def results(folder):
    rows = read_results(folder).drop_columns(list(TIMES)).to_pylist()
    assert len({row["trial_id"] for row in rows}) == len(rows)
    return sorted(rows, key=lambda row: row["trial_id"])


@pytest.mark.timeout(600)
def test_a_campaign_that_is_killed_goes_on_as_if_nothing_had_been(tmp_path, capsys):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    alone = command(whole, "--trials", "6", "--json", "--workers", "1")[3:]
    status, out, err = in_process(capsys, *alone)
    assert status == 0, err
    summary = json.loads(out)
    assert summary["trials"] == 6
    assert summary["codes"] == {"never_flew": 6}
    assert json.loads((whole / "summary.json").read_text())["codes"] == summary["codes"]
    campaign = subprocess.Popen(command(killed, "--trials", "4"), stderr=subprocess.DEVNULL)
    deadline_s = time.monotonic() + 300.0
    journal = killed / JOURNAL
    while not (journal.exists() and journal.read_bytes().count(b"\n") >= 2):
        assert time.monotonic() < deadline_s
        time.sleep(0.02)
    os.kill(campaign.pid, signal.SIGKILL)
    campaign.wait()
    n_before = len(results(killed))
    assert n_before >= 2
    again = command(killed, "--trials", "6", "--workers", "1")[3:]
    status, _, err = in_process(capsys, *again)
    assert status == 0, err
    assert f"{6 - n_before} of 6 trials to fly" in err
    assert results(killed) == results(whole)
    assert not journal.read_bytes()
    assert all(path.suffix == ".parquet" for path in (killed / TABLES).iterdir())


@pytest.fixture
def campaign(tmp_path, capsys):
    """Folder of a campaign of a pilot that flies."""
    recipe = tmp_path / "recipe.toml"
    recipe.write_text('start = ["own"]\nwind_mps = [0, 1]\n')
    folder = tmp_path / "out"
    options = ("--scenes", "7", "--trials", "1", "--vehicles", "iris", "--pilot", "straight")
    more = ("--recipe", recipe, "--workers", "1", "--record", "summary", "--camera-size", "64x48")
    status, _, err = in_process(capsys, "campaign", "--out", folder, *options, *more)
    assert status == 0, err
    return folder


def test_fly_repeats_a_trial_with_a_recording_and_report_tells_of_it(campaign, capsys):
    recording = campaign / "recordings" / "7-iris-0.rrd"
    assert results(campaign)[0]["recording"] == str(recording)
    assert summarise(recording).config["record_level"] == "summary"
    status, out, err = in_process(
        capsys, "fly", "--out", campaign, "--scene", "7", "--trial", "0", "--json"
    )
    row = json.loads(out)
    assert row["same_as_campaign"] is True, err
    assert status == (0 if row["success"] else 1)
    assert row["recording"] == str(recording)
    assert summarise(recording).config["record_level"] == "full"
    assert (
        json.loads(recording.with_suffix(".json").read_text())["result"]["state_hash"]
        == (row["state_hash"])
    )
    status, out, _ = in_process(capsys, "report", campaign, "--json")
    assert (status, json.loads(out)["trials"]) == (0, 1)
    status, out, _ = in_process(capsys, "report", campaign)
    assert status == 0
    assert "95% interval" in out
    status, _, err = in_process(
        capsys, "campaign", "--out", campaign, "--scenes", "7", "--trials", "1"
    )
    assert status == 2
    assert "holds a campaign with start ['own'] instead of ['own', 'area']; valid: another" in err


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--trials", "0"), "trials 0 is out of range; valid: 1 to 1000000"),
        (("--workers", "0"), "workers 0 is out of range; valid: 1 to 10000"),
        (("--patience", "0"), "patience 0.0 is out of range; valid: above 0 s"),
        (("--scenes", "5:5"), "scenes '5:5' is no range of scenes"),
        (("--scenes", "2000"), "scenes '2000' has no scene 2000; valid: 0:1016"),
        (("--vehicles", "iris,boat"), "'boat'"),
        (("--pilot", "nobody"), "pilot is 'nobody'; valid: demo, mueller, potential, straight"),
        (("--pilot", "mavlink", "--program", "nobody"), "program 'nobody' is not there; valid: "),
        (("--program", "python x.py"), "program 'python x.py' needs --pilot mavlink"),
        (("--pilot", "mavlink", "--engine", "ray"), "waits on loopback; valid: --engine local"),
        (("--pilot", "mavlink", "--instance", "100"), "instance 100 is out of range; valid: 0 to"),
        (("--ray-address", "auto"), "ray-address 'auto' needs --engine ray"),
        (("--lidar", "sonar"), "lidar 'sonar'"),
        (("--camera-size", "1x1"), "camera-size '1x1' is not valid; valid: WIDTHxHEIGHT"),
        (("--suite", "aeroscene-300", "--lidar", "vlp16"), "are fixed by suite 'aeroscene-300'"),
        (("--recipe", "none.toml"), "recipe 'none.toml': No such file"),
        (("--pilot", "random"), "pilot is 'random', which reads goals in words, and goals of"),
        (("--model", "m"), "model 'm' needs --endpoint"),
        (("--out", "/proc/none"), "file '/proc/none': no such file or directory"),
    ],
)
def test_bad_input_is_one_line_and_status_2(tmp_path, capsys, args, says):
    status, out, err = in_process(capsys, "campaign", "--out", tmp_path / "out", *args)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert err.startswith("aeroscene campaign: error: ")
    assert says in err


def test_a_pilot_that_only_raises_is_told_after_one_trial_and_ends_with_status_1(tmp_path, capsys):
    folder = tmp_path / "my runs"
    args = ("--scenes", "7", "--trials", "2", "--vehicles", "iris", "--workers", "1")
    status, out, err = in_process(
        capsys, "campaign", "--out", folder, "--pilot", f"{STUBS}:Raising", *args
    )
    assert status == 1
    begin, reason, hint, *progress = err.splitlines()
    assert begin == "aeroscene campaign: 2 of 2 trials to fly"
    assert reason.startswith("aeroscene campaign: first trial that is raised: 7/iris/")
    assert reason.endswith(": ZeroDivisionError: no way")
    assert f"aeroscene fly --out '{folder}' --scene 7 --vehicle iris --trial " in hint
    assert progress == [
        "aeroscene campaign: 1 of 2 trials flown, success so far 0.0%; 1 raised",
        "aeroscene campaign: 2 of 2 trials flown, success so far 0.0%; 2 raised",
    ]
    assert f"More: aeroscene report '{folder}'" in out
    # Nothing is left to fly, and still nothing is scored.
    again, _, _ = in_process(
        capsys, "campaign", "--out", folder, "--pilot", f"{STUBS}:Raising", *args
    )
    assert again == 1


EQUIPPED = ("--segmentation", "--lidar", "mid40", "--optical-flow", "--camera-size", "64x48")


def test_vehicles_of_a_campaign_carry_the_cameras_and_sensors_of_sitl(tmp_path, capsys):
    args = ("campaign", "--out", tmp_path, "--scenes", "7", "--trials", "1", "--vehicles", "iris")
    more = ("--pilot", f"{STUBS}:Idle", "--workers", "1", "--record", "full", "--camera-hz", "10")
    status, _, err = in_process(capsys, *args, *more, *EQUIPPED)
    assert status == 0, err
    config = summarise(tmp_path / "recordings" / "7-iris-0.rrd").config
    bench = config["bench"]
    assert (bench["segmentation"], bench["lidar"], bench["optical_flow"]) == (True, "mid40", True)
    assert (bench["camera_size"], config["camera_hz"]) == ("64x48", 10.0)
    suite = read_suite(tmp_path)
    assert suite is not None
    assert suite.equipment.lidar == "mid40"
    status, _, err = in_process(capsys, *args, *more)
    assert status == 2
    assert "holds a campaign with camera_size '64x48' instead of '320x240'" in err


def test_a_campaign_of_before_there_was_equipment_goes_on(tmp_path):
    with open_campaign(tmp_path, Suite()):
        pass
    manifest = tmp_path / MANIFEST
    plain = json.loads(manifest.read_text())
    del plain["suite"]["equipment"]
    manifest.write_text(json.dumps(plain))
    assert read_suite(tmp_path) == Suite()
    require_same_suite(tmp_path, Suite())
    with pytest.raises(CampaignError, match="lidar '' instead of 'vlp16'"):
        require_same_suite(tmp_path, Suite(equipment=Equipment(lidar="vlp16")))


def test_a_recipe_in_another_light_is_another_suite(tmp_path):
    with open_campaign(tmp_path, Suite(recipe=Recipe(light=("night",)))):
        pass
    with pytest.raises(CampaignError, match=r"light \['night'\] instead of \['random'\]"):
        require_same_suite(tmp_path, Suite(recipe=Recipe(light=("random",))))


def test_light_and_season_are_the_recipes_unless_the_equipment_names_them():
    cfg = SitlCfg(scene="field", bench=TestbenchCfg(light="night", season="winter"))
    for equipment, light, season in (
        (Equipment(), "night", "winter"),
        (Equipment(light="dusk"), "dusk", "winter"),
        (Equipment(season="spring"), "night", "spring"),
    ):
        bench = equipment.fitted(cfg).bench
        assert (bench.light, bench.season) == (light, season)


def test_equipment_has_the_options_and_defaults_of_sitl():
    bench = TestbenchCfg()
    for name, value in Equipment().to_plain().items():
        if name not in {"light", "season"}:
            assert getattr(bench, name) == value
    assert MOST_CAMERA_HZ == MAX_CAMERA_HZ
    assert SitlCfg().camera_hz == Recordings(folder=Path()).camera_hz


def test_without_ray_its_engine_is_refused_in_a_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    args = ("--out", tmp_path / "out", "--trials", "1", "--engine", "ray", "--pilot", "straight")
    status, out, err = in_process(capsys, "campaign", *args)
    assert (status, out) == (2, "")
    assert "needs ray, which is not installed: pip install 'aeroscene[cluster]'" in err


def test_a_dry_run_tells_what_is_left_and_writes_nothing(tmp_path, capsys):
    args = ("campaign", "--out", tmp_path / "out", "--scenes", "7", "--trials", "4", "--dry-run")
    status, out, _ = in_process(capsys, *args)
    assert status == 0
    assert out.startswith("8 of 8 trials to fly\nHow long that takes can be told when")
    assert not (tmp_path / "out").exists()
    with open_campaign(tmp_path / "out", Suite()):
        pass
    with open_store(tmp_path / "out") as results:
        for number, cost_s in enumerate((7.0, 2.0)):
            trial = Trial("7", "iris", number)
            results.add(blank_row(trial) | {"trial_cpu_seconds": cost_s})
    status, out, _ = in_process(capsys, *args, "--workers", "2", "--json")
    plan = json.loads(out)
    assert (status, plan["trials"], plan["to_fly"]) == (0, 8, 6)
    # Two workers start in 3 s; 7 s for a trial that opens scene and vehicle, 2 s for the others.
    assert plan["cpu_seconds"] == 2 * 3 + 7 * plan["openings"] + 2 * (6 - plan["openings"])
    assert plan["cpu_seconds"] / 2 <= plan["wall_seconds"] < plan["cpu_seconds"]
    status, _, err = in_process(capsys, *args, "--pilot", "straight")
    assert status == 2
    assert "holds a campaign with pilot 'demo' instead of 'straight'" in err


def test_fly_and_report_refuse_what_is_not_there(tmp_path, capsys):
    for args, says in (
        (("report", tmp_path), "holds no campaign; valid: a folder of one"),
        (
            ("fly", "--out", tmp_path, "--trial", "-1"),
            "trial -1 is out of range; valid: 0 to 999999",
        ),
        (("fly", "--out", tmp_path, "--trial", "0", "--scene", "x"), "scene 'x' is unknown"),
    ):
        status, out, err = in_process(capsys, *args)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert says in err


def test_a_full_disk_costs_a_flight_its_recording_and_not_its_verdict(
    tmp_path, capsys, monkeypatch
):
    def fail_at_the_end(recorder):
        recorder.fault = "no space left on device"

    monkeypatch.setattr("scenarios.recording.Recorder._write_out", fail_at_the_end)
    args = ("--scene", "7", "--trial", "0", "--pilot", f"{STUBS}:Idle", "--record", "summary")
    status, out, err = in_process(capsys, "fly", "--out", tmp_path / "out", *args, "--json")
    row = json.loads(out)
    assert (status, row["code"], row["recording"]) == (2, "never_flew", None), err
    assert row["state_hash"] is not None
