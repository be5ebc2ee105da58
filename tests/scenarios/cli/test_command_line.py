"""The shell: bad input gets one line and exit status 2, help names units and defaults."""

import pytest

from scenarios.cli.main import main as commands
from scenarios.cli.sitl import main


def fails_with(capsys, *args):
    with pytest.raises(SystemExit) as stop:
        main(list(args))
    assert stop.value.code == 2
    output = capsys.readouterr()
    assert output.out == ""
    return output.err


@pytest.mark.parametrize(
    ("args", "line"),
    [
        (
            ["--vehicle", "spitfire"],
            "vehicle 'spitfire' is unknown; valid: iris, iris-rotors, hummingbird, crazyflie, ",
        ),
        (
            ["--scene", "1016"],
            "scene '1016' is unknown; valid: a number from 0 to 1015, corpus:N, gen:SEED, ",
        ),
        (
            ["--scene", "absent.json"],
            "scene file 'absent.json' cannot be read (no such file or directory); valid: ",
        ),
        (["--speed", "0"], "speed 0.0 is out of range; valid: above 0, or max"),
        (["--speed", "nan"], "speed nan is out of range; valid: above 0, or max"),
        (["--seed", "-1"], "seed -1 is out of range; valid: 0 to 9223372036854775807"),
        (["--instance", "100"], "instance 100 is out of range; valid: 0 to 99"),
        (
            ["--instance", "one"],
            "instance 'one' is not valid; valid: a whole number; see aeroscene-sitl --help",
        ),
        (["--camera-hz", "51"], "camera-hz 51.0 is out of range; valid: 0 to 50 Hz"),
        (
            ["--headless-seconds", "0"],
            "headless-seconds 0.0 is out of range; valid: above 0 s",
        ),
        (["--headless-seconds", "inf"], "headless-seconds inf is out of range; valid: above 0 s"),
        (["--record", "flight.mp4"], "record 'flight.mp4' is no .rrd file; valid: NAME.rrd"),
        (["--altitude", "3"], "--altitude is unknown; see aeroscene-sitl --help"),
        (["--speed", "fast"], "speed 'fast' is not valid; valid: a number, max"),
        (["--viewer", "vr"], "viewer 'vr' is not valid; valid: off, web, native"),
        (["--headless-seconds", "x"], "headless-seconds 'x' is not valid; valid: a number;"),
        (["--sceen", "4"], "--sceen is unknown; perhaps --scene; see aeroscene-sitl --help"),
        (["41", "--scene", "42"], "scene '42' is a second one beside '41'; valid: one"),
        (
            ["42", "--bounds", "1,1,1.001,1.001"],
            "bounds '1,1,1.001,1.001' are those of no map, scene is '42'; valid: with a map",
        ),
        (
            ["absent.osm", "--bounds", "1,1,0,2"],
            "bounds are '1,1,0,2'; valid: W,S,E,N in degrees, west below east",
        ),
        (
            ["absent.osm", "--bounds", "1,1,1.01,1.01"],
            "bounds are 1113 x 1106 m; valid: 20 to 400 m a side, such as ",
        ),
        (
            ["absent.osm", "--bounds=1,1,1.001,1.001"],
            "map file 'absent.osm' cannot be read (no such file or directory); valid: a map",
        ),
        (["1016"], "scene '1016' is unknown; valid: a number from 0 to 1015"),
        (["--record", "a/b/c.rrd"], "record: 'a' is not there; valid: a folder that exists"),
        (["--pictures", "pyproject.toml"], "pictures: 'pyproject.toml' is a file; valid: a folder"),
        (["--captures", "a/b"], "captures: 'a' is not there; valid: a folder that exists"),
        (["--format", "jpg"], "format 'jpg' is not valid; valid: png, svg, pdf"),
        (["--format"], "format has no value; valid: png, svg, pdf"),
        (["--vehicle"], "--vehicle has no value"),
        (
            ["--serial", "/dev/ttyS0:1234"],
            "serial '/dev/ttyS0:1234': 1234 baud is unknown; valid: ",
        ),
        (["--signing-key", "absent"], "signing-key 'absent' cannot be read: No such file"),
    ],
)
def test_bad_input_gets_one_line_that_names_it(capsys, args, line):
    error = fails_with(capsys, *args)
    assert error.startswith(f"aeroscene-sitl: error: {line}")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "line"),
    [
        (
            ["fligh"],
            "aeroscene: error: fligh is unknown; valid: sitl, fly, campaign, report, compare, ",
        ),
        (["replay"], "aeroscene replay: error: PATH is missing; see aeroscene replay --help"),
        (["replay", "x.rrd", "--format"], "aeroscene replay: error: format has no value; valid: "),
        (
            ["export", "--out", "x"],
            "aeroscene export: error: --to is missing; see aeroscene export",
        ),
        (["train", "--preset", "x"], "aeroscene train: error: preset 'x' is not valid; valid: "),
        (
            ["train", "--steps", "x"],
            "aeroscene train: error: steps 'x' is not valid; valid: a whole",
        ),
        (
            ["sitl", "--speed", "x"],
            "aeroscene sitl: error: speed 'x' is not valid; valid: a number",
        ),
        (["dataset", "x"], "aeroscene dataset: error: x is unknown; valid: build, stats, "),
        (
            ["dataset", "stats", "--jbs", "1"],
            "aeroscene dataset stats: error: --jbs is unknown; perhaps --jobs; see ",
        ),
    ],
)
def test_every_command_says_in_one_line_what_is_valid(capsys, args, line):
    with pytest.raises(SystemExit) as stop:
        commands(args)
    assert stop.value.code == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith(line)
    assert output.err.count("\n") == 1


@pytest.mark.parametrize("args", [[], ["dataset"], ["bench"]])
def test_without_a_command_the_help_is_printed(capsys, args):
    with pytest.raises(SystemExit) as stop:
        commands(args)
    assert stop.value.code == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert output.out.startswith(f"usage: {' '.join(['aeroscene', *args])} [-h] ")


def test_a_malformed_scene_file_is_named_with_its_fault(capsys, tmp_path):
    path = tmp_path / "cut.json"
    path.write_text('{"version": 1, "scene_id": "x"')
    error = fails_with(capsys, "--scene", str(path))
    assert str(path) in error
    assert error.count("\n") == 1


def test_help_names_every_option_with_its_default(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    for option in (
        "--scene",
        "--vehicle",
        "--speed",
        "--viewer",
        "--record",
        "--instance",
        "--demo",
    ):
        assert option in text
    assert "(default: 42)" in text


def test_help_lines_break_where_the_terminal_ends_not_where_the_source_does(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "250")
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capsys.readouterr().out
    assert "one of a file of layouts (FILE.jsonl#ID or #N), or a place" in text
    assert "(visual-inertial odometry), mocap (motion capture), or auto" in text  # of a nested one
