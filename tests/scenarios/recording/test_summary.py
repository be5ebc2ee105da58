import subprocess
import sys
from pathlib import Path

import pytest
import rerun as rr

from scenarios.recording.metadata import RunInfo, log_verdict
from scenarios.recording.summary import (
    UnreadableRecordingError,
    chunks,
    first_row,
    readable,
    summarise,
)
from tests.scenarios.recording.conftest import LIMITS, VERDICT

SCRIPT = Path(__file__).with_name("record_until_killed.py")
PROMISED = {
    "/world/vehicle",
    "/world/estimate",
    "/world/trajectory/planned",
    "/world/trajectory/executed",
    "/world/vehicle/camera_forward/rgb",
    "/world/vehicle/camera_forward/depth",
    "/world/vehicle/camera_down/rgb",
    "/world/vehicle/camera_down/depth",
    "/sensors/imu/acceleration",
    "/sensors/imu/angular_rate",
    "/motors/command",
    "/motors/speed",
    "/error/position",
    "/error/attitude",
    "/battery/voltage",
    "/battery/remaining",
    "/autopilot/mode",
    "/autopilot/armed",
    "/autopilot/statustext",
}


def test_summary_says_which_run_what_is_in_it_and_how_it_ended(flight):
    summary = summarise(flight.path)
    assert (summary.scene, summary.vehicle, summary.seed) == ("42", "iris", 5)
    assert summary.config == {"scene": "42", "speed": "max", "camera_hz": 2.0}
    assert summary.verdict == VERDICT
    assert summary.limits == LIMITS
    assert summary.is_complete
    assert summary.sim_seconds == 3.5
    assert set(summary.entities) >= PROMISED
    assert summary.entities["/world/vehicle"] == 875
    assert summary.entities["/world/vehicle/camera_down/rgb"] == 7
    assert summary.size_bytes == flight.path.stat().st_size
    assert summary.static_entities > 50


def test_a_flight_that_nothing_was_judged_of_reads_the_same_after_one_that_was_judged(tmp_path):
    info = RunInfo(scene="42", vehicle="iris", seed=0)
    found = []
    for number, success in enumerate((True, None)):
        path = tmp_path / f"{number}.rrd"
        with rr.RecordingStream(f"test-{number}") as stream:
            stream.save(path)
            log_verdict(stream, info, {"success": success})
            # rerun writes an empty list where it knows the type of None.
            stream.send_property("run", rr.AnyValues(scene="42", vehicle="iris", success=success))
        assert (summarise(path).scene, summarise(path).verdict) == ("42", {"success": success})
        (row,) = [first_row(c) for c in chunks(path) if c.entity_path == "/__properties/verdict"]
        found.append(row.get("success"))
    assert found == [True, None]


def test_killed_run_leaves_all_but_its_last_second(tmp_path):
    path = tmp_path / "killed.rrd"
    with subprocess.Popen(
        [sys.executable, str(SCRIPT), str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        said_s = 0
        while said_s < 3:
            said_s = int(process.stdout.readline())
        process.kill()
        rest = process.stdout.read().split()
    handed_over_s = int(rest[-1]) if rest else said_s
    summary = summarise(path)
    assert summary.sim_seconds >= handed_over_s - 1
    assert not summary.is_complete
    assert summary.verdict is None
    assert summary.scene == "42"


@pytest.mark.parametrize("share", [0.65, 0.8, 0.97])
def test_torn_file_is_read_up_to_the_tear(flight, tmp_path, share):
    torn = tmp_path / "torn.rrd"
    whole = flight.path.read_bytes()
    torn.write_bytes(whole[: int(share * len(whole))])
    summary = summarise(torn)
    assert not summary.is_complete
    assert summary.scene == "42"
    assert summary.size_bytes == int(share * len(whole))
    assert torn.read_bytes() == whole[: int(share * len(whole))], "the original was changed"


def test_whole_file_is_read_where_it_is(flight):
    with readable(flight.path) as source:
        assert source == flight.path


@pytest.mark.parametrize("content", [b"", b"not a recording", bytes(range(256)) * 64])
def test_other_files_are_refused_in_one_line(tmp_path, content):
    path = tmp_path / "other.rrd"
    path.write_bytes(content)
    with pytest.raises(UnreadableRecordingError, match="no rerun recording") as error:
        summarise(path)
    assert "\n" not in str(error.value)


def test_missing_file_and_folder_are_refused(tmp_path):
    for path in (tmp_path / "missing.rrd", tmp_path):
        with pytest.raises(UnreadableRecordingError, match=r"valid: an \.rrd file"):
            summarise(path)
