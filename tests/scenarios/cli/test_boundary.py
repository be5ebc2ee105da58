"""The one boundary: errors of files and of the machine end a command in one line, status 2."""

import errno
import json
import os
import tomllib

import msgspec
import mujoco
import pyarrow as pa
import pytest

from scenarios import INPUT_ERRORS
from scenarios.cli.boundary import INPUT_ERROR_NAMES, one_line
from scenarios.recording import RecordingError
from tests.full_disk import files_end_after
from tests.scenarios.in_process import in_process

BED = {"category": "Bed", "p": [0, 0, 0.4], "q": [1, 0, 0, 0], "s": [1.5, 2.0, 0.8]}
FLOOR = [[-5, -4], [5, -4], [5, 4], [-5, 4]]
ROOM = {"scene_id": "a/room", "domain": "indoor", "floor": FLOOR, "objects": [BED]}


def test_the_errors_of_a_run_are_known_by_their_names():
    names = {f"{kind.__module__}.{kind.__qualname__}" for kind in INPUT_ERRORS}
    assert names == INPUT_ERROR_NAMES


@pytest.mark.parametrize("kind", [*INPUT_ERRORS, RecordingError])
def test_an_error_that_names_the_fault_is_said_as_it_is(kind):
    assert one_line(kind("wind 99; valid: 0 to 20")) == "wind 99; valid: 0 to 20"


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (
            OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)),
            "no space left on device; valid: a disk",
        ),
        (OSError(errno.EFBIG, "File too large", "a"), "file 'a': file too large; valid: a disk"),
        (PermissionError(errno.EACCES, "Permission denied", "a"), "permission denied; valid: a pa"),
        (RecursionError(), "nested too deeply; valid: "),
        (MemoryError(), "not enough memory; valid: "),
        (tomllib.TOMLDecodeError("line 1"), "damaged: line 1; valid: "),
        (msgspec.DecodeError("cut"), "damaged: cut; valid: "),
        (mujoco.FatalError("too many"), "too many; valid: "),
        (pa.ArrowInvalid("no magic"), "no magic; valid: "),
    ],
)
def test_what_a_user_can_mend_is_one_line_that_says_how(error, said):
    assert said in (one_line(error) or "")


def test_a_fault_of_ours_keeps_its_traceback(monkeypatch):
    assert one_line(KeyError("x")) is None
    monkeypatch.setenv("AEROSCENE_TRACEBACK", "1")
    assert one_line(RecursionError()) is None


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (0, ["new", "recipe", "x", "--out", "{out}"]),
        (100, ["new", "scene", "x", "--out", "{out}"]),
        (0, ["dataset", "build", "--out", "{out}", "--scenes", "0:2", "--jobs", "1"]),
        (5000, ["dataset", "build", "--out", "{out}", "--scenes", "0:2", "--jobs", "1"]),
        (500, ["campaign", "--out", "{out}", "--scenes", "7", "--trials", "1", "--workers", "1"]),
        (1000, ["layouts", "{out}/l.jsonl", "--out", "{out}/scenes"]),
        (1000, ["export", "--scene", "field", "--to", "mjcf", "--out", "{out}"]),
        (1000, ["export", "--scene", "field", "--to", "glb", "--out", "{out}"]),
    ],
)
def test_a_full_disk_is_one_line_and_leaves_nothing_half_written(tmp_path, capsys, limit, words):
    if words[0] == "layouts":
        (tmp_path / "l.jsonl").write_text(json.dumps(ROOM) + "\n")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with files_end_after(limit):
        status, out, err = in_process(capsys, *(word.format(out=tmp_path) for word in words))
    assert (status, out) == (2, ""), err
    (line,) = err.splitlines()
    assert "file too large" in line
    assert "valid: a" in line
    # Journals begin empty; whole files may lie beside the one that found no room.
    left = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert {path for path, data in left.items() if data and path not in before} <= {
        tmp_path / "manifest.json"
    }
    if (tmp_path / "manifest.json").is_file():
        assert json.loads((tmp_path / "manifest.json").read_bytes())["scenes"] == []
