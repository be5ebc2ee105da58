"""`aeroscene new` writes files that run as they are, by the command in their own heads."""

import shlex
import subprocess
import sys

import pytest

from scenarios.cli.main import main
from scenarios.cli.new import command_of
from tests.instances import own_instance


def run_in_a_shell(command, folder):
    """Run a command line as a user does; our program and Python are those of the test."""
    program, *arguments = shlex.split(command)
    words = {"aeroscene": [sys.executable, "-m", "aeroscene"], "python": [sys.executable]}[program]
    if arguments[0] == "sitl":
        arguments += ["--instance", str(own_instance())]
    if arguments[0] == "campaign":
        arguments += ["--trials", "1"]  # The second one among people takes seven times as long.
    return subprocess.run(
        [*words, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    ("kind", "file", "said"),
    [
        ("pilot", "mine.py", "landed: landed on area 0"),
        ("vehicle", "mine.toml", "Done: landed on area 0"),
        ("scene", "mine.json", "Done: landed on area"),
        ("recipe", "mine.toml", "landed"),
    ],
)
def test_a_new_file_runs_by_the_command_in_its_head(kind, file, said, tmp_path, capsys):
    assert main(["new", kind, "mine", "--out", str(tmp_path)]) == 0
    text = (tmp_path / file).read_text()
    command = command_of(text)
    assert capsys.readouterr().out == f"{tmp_path / file}\nRun it with: {command}\n"
    assert f"my_{kind}" not in text
    done = run_in_a_shell(command, tmp_path)
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert "rror" not in done.stderr


@pytest.mark.parametrize(
    ("args", "line"),
    [
        (("pilot", "random"), "name 'random' is that of a module; valid: one that no module has"),
        (("pilot", "class"), "name 'class' is that of a module; valid: one that no module has"),
        (("pilot", "numpy"), "name 'numpy' is that of a module; valid: one that no module has"),
        (("scene", "../x"), "name '../x' is not valid; valid: a letter, then up to 63 letters, "),
        (("scene", ""), "name '' is not valid; valid: a letter, then up to 63 letters, "),
        (("scene", "n" * 65), f"name '{'n' * 65}' is not valid; valid: a letter, then up to 63 "),
        (("boat", "x"), "kind 'boat' is not valid; valid: pilot, vehicle, scene, recipe; see "),
        (("pilot",), "NAME is missing; see aeroscene new --help"),
        (("vehicle", "there"), "file 'there.toml' is there already; valid: another name"),
        (("recipe", "x", "--out", "no"), "file 'no/x.toml': no such file or directory; valid: "),
    ],
)
def test_a_name_that_cannot_be_is_refused_in_one_line(args, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.toml").write_text("mine")
    with pytest.raises(SystemExit) as stop:
        main(["new", *args])
    assert stop.value.code == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"aeroscene new: error: {line}")
    assert said.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]
    assert (tmp_path / "there.toml").read_text() == "mine"
