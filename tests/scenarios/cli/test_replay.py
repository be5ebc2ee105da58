import json
import subprocess
import sys

import pytest
import rerun as rr

from scenarios.cli import replay


def _main(*args):
    """Run the command as a process of its own."""
    code = (
        "import sys\n"
        "from scenarios.cli import replay\n"
        "from scenarios.cli.command_line import parse\n"
        "sys.exit(replay.run(parse(replay.ReplayCfg, 'aeroscene replay', sys.argv[1:])))"
    )
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, args)], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("content", [None, b"", b"no recording at all"])
def test_nothing_to_replay_ends_with_status_2_and_one_line(tmp_path, content):
    path = tmp_path / "x.rrd"
    if content is not None:
        path.write_bytes(content)
    result = _main(path)
    assert result.returncode == 2
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("aeroscene replay: error: recording ")
    assert str(path) in line
    assert "valid: an .rrd file" in line


def test_json_is_one_object_and_nothing_else(tmp_path):
    path = tmp_path / "foreign.rrd"
    recording = rr.RecordingStream("somebody_elses")
    recording.set_sinks(rr.FileSink(path))
    recording.log("a/text", rr.TextLog("hello"))
    recording.flush()
    recording.disconnect()
    result = _main(path, "--json")
    assert result.returncode == 0, result.stderr
    summary = json.loads(result.stdout)
    assert summary["scene"] is None
    assert summary["verdict"] is None
    assert summary["is_complete"] is True


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


def test_a_film_of_an_unknown_format_ends_with_status_2_and_one_line(tmp_path):
    result = _main(tmp_path / "x.rrd", "--video", tmp_path / "x.avi")
    assert result.returncode == 2
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("aeroscene replay: error: video ")
    assert line.endswith("valid: .mp4, .webm, .webp, .gif")
