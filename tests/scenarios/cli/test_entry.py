"""The console scripts: one command, its version, and Ctrl-C at any moment."""

import os
import signal
import subprocess
import sys
import time
from importlib.metadata import version

import psutil
import pytest

from tests.instances import own_instance
from tests.thorough import THOROUGH

SITL = "import sys; from scenarios.cli.entry import aeroscene_sitl; sys.exit(aeroscene_sitl())"
AEROSCENE = "import sys; from scenarios.cli.entry import aeroscene; sys.exit(aeroscene())"


def start(*command):
    return subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.parametrize("command", [["-m", "aeroscene"], ["-c", AEROSCENE], ["-c", SITL]])
def test_every_way_in_says_the_version_in_one_line(command):
    output, errors = start(*command, "--version").communicate()
    assert (output, errors) == (f"aeroscene {version('aeroscene')}\n", "")


def test_the_testbench_is_a_command_among_the_others():
    flight = f"sitl 7 --headless-seconds 0.1 --speed max --instance {own_instance()}"
    output, errors = start("-m", "aeroscene", *flight.split()).communicate()
    assert "Scene aeroscene-0007" in errors
    assert "simulated" in output


def test_a_terminal_that_lacks_our_letters_prints_others():
    env = os.environ | {"PYTHONIOENCODING": "latin-1"}
    stats = ["-m", "aeroscene", "dataset", "stats", "--scenes", "0:3", "--jobs", "1"]
    for command in (["-m", "aeroscene", "--help"], stats):
        done = subprocess.run([sys.executable, *command], env=env, capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (0, b"")
        assert done.stdout.decode("latin-1")


@pytest.mark.parametrize(
    ("command", "given", "threads"),
    [("fly", None, "1"), ("fly", "3", "3"), ("export", None, "None")],
)
def test_commands_that_fly_let_openblas_use_one_thread(command, given, threads):
    """Its threads wait for each other longer than a flight's small matrices take."""
    env = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    env |= {} if given is None else {"OPENBLAS_NUM_THREADS": given}
    ask = f"""
import os, sys
from scenarios.cli.entry import aeroscene
sys.argv = ["aeroscene", "{command}", "--help"]
try:
    aeroscene()
finally:
    print(os.environ.get("OPENBLAS_NUM_THREADS"))
"""
    output = subprocess.run(
        [sys.executable, "-c", ask], env=env, capture_output=True, text=True, check=True
    ).stdout
    assert output.splitlines()[-1] == threads


def test_output_that_is_not_read_to_its_end_leaves_no_traceback():
    process = start("-m", "aeroscene", "--help")
    with process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == ""


@pytest.mark.parametrize(
    "after_s",
    [0.2, pytest.param(0.5, marks=THOROUGH), 0.9, pytest.param(1.4, marks=THOROUGH), 2.0],
)
def test_ctrl_c_while_starting_ends_without_a_word_and_leaves_nothing(tmp_path, after_s):
    record = str(tmp_path / "x.rrd")
    args = ["--demo", "--viewer", "web", "--record", record, "--instance", str(own_instance())]
    process = start("-c", SITL, *args)
    time.sleep(after_s)
    children = psutil.Process(process.pid).children(recursive=True)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate()
    is_flying = "Ctrl-C ends" in errors
    assert process.returncode == (1 if is_flying else 130)
    assert is_flying or len(errors.splitlines()) <= 1, errors
    assert "Traceback" not in errors
    assert "ignored" not in errors
    assert not psutil.wait_procs(children, timeout=60)[1]
