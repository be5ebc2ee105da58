"""Every example runs as a user runs it, and does what its first lines promise."""

import ast
import json
import shlex
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from scenarios.campaigns.flyer import Flyer, Suite, Trial
from scenarios.tasks.recipe import Recipe
from scenarios.trials.verdict import Code
from tests.clients.conftest import testbench  # noqa: F401 - a fixture
from tests.instances import free_port

EXAMPLES = Path(__file__).parents[2] / "examples"
MOST_LINES = 70


def load(name):
    """An example as a module; what stands below `__main__` does not run."""
    namespace = {"__name__": f"examples.{name}"}
    path = EXAMPLES / f"{name}.py"
    exec(compile(path.read_text(), path, "exec"), namespace)
    return namespace


def run(name, *arguments):
    """An example as a process of its own; its output."""
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{name}:\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_is_short_says_how_to_run_it_and_is_run_here(path):
    text = path.read_text()
    assert len(text.splitlines()) <= MOST_LINES
    assert f"python examples/{path.name}" in (ast.get_docstring(ast.parse(text)) or "")
    assert f'("{path.stem}"' in Path(__file__).read_text()


def test_our_pilot_lands_and_the_run_is_recorded():
    result = load("fly_demo")["main"]()
    assert result.success, result.reason
    assert Path(result.recording).stat().st_size > 0


def test_a_pilot_of_ones_own_lands_where_it_said():
    result = load("own_pilot")["main"]()
    assert result.success, result.reason
    assert result.touchdown_error_m < 0.5


def test_a_program_outside_is_scored_and_repeats_its_flight_to_the_bit():
    program = shlex.join([sys.executable, str(EXAMPLES / ("scored_mavlink" + ".py"))])
    suite = Suite(recipe=Recipe(wind_mps=(0.0, 0.0)), pilot="mavlink", program=program)
    with Flyer(suite, patience_s=100.0) as flyer:
        first, again = (flyer.fly(Trial("field", "iris", 0)) for _ in range(2))
    assert first["code"] == "landed", first["reason"]
    assert first["touchdown_error_m"] < 0.5
    assert first["state_hash"] == again["state_hash"]


def test_a_controller_of_ones_own_keeps_to_its_circle():
    controller = load("own_controller")["main"]()
    assert np.median(controller.errors_m[300:]) < 0.2


def test_images_come_with_depth_and_with_labels_that_agree_with_it():
    load("rgbd_dataset")["main"]("out")
    label = json.loads(Path("out/003.json").read_text())
    images = np.load("out/003.npz")
    ids, depth_m = images["object_id"], images["depth_m"]
    assert Path("out/003.png").is_file()
    assert {i for i in ids.ravel().tolist() if i >= 0} == set(map(int, label["objects"]))
    # The last of the ground before the horizon may be either.
    assert not (depth_m[ids == -3] < 500.0).any()
    assert len({entry["category"] for entry in label["objects"].values()}) > 3
    seen = label["objects"][str(np.bincount(ids[ids >= 0]).argmax())]
    away_m = np.linalg.norm(np.subtract(seen["p"], label["position_enu_m"]))
    reach_m = np.linalg.norm(seen["s"]) / 2
    nearest_m = depth_m[ids >= 0].min()
    assert nearest_m < away_m + reach_m


def test_a_generated_scene_is_kept_and_flown():
    result = load("generate_and_fly")["main"](7)
    assert result.scene == "aeroscene-0007"
    assert Path("aeroscene-0007.json").is_file()
    assert result.success, result.reason


def test_a_scene_from_twenty_lines_is_sound_and_flown():
    example = load("own_scene")
    assert not example["aeroscene"].validate(example["container_yard"]())
    result = example["main"]()
    assert result.success, result.reason
    assert result.scene == "container-yard"


def test_a_policy_learns_for_a_moment_and_is_tried():
    share, distance_m = load("learn_hover")["main"](256, 2)
    assert 0.0 <= share <= 1.0
    assert 0.0 < distance_m < 6.0


def test_a_policy_learns_to_land_for_a_moment_and_is_judged(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)  # it takes `Worlds` of its neighbour
    codes = load("learn_landing")["main"](128, 2, n_trials=3)
    assert codes.total() == 3
    assert set(codes) <= set(Code)


def test_a_vehicle_of_ones_own_lands():
    result = load("own_vehicle")["main"]()
    assert result.success, result.reason
    assert result.vehicle == "heavy"


@pytest.mark.timeout(150)
def test_mavsdk_flies_offboard(testbench):  # noqa: F811
    port = str(free_port(socket.SOCK_STREAM))
    assert run("offboard_mavsdk", testbench.sdk_address, port).endswith("landed\n")


@pytest.mark.timeout(150)
def test_pymavlink_flies_offboard(testbench):  # noqa: F811
    address = f"tcp:127.0.0.1:{testbench.tcp_port}"
    assert run("offboard_pymavlink", address).endswith("landed\n")
