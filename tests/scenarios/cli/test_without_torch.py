"""The base install, without the extra `model`: in an interpreter that has no torch."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.instances import own_instance

ROOT = Path(__file__).parents[3]
WITHOUT_TORCH = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"torch", "safetensors"}:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
"""


@pytest.fixture
def run(tmp_path):
    """Runs a module of the command line, as its own program, where torch cannot be imported."""
    (tmp_path / "sitecustomize.py").write_text(WITHOUT_TORCH)
    path = os.pathsep.join((str(tmp_path), str(ROOT)))

    def run_module(module, *args):
        return subprocess.run(
            [sys.executable, "-m", module, *args],
            env=os.environ | {"PYTHONPATH": path},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )

    return run_module


def test_the_base_install_flies_a_shipped_scene(run):
    flight = f"--scene 42 --headless-seconds 2 --speed max --instance {own_instance()} --json"
    done = run("scenarios.cli.sitl", *flight.split())
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["sim_seconds"] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    ("module", "args"),
    [
        ("scenarios.cli.sitl", ("--scene", "gen:7")),
        ("scenarios.cli.main", ("generate", "--seed", "7")),
        ("scenarios.cli.main", ("train",)),
        ("scenarios.cli.main", ("evaluate",)),
        ("scenarios.cli.main", ("bench", "generate")),
        ("scenarios.cli.main", ("export", "--scene", "gen:7", "--to", "glb", "--out", "x")),
    ],
)
def test_what_needs_the_model_says_in_one_line_what_to_install(run, module, args):
    done = run(module, *args)
    assert done.returncode == 2
    (line,) = filter(None, done.stderr.splitlines())
    assert "the scene model needs torch" in line
    assert "pip install 'aeroscene[model]'" in line
