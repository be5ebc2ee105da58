"""Folders of campaigns that somebody else made: what they name is not run by itself."""

import json
import sys
from dataclasses import asdict

import pytest

from scenarios.campaigns.recordings import MANIFEST
from scenarios.campaigns.store import JOURNAL, TABLES
from scenarios.tasks.recipe import Recipe
from tests.scenarios.in_process import in_process

TRIAL = ("--trial", "0", "--scene", "7")


@pytest.fixture
def shared(tmp_path, monkeypatch):
    """A folder that names what the test says, and lies where the command is started."""
    folder, mark = tmp_path / "shared", tmp_path / "owned"
    (folder / TABLES).mkdir(parents=True)
    (folder / JOURNAL).write_text("")
    touch = f"import pathlib; pathlib.Path({str(mark)!r}).touch()\n"
    (folder / "evil.py").write_text(f"{touch}class Pilot: ...\n")
    run = folder / "run"
    run.write_text(f"#!/bin/sh\ntouch {mark}\nexit 1\n")
    run.chmod(0o755)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", [*sys.path])
    sys.modules.pop("evil", None)

    def name(**suite):
        plain = {"recipe": asdict(Recipe()), "pilot": "demo", **suite}
        text = json.dumps({"version": "0.1.0", "suite": plain})
        (folder / MANIFEST).write_text(text)
        return folder, mark

    return name


CODE = (
    ({"pilot": "evil:Pilot"}, "pilot 'evil:Pilot'", "--pilot evil:Pilot"),
    (
        {"pilot": "mavlink", "program": "./run now"},
        "program './run now'",
        "--program './run now'",
    ),
    (
        {"autopilot": "px4", "autopilot_binary": "./run"},
        "autopilot-binary './run'",
        "--autopilot-binary ./run",
    ),
    (
        {"pilot": "vlm", "endpoint": "http://127.0.0.1:9", "recipe": {"goals": ["naming"]}},
        "endpoint 'http://127.0.0.1:9'",
        "--endpoint http://127.0.0.1:9",
    ),
)


@pytest.mark.parametrize(("suite", "named", "again"), CODE)
def test_fly_runs_nothing_that_only_the_folder_names(shared, capsys, suite, named, again):
    folder, mark = shared(**suite)
    status, out, err = in_process(capsys, "fly", "--out", folder, *TRIAL)
    assert (status, out) == (2, "")
    assert err == (
        f"aeroscene fly: error: {str(folder / MANIFEST)!r} names the {named}, which is not run "
        f"just because it stands there; valid: {again}, or --trust for all that the folder names\n"
    )
    assert not mark.exists()
    assert "evil" not in sys.modules


@pytest.mark.parametrize(("suite", "_named", "_again"), CODE)
@pytest.mark.parametrize("command", ["report", "compare", "campaign"])
def test_other_commands_run_nothing_of_the_folder(shared, capsys, suite, _named, _again, command):
    folder, mark = shared(**suite)
    args = {
        "report": (folder,),
        "compare": (folder, folder),
        "campaign": ("--out", folder, "--scenes", "7", "--trials", "1"),
    }[command]
    status, _, err = in_process(capsys, command, *args)
    assert status in {0, 2}, err
    assert not mark.exists()
    assert "evil" not in sys.modules


def test_what_is_named_again_is_run(shared, capsys):
    folder, mark = shared(pilot="evil:Pilot")
    for args in (("--pilot", "evil:Pilot"), ("--trust",)):
        mark.unlink(missing_ok=True)
        sys.modules.pop("evil", None)
        in_process(capsys, "fly", "--out", folder, "--trial", "0", "--scene", "none.json", *args)
        assert mark.exists(), args


def test_the_pilots_that_ship_need_no_trust_and_import_nothing_from_here(shared, capsys):
    folder, mark = shared(pilot="straight")
    status, _, err = in_process(capsys, "fly", "--out", folder, "--trial", "0", "--scene", "x.json")
    assert status == 2
    assert "x.json" in err
    assert str(folder) not in sys.path
    assert not mark.exists()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[" * 100_000, "is no campaign's"),
        ('{"version": "1", "suite": []}', "Expected `object`, got `array`"),
        ('{"version": "1", "suite": {"recipe": {}, "pilot": ["demo"]}}', "Expected `str`"),
        ('{"version": "1", "suite": {"recipe": {"draws": 1e9}, "pilot": "demo"}}', "draws"),
        (f'{{"a": "{"x" * 300_000}"}}', "holds more than 256 KiB"),
    ],
)
def test_a_manifest_that_is_none_is_one_line(shared, capsys, text, says):
    folder, _ = shared()
    (folder / MANIFEST).write_text(text)
    status, out, err = in_process(capsys, "fly", "--out", folder, *TRIAL)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert says in err
