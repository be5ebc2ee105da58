"""What becomes of a flight when the real PX4 is killed, halted or begins anew, and what it sees.

They fly where AEROSCENE_PX4 names a binary.
"""

import json
import os
import shlex
import signal
import subprocess
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from flightsim.bridges import stack as stack_module
from flightsim.bridges.stack import ExternalStack
from flightsim.mavlink.client import CommandState
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.cli.sitl import main
from tests.flightsim.handmade import empty_scene
from tests.instances import own_instance
from tests.scenarios.landing_scenes import thing

PX4 = os.environ.get("AEROSCENE_PX4", "")
pytestmark = [
    pytest.mark.skipif(not PX4, reason="AEROSCENE_PX4 names no PX4 binary"),
    pytest.mark.timeout(600),
]
IN_AIR_US = 12_000_000
POSITION_MODE = 3
FULL_AHEAD, MIDDLE = 1000, 500


@pytest.fixture
def flown(capsys, tmp_path, monkeypatch):
    """Flies the demo, does a deed to PX4's process in the air; exit status, result and errors."""

    def fly(deed):
        original, fates = ExternalStack.update, [deed]

        def update(self):
            original(self)
            if fates and self._plant.time_us >= IN_AIR_US:
                fates.pop()(self._process._process.pid)

        monkeypatch.setattr(ExternalStack, "update", update)
        record = tmp_path / "flight.rrd"
        options = {"autopilot": "px4", "autopilot-binary": PX4, "instance": str(own_instance())}
        status = main(
            [
                "42",
                *(f"--{name}={value}" for name, value in options.items()),
                *("--demo", "--speed", "max", "--json", "--record", str(record)),
                *("--camera-hz", "0"),
            ]
        )
        out, err = capsys.readouterr()
        result = json.loads(out)
        assert json.loads(record.with_suffix(".json").read_text())["result"] == result
        assert record.stat().st_size > 100_000
        return status, result, err

    return fly


def test_killed_in_the_air_it_ends_the_run_by_one_line(flown):
    status, result, err = flown(lambda pid: os.kill(pid, signal.SIGKILL))
    assert status == 2
    assert err.count("the run was ended by PX4's end by SIGKILL") == 1
    assert "PX4's end by SIGKILL" in result["reason"]
    assert result["sim_seconds"] == pytest.approx(1e-6 * IN_AIR_US, abs=0.05)


def test_halted_in_the_air_it_ends_the_run_by_one_line(flown, monkeypatch):
    monkeypatch.setattr(stack_module, "SILENCE_S", 2.0)
    status, result, err = flown(lambda pid: os.kill(pid, signal.SIGSTOP))
    assert status == 2
    assert err.count("the run was ended by PX4's silence of 2 s at t = 12.0") == 1
    assert "PX4's silence" in result["reason"]


def test_halted_for_a_moment_it_flies_on_and_nothing_is_lost(flown):
    def halt(pid):
        os.kill(pid, signal.SIGSTOP)
        threading.Timer(2.0, os.kill, (pid, signal.SIGCONT)).start()

    status, result, _ = flown(halt)
    assert (status, result["code"]) == (0, "landed")
    count = result["lockstep"]
    assert count["left_out"] == 0
    assert count["told"] - count["answered"] - count["unanswered"] in {0, 1}


@pytest.fixture
def started(tmp_path):
    """Starts PX4 by the line that the run prints, as a user does."""
    running = []

    def start(bench):
        words = shlex.split(bench.external.start_line.replace("$PATH", os.environ["PATH"]))
        n_variables = next(k for k, word in enumerate(words) if "=" not in word)
        variables = dict(word.split("=", 1) for word in words[:n_variables])
        command = [PX4, str(Path(PX4).parent.parent / "etc"), *words[n_variables + 1 :]]
        with (tmp_path / "px4.txt").open("ab") as log:
            process = subprocess.Popen(
                [*command, "-w", str(tmp_path)],
                env={**os.environ, **variables},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )
        running.append(process)
        return process

    yield start
    for process in running:
        process.kill()
        process.wait()


class Pilot:
    """A client in the process, which says commands until they are accepted."""

    def __init__(self, bench):
        self.bench, self.client = bench, bench.connect()
        bench.observers.append(lambda: self.client.update(bench.plant.time_us))
        bench.run(60.0, until=lambda: self.client.telemetry.has_state)

    def demand(self, command, *params):
        for _ in range(60):
            sent = self.client.command(command, *params)
            self.bench.run(10.0, until=lambda sent=sent: sent.is_done)
            if sent.state is CommandState.ACCEPTED:
                return
            self.bench.run(1.0)
        raise AssertionError(f"{command}: {sent.outcome()}, {self.client.telemetry.texts[-3:]}")

    def take_off(self):
        self.demand(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        self.demand(mavlink.MAV_CMD_NAV_TAKEOFF, *(float("nan"),) * 7)
        self.bench.run(12.0)

    @property
    def height_m(self):
        return self.bench.plant.truth.position_enu_m[2]


def cfg(**more):
    options = {"autopilot": "px4", "speed": "max", "instance": own_instance(), **more}
    return TestbenchCfg(**options)


def test_begun_anew_in_the_air_it_is_served_and_the_vehicle_falls(started):
    with Testbench(empty_scene(), cfg()) as bench:
        lines = []
        bench.external.listen(lambda _, text: lines.append(text))
        first = started(bench)
        pilot = Pilot(bench)
        pilot.take_off()
        assert pilot.height_m > 2.0
        first.kill()
        first.wait()
        started(bench)
        answered = bench.external.exchanges.answered
        bench.run(10.0)
        assert bench.external.fault == ""
        assert sum("begun anew" in line for line in lines) == 1
        assert bench.external.exchanges.answered > answered + 1000
        assert bench.external.exchanges.left_out == 0
        assert pilot.height_m < 0.5  # It is disarmed.


def test_its_collision_prevention_stops_before_a_wall_that_our_ring_scan_shows():
    wall_m = 16.0
    wall = thing(1, "container", (wall_m + 0.5, 0.0, 5.0), (1.0, 30.0, 10.0))
    scene = replace(empty_scene(), objects=(replace(wall, scene_id="handmade"),))
    with Testbench(scene, cfg(autopilot_binary=PX4)) as bench:
        pilot = Pilot(bench)
        client, system = pilot.client, pilot.client.telemetry.system_id
        client._send(
            mavlink.MAVLink_param_set_message(
                system, 1, b"CP_DIST", 4.0, mavlink.MAV_PARAM_TYPE_REAL32
            )
        )
        pilot.take_off()
        ahead = 0

        def push():
            client._send(mavlink.MAVLink_manual_control_message(system, ahead, 0, MIDDLE, 0, 0))

        bench.observers.append(push)
        bench.run(1.0)
        pilot.demand(mavlink.MAV_CMD_DO_SET_MODE, 1, POSITION_MODE)
        nearest_m = wall_m

        def watch():
            nonlocal nearest_m
            nearest_m = min(nearest_m, wall_m - bench.plant.truth.position_enu_m[0])

        bench.observers.append(watch)
        # Without a report of obstacles it would not move at all: CP_GO_NO_DATA is 0.
        ahead = FULL_AHEAD
        bench.run(20.0)
        assert bench.external.reports.mode.value == "Position"
        assert nearest_m == pytest.approx(4.0, abs=1.0)
