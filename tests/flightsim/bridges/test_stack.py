"""An external stack that dies, hangs or never comes ends the run by a line, and nothing is lost."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from flightsim.bridges import stack as stack_module
from flightsim.testbench import Testbench, TestbenchCfg, TestbenchError
from scenarios.cli.sitl import main
from tests.flightsim.handmade import empty_scene
from tests.instances import own_instance

ROOT = Path(__file__).parents[3]


def program(folder, fate):
    """An executable stand-in."""
    path = folder / "stand-in"
    path.write_text(
        f"#!{sys.executable}\n"
        f"import sys\nsys.path.insert(0, {str(ROOT)!r})\n"
        f"from tests.flightsim.bridges import stand_in\nstand_in.main({fate!r})\n"
    )
    path.chmod(0o755)
    return path


def cfg(**more):
    values = {"autopilot": "ardupilot", "speed": "max", "instance": own_instance()} | more
    return TestbenchCfg(**values)


def sitl(*args):
    """Run the command line; returns the exit status."""
    return main(["field", "--autopilot", "ardupilot", "--instance", str(own_instance()), *args])


@pytest.mark.parametrize(
    ("fate", "line"),
    [
        ("exits", "ArduPilot's exit with status 3; its last line: last words"),
        ("is killed", "ArduPilot's end by SIGKILL; its last line: last words"),
        ("hangs", "ArduPilot's silence of 1 s at t = 0.20 s"),
    ],
)
def test_a_lost_stack_is_one_line_and_the_recording_is_whole(
    tmp_path, monkeypatch, capsys, fate, line
):
    monkeypatch.setattr(stack_module, "SILENCE_S", 1.0)
    record = tmp_path / "flight.rrd"
    with pytest.raises(SystemExit) as stop:
        sitl(
            *("--autopilot-binary", str(program(tmp_path, fate)), "--speed", "max", "--json"),
            *("--record", str(record), "--camera-hz", "0"),
        )
    assert stop.value.code == 2
    out, err = capsys.readouterr()
    assert err.count(f"aeroscene-sitl: error: the run was ended by {line}") == 1
    result = json.loads(out)
    assert result["sim_seconds"] == pytest.approx(0.2, abs=0.021)
    assert result["reason"] == f"ended by {line}"
    assert record.stat().st_size > 1000
    assert json.loads(record.with_suffix(".json").read_text())["result"] == result


def test_a_program_that_is_none_is_one_line(tmp_path, capsys):
    with pytest.raises(SystemExit, match="2"):
        sitl("--autopilot-binary", str(tmp_path / "none"))
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("/none' is no program; valid: ArduPilot's, for simulation")


def test_what_only_our_autopilot_has_is_refused():
    with pytest.raises(TestbenchError, match="lockstep True is our autopilot's"):
        cfg(lockstep=True)
    with pytest.raises(TestbenchError, match="needs an autopilot; valid: --autopilot ardupilot"):
        TestbenchCfg(autopilot_binary="arducopter")
    with pytest.raises(TestbenchError, match="captures and video"):
        Testbench(empty_scene(), cfg(), has_video=True)


def test_nothing_happens_before_the_stack_is_there(tmp_path):
    with Testbench(empty_scene(), cfg()) as bench:
        assert "--model JSON:127.0.0.1 --home" in bench.external.start_line
        assert f"--sysid {1 + own_instance()}" in bench.external.start_line
        bench.simulator.run(stop=iter((False, False, True)).__next__)
        assert bench.plant.time_us == 0


def test_the_stack_commands_the_rotors_and_its_run_is_the_plants(tmp_path):
    binary = program(tmp_path, "exits")
    with Testbench(empty_scene(), cfg(autopilot_binary=str(binary))) as bench:
        rows = []
        bench.observers.append(lambda: rows.append(bench.plant.history.copy()))
        bench.run(1.0, until=lambda: bench.fault)
        history = np.concatenate(rows)
    assert np.diff(history["time_us"]).tolist() == [2000] * (len(history) - 1)
    full_radps = bench.airframe.quadrotor.rotors[0].max_speed_radps
    assert history["rotor_command_radps"][50].tolist() == pytest.approx([0.1 * full_radps] * 4)
    assert history["rotor_command_radps"][-1].tolist() == [0.0] * 4  # No power once it is lost.
    assert not history["position_est_enu_m"].any()  # Our estimator has never started.
    assert bench.plant.battery.consumed_mah > 0.0


@pytest.mark.parametrize("autopilot", ["ardupilot", "px4"])
def test_a_hexacopter_is_not_for_external_stacks(autopilot):
    with pytest.raises(TestbenchError, match="vehicle 'typhoon' has 6 rotors"):
        Testbench(empty_scene(), cfg(vehicle="typhoon", autopilot=autopilot))
