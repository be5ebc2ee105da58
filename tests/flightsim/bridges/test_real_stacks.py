"""What the real stacks do here, and what becomes of a flight in which one fails.

They fly where AEROSCENE_PX4 or AEROSCENE_ARDUCOPTER names a binary.
"""

import json
import os
import signal
import socket
import threading

import pytest

from flightsim.bridges import stack as stack_module
from flightsim.bridges.physics.ardupilot import PORT, PORT_STEP
from flightsim.bridges.physics.bridge import Exchanges
from flightsim.bridges.stack import ExternalStack
from flightsim.mavlink.dialect import layout
from flightsim.testbench import Testbench
from scenarios.cli.sitl import main
from tests.flightsim.bridges.real import ARDUCOPTER, PX4, Pilot, needs
from tests.flightsim.handmade import empty_scene
from tests.instances import own_instance

BOTH = [pytest.param(real, id=real.name, marks=needs(real)) for real in (PX4, ARDUCOPTER)]
CLIMBED_M = 2.0
ANSWER = layout("HIL_ACTUATOR_CONTROLS", "time_usec", "flags", "controls", "mode")


@pytest.fixture
def fly(capsys, tmp_path, monkeypatch):
    """Flies the demo, does a deed to the stack in the air; exit status, result and errors."""

    def fly(real, deed):
        original, fates = ExternalStack.update, [deed]

        def update(self):
            original(self)
            height_m = (
                self._plant.truth.position_enu_m[2]
                - self._plant.world.scene.start_position_enu_m[2]
            )
            if fates and height_m > CLIMBED_M:
                fates.pop()(self)

        monkeypatch.setattr(ExternalStack, "update", update)
        record = tmp_path / "flight.rrd"
        options = {
            "autopilot": real.name,
            "autopilot-binary": real.binary,
            "instance": str(own_instance()),
        }
        words = [
            "42",
            *(f"--{name}={value}" for name, value in options.items()),
            *("--demo", "--speed", "max", "--json", "--record", str(record)),
            *("--camera-hz", "0"),
        ]
        try:
            status = main(words)
        except SystemExit as end:  # A run that was ended is an error, said in one line.
            status = end.code
        out, err = capsys.readouterr()
        result = json.loads(out)
        assert json.loads(record.with_suffix(".json").read_text())["result"] == result
        assert record.stat().st_size > 100_000
        return status, result, err

    return fly


def signalled(stack, number):
    os.kill(stack._process._process.pid, number)


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
@pytest.mark.parametrize("real", BOTH)
def test_it_takes_off_and_knows_where_it_is(real, vehicle):
    with Testbench(empty_scene(), real.cfg(autopilot_binary=real.binary, vehicle=vehicle)) as bench:
        pilot = Pilot(bench, real)
        pilot.take_off()
        assert bench.external.fault == ""
        assert pilot.height_m == pytest.approx(real.height_m, abs=0.5)
        position_m, angle_deg = pilot.error()
        assert position_m < 1.0
        assert angle_deg < 3.0
        assert bench.stack.reports.is_armed
        assert bench.stack.monitor.telemetry.system_id == 1 + own_instance()


@pytest.mark.parametrize("real", BOTH)
def test_killed_in_the_air_it_ends_the_run_by_one_line(fly, real):
    status, result, err = fly(real, lambda stack: signalled(stack, signal.SIGKILL))
    assert status == 2
    assert err.count(f"the run was ended by {real.title}'s end by SIGKILL") == 1
    assert f"{real.title}'s end by SIGKILL" in result["reason"]


@pytest.mark.parametrize("real", BOTH)
def test_halted_in_the_air_it_ends_the_run_by_one_line(fly, monkeypatch, real):
    monkeypatch.setattr(stack_module, "SILENCE_S", 2.0)
    status, result, err = fly(real, lambda stack: signalled(stack, signal.SIGSTOP))
    assert status == 2
    assert err.count(f"the run was ended by {real.title}'s silence of 2 s at t = ") == 1
    assert f"{real.title}'s silence" in result["reason"]


@pytest.mark.parametrize("real", BOTH)
def test_halted_for_a_moment_it_flies_on_and_nothing_is_lost(fly, real):
    def halt(stack):
        signalled(stack, signal.SIGSTOP)
        threading.Timer(2.0, signalled, (stack, signal.SIGCONT)).start()

    status, result, _ = fly(real, halt)
    assert (status, result["code"]) == (0, "landed")
    assert Exchanges(**result["lockstep"]).is_whole


class Tampered:
    """PX4's connection, of which the next bytes read are changed once."""

    def __init__(self, connection, change):
        self._connection, self._changes = connection, [change]

    def __getattr__(self, name):
        return getattr(self._connection, name)

    def recv(self, n_bytes):
        data = self._connection.recv(n_bytes)
        return self._changes.pop()(data) if self._changes and data else data


def without_lockstep(data):
    """An answer of a build without lockstep, out of one with it."""
    time_us, _, *others = ANSWER.unpack(ANSWER.payload_v2(data))
    return ANSWER.frame_v2(ANSWER.pack(time_us, 0, *others), data[4], data[5], data[6])


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (lambda data: b"GET / HTTP/1.1\r\n\r\n" + data, "bytes that are no MAVLink are ignored"),
        (without_lockstep, "PX4 runs without lockstep (flags 0)"),
    ],
    ids=["malformed", "another version"],
)
@pytest.mark.parametrize("real", BOTH[:1])
def test_what_px4_should_not_say_is_one_line_and_it_flies_on(fly, real, change, line):
    def tamper(stack):
        stack._bridge._socket = Tampered(stack._bridge._socket, change)

    status, result, err = fly(real, tamper)
    assert (status, result["code"]) == (0, "landed")
    assert err.count(line) == 1
    assert Exchanges(**result["lockstep"]).is_whole


@pytest.mark.parametrize(
    "packet",
    [b"hello", (18459).to_bytes(2, "little") + bytes(38)],
    ids=["malformed", "another version"],
)
@pytest.mark.parametrize("real", BOTH[1:])
def test_what_arducopter_should_not_say_is_one_line_and_it_flies_on(fly, real, packet):
    def send(_):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            for _ in range(3):
                other.sendto(packet, ("127.0.0.1", PORT + PORT_STEP * own_instance()))

    status, result, err = fly(real, send)
    assert (status, result["code"]) == (0, "landed")
    assert err.count(f"{len(packet)} bytes with magic") == 1
    assert Exchanges(**result["lockstep"]).is_whole


@pytest.mark.parametrize("real", BOTH)
def test_begun_anew_in_the_air_it_is_served_and_the_vehicle_falls(real, tmp_path):
    processes = []
    try:
        with Testbench(empty_scene(), real.cfg()) as bench:
            lines = []
            bench.external.listen(lambda _, text: lines.append(text))
            processes.append(real.start(bench.external.start_line, tmp_path))
            pilot = Pilot(bench, real)
            pilot.take_off()
            assert pilot.height_m > CLIMBED_M
            processes[0].kill()
            processes[0].wait()
            processes.append(real.start(bench.external.start_line, tmp_path))
            answered = bench.external.exchanges.answered
            bench.run(10.0)
            assert bench.external.fault == ""
            assert sum("begun anew" in line for line in lines) == 1
            assert bench.external.exchanges.answered > answered + 1000
            assert bench.external.exchanges.left_out == 0
            assert pilot.height_m < 0.5  # It is disarmed.
    finally:
        for process in processes:
            process.kill()
            process.wait()
