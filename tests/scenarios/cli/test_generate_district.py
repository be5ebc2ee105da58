"""`aeroscene generate` for a district: made without the model, or refused at once."""

import json
import os
import subprocess
import sys

import pytest

from aeroscene.scene.io import read_scene
from tests.scenarios.in_process import in_process


def run(capsys, *args):
    return in_process(capsys, "generate", *args)


@pytest.mark.parametrize(
    ("args", "name", "low", "high"),
    [
        (("--houses", 20), "houses", 18, 22),
        (("--storeys", 2), "storeys", 2, 2),
        (("--objects", 300), "objects", 300, 310),
    ],
)
def test_it_makes_what_is_asked_for_and_says_what_it_got(tmp_path, capsys, args, name, low, high):
    out = tmp_path / "out"
    status, text, errors = run(capsys, *args, "--seed", 7, "--out", out, "--json")
    assert (status, errors) == (0, "")
    facts = json.loads(text)
    (file,) = facts["scenes"]
    told = facts["wishes"][file][name]
    assert told["asked"] == args[1]
    assert low <= told["got"] <= high
    assert told["met"]
    scene = read_scene(file)
    assert scene.wishes == {name: args[1]}
    assert scene.measured == {name: told["got"]}


def test_a_wide_outline_is_the_flight_volume(tmp_path, capsys):
    assert run(capsys, "--outline", "155,70", "--out", tmp_path)[0] == 0
    scene = read_scene(tmp_path / "aeroscene-0042.json")
    assert scene.extent_max_enu_m[:2] == (77.5, 35.0)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--outline", "401,300"), "outline 401.0 is out of range; valid: 15 to 400 m"),
        (("--outline", "400,40"), "outline side 40 is out of range for a district; valid: 60 to"),
        (("--objects", 3000), "objects 3000 is out of range; valid: 20 to 2500"),
        (("--houses", 151), "houses 151 is out of range; valid: 1 to 150"),
        (("--storeys", 11), "storeys 11 is out of range; valid: 1 to 10"),
        (("--outline", "400,400", "--objects", 300), "valid: 534 to 2500 there"),
        (("--outline", "300,300", "--theme", "park"), "theme is 'park' beside a district"),
        (("--houses", 9, "--steps", 3), "steps is 3 beside a district"),
        (("--houses", 9, "--density", 1.5), "density is 1.5 beside a district"),
        (("--storeys", 2, "--areas", "small=3"), "areas is 'small=3' beside a district; valid: on"),
    ],
)
def test_what_cannot_be_done_is_refused(tmp_path, capsys, args, message):
    out = tmp_path / "out"
    status, text, errors = run(capsys, *args, "--out", out)
    assert (status, text) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(("asked", "status"), [("--houses=900", 2), ("--houses=8", 0)])
def test_neither_a_refusal_nor_a_district_loads_torch(tmp_path, asked, status):
    program = (
        "import sys\n"
        "from scenarios.cli.main import main\n"
        "try: status = main(sys.argv[1:])\n"
        "except SystemExit as done: status = done.code\n"
        "sys.exit(9 if 'torch' in sys.modules else status)"
    )
    args = ["generate", asked, "--out", str(tmp_path / "out")]
    done = subprocess.run(
        [sys.executable, "-c", program, *args], capture_output=True, check=False, env=os.environ
    )
    assert done.returncode == status, done.stderr
