"""Ctrl-C in the midst of a command: status 130, nothing said, nothing left half-written."""

import itertools
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

import pytest

from aeroscene.corpus.field import field_scene
from aeroscene.scene import SceneError
from aeroscene.scene.io import scene_to_json
from scenarios.cli.command_line import execute

INTERRUPTED = 130


@dataclass(frozen=True)
class NoCfg:
    """No options."""


def interrupted_by_itself():
    signal.raise_signal(signal.SIGINT)


def swallow_interrupts(times):
    """Work as libraries do that catch all there is."""
    for number in itertools.count():
        try:
            if not number:
                interrupted_by_itself()
            time.sleep(20.0)
        except BaseException:  # noqa: BLE001 - as trimesh does
            if number == times:
                return
        else:
            return


def test_an_interrupt_that_libraries_swallow_comes_again():
    def run(_):
        swallow_interrupts(times=2)
        time.sleep(20.0)
        return 0

    assert execute(NoCfg, run, "name", []) == INTERRUPTED


def test_closing_what_is_open_is_not_interrupted_again():
    closed = []

    def run(_):
        try:
            interrupted_by_itself()
        finally:
            time.sleep(0.7)
            closed.append("file")
        return 0

    assert execute(NoCfg, run, "name", []) == INTERRUPTED
    assert closed == ["file"]
    assert signal.getsignal(signal.SIGINT) is not None


def test_an_interrupt_while_an_error_is_put_into_words_ends_the_command():
    class SlowError(SceneError):
        def __str__(self):
            interrupted_by_itself()
            return "wrong"

    def run(_):
        raise SlowError

    assert execute(NoCfg, run, "name", []) == INTERRUPTED


# Named tuples and dataclasses are made by exec, where the interpreter remembers an interrupt.
WITHIN_EXEC = """
import sys, types
from dataclasses import dataclass
from scenarios.cli import entry
from scenarios.cli.command_line import execute

@dataclass(frozen=True)
class NoCfg:
    "No options."

def main():
    return execute(NoCfg, lambda _: exec("import signal; signal.raise_signal(2)"), "name", [])

entry._import = lambda _: types.SimpleNamespace(main=main)
sys.exit(entry.aeroscene())
"""


def test_an_interrupt_within_exec_ends_with_the_same_status():
    done = subprocess.run([sys.executable, "-c", WITHIN_EXEC], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, b"", b"")


WITHIN_CALLBACK = """
import signal, sys, time, weakref
from dataclasses import dataclass
from scenarios.cli.command_line import execute

@dataclass(frozen=True)
class NoCfg:
    "No options."

class Thing:
    pass

def run(_):
    thing = Thing()
    kept = weakref.ref(thing, lambda _: signal.raise_signal(2))
    del thing
    time.sleep(20.0)
    return 0

sys.exit(execute(NoCfg, run, "name", []))
"""


def test_an_interrupt_within_a_callback_ends_the_command_without_a_word():
    """Python cannot raise it there; it would print it as a fault that is ignored."""
    done = subprocess.run([sys.executable, "-c", WITHIN_CALLBACK], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, b"", b"")


def crowded_field(n_objects):
    """The open field, with small boxes beside each other far from the start."""
    document = json.loads(scene_to_json(field_scene()))
    for number in range(len(document["objects"]), n_objects):
        row, column = divmod(number, 90)
        size, place = [0.2, 0.2, 0.2], [-29.0 + 0.3 * column, -29.0 + 0.3 * row, 0.2]
        box = {"p": place, "q": [1, 0, 0, 0], "s": size}
        placed = {**document["objects"][0], "id": number, "parent_id": 0, "category_id": 54}
        placed |= {"bbox": box}
        del placed["bbox_corners"]  # It follows from the box.
        document["objects"].append(placed)
    return json.dumps(document)


@pytest.mark.parametrize("to", ["mjcf", "glb"])
def test_ctrl_c_while_a_file_close_to_its_bounds_is_read_leaves_nothing(tmp_path, to):
    (tmp_path / "s.json").write_text(crowded_field(4_900))
    out = tmp_path / "out"
    words = ["export", "--scene", str(tmp_path / "s.json"), "--to", to, "--out", str(out)]
    for after_s in (1.2, 2.5):
        process = subprocess.Popen(
            [sys.executable, "-m", "aeroscene", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        time.sleep(after_s)
        os.kill(process.pid, signal.SIGINT)
        assert (*process.communicate(), process.returncode) == ("", "", INTERRUPTED)
        assert not [path for path in out.rglob("*") if path.is_file()]
