import json
import re
import sys

import pytest
import rerun as rr

from scenarios.cli import replay
from tests.scenarios.in_process import in_process


@pytest.mark.parametrize("content", [None, b"", b"no recording at all"])
def test_nothing_to_replay_ends_with_status_2_and_one_line(tmp_path, capfd, content):
    path = tmp_path / "x.rrd"
    if content is not None:
        path.write_bytes(content)
    status, out, err = in_process(capfd, "replay", path)
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert line.startswith("aeroscene replay: error: recording ")
    assert str(path) in line
    assert "valid: an .rrd file" in line


def test_json_is_one_object_and_nothing_else(tmp_path, capfd):
    path = tmp_path / "foreign.rrd"
    recording = rr.RecordingStream("somebody_elses")
    recording.set_sinks(rr.FileSink(path))
    recording.log("a/text", rr.TextLog("hello"))
    recording.flush()
    recording.disconnect()
    status, out, err = in_process(capfd, "replay", path, "--json")
    assert status == 0, err
    summary = json.loads(out)
    assert summary["scene"] is None
    assert summary["verdict"] is None
    assert summary["is_complete"] is True


def _summary(**result):
    known = {"scene": "42", "vehicle": "iris", "seed": 3, "sim_seconds": 15.2}
    return json.dumps({"result": {**known, "success": True, "code": "landed", **result}})


def test_a_folder_is_listed_with_the_verdicts_of_what_is_in_it(tmp_path, capfd):
    inner = tmp_path / "recordings"
    inner.mkdir()
    for name in ("a", "b", "c d"):
        (inner / f"{name}.rrd").write_bytes(b"x" * 100_000)
    (inner / "a.json").write_text(_summary(reason="landed on area 2"))
    (inner / "b.json").write_text("{" * 100_000)
    (inner / "c d.json").write_text(_summary(reason="\x1b[2Jhi\nthere"))
    status, out, err = in_process(capfd, "replay", tmp_path)
    assert (status, err) == (0, "")
    assert out.splitlines() == [
        f"{inner}/a.rrd  0.1 MB  landed: landed on area 2; scene 42, iris, seed 3, 15.2 s",
        f"{inner}/b.rrd  0.1 MB",
        f"{inner}/c d.rrd  0.1 MB  landed: ?[2Jhi?there; scene 42, iris, seed 3, 15.2 s",
        f"Open one with: aeroscene replay '{inner}/c d.rrd'",
    ]
    first, *others = json.loads(in_process(capfd, "replay", tmp_path, "--json")[1])["recordings"]
    assert first["recording"] == f"{inner}/a.rrd"
    assert (first["code"], first["success"], first["sim_seconds"]) == ("landed", True, 15.2)
    assert others[0]["code"] is None


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((), "folder .* holds no recordings; valid: "),
        (("--pictures", "p"), " is a folder; valid: "),
    ],
)
def test_a_folder_that_cannot_be_listed_or_drawn_gets_one_line(tmp_path, capfd, options, says):
    status, out, err = in_process(capfd, "replay", tmp_path, *options)
    assert (status, out) == (2, "")
    (line,) = err.splitlines()
    assert re.search(says, line)


def test_native_viewer_without_display_ends_with_status_2(tmp_path, monkeypatch, capsys):
    if not sys.platform.startswith("linux"):
        pytest.skip("windows need no DISPLAY on this system")
    path = tmp_path / "x.rrd"
    recording = rr.RecordingStream("x")
    recording.set_sinks(rr.FileSink(path))
    recording.disconnect()
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(SystemExit) as end:
        replay.run(replay.ReplayCfg(recording=path, viewer="native"))
    assert end.value.code == 2
    assert "needs a display" in capsys.readouterr().err


def test_a_film_of_an_unknown_format_ends_with_status_2_and_one_line(tmp_path, capfd):
    args = ("replay", tmp_path / "x.rrd", "--video", tmp_path / "x.avi")
    status, out, err = in_process(capfd, *args)
    assert (status, out) == (2, "")
    (line,) = err.strip().splitlines()
    assert line.startswith("aeroscene replay: error: video ")
    assert line.endswith("valid: NAME.mp4, NAME.webm, NAME.webp, NAME.gif")
