"""`aeroscene-sitl` as a user runs it: a process with ports, a recording, a verdict."""

import http.client
import json
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from urllib.parse import urlsplit

import psutil
import pytest
from pymavlink.dialects.v20 import common as mavlink

from flightsim.testbench import TestbenchCfg
from scenarios.recording.summary import summarise
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.instances import own_instance
from tests.scenarios.in_process import in_process
from tests.thorough import THOROUGH

COMMAND = [sys.executable, "-m", "scenarios.cli.sitl"]


def sitl(*args, **options):
    return subprocess.run(
        [*COMMAND, "--instance", str(own_instance()), *args],
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def here(capsys, *args):
    """Status and output of the command, run in this process."""
    return in_process(capsys, "sitl", "--instance", own_instance(), *args)


def demo(capsys, *args):
    """What the demo prints, flown in this process."""
    status, out, err = here(capsys, "--demo", "--speed", "max", "--json", *args)
    assert status in {0, 1}, out + err
    return json.loads(out)


@pytest.fixture(scope="module")
def recorded_demo(tmp_path_factory):
    """The demo flown in a fresh process: what it prints, and its recording."""
    path = tmp_path_factory.mktemp("demo") / "flight.rrd"
    args = ("--record", str(path), "--camera-hz", "1")
    done = sitl("--demo", "--speed", "max", "--json", *args)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout), path


def test_the_demo_lands_on_the_chosen_area_without_touching_anything(recorded_demo):
    result, _ = recorded_demo
    assert result["success"] is True
    assert result["code"] == "landed"
    assert result["landed_area"] == result["area"]
    assert result["soles_inside"] is True
    assert result["contacts_before_touchdown"] == 0
    assert result["touchdown_error_m"] < 0.3
    assert 0.1 < result["touchdown_speed_mps"] < 0.6
    assert result["slide_m"] < 0.05
    assert result["stopped_after_s"] < 2.0
    assert result["rotor_spin_ups"] == 0
    assert 0.0 < result["least_clearance_m"] < 5.0
    assert result["nearest_mover_m"] is None
    (touched,) = result["contacts"]
    assert touched["what"].startswith(("object", "the ground"))
    assert touched["until_s"] == result["sim_seconds"]
    assert result["position_rmse_m"] < 1.5
    assert result["attitude_rmse_deg"] < 2.0
    assert result["cpu_seconds"] > 0.0
    for name, figure in result.items():
        assert not isinstance(figure, float) or figure == round(figure, 3), name


def test_the_recording_and_its_summary_hold_the_same_verdict(recorded_demo):
    result, path = recorded_demo
    beside = json.loads(path.with_suffix(".json").read_text())
    assert beside["result"] == result
    assert beside["config"]["scene"] == "42"
    reasons = [change["reason"] for change in beside["transitions"]]
    assert all(reasons)
    assert beside["limits"]["slide_m"] == 0.3
    assert beside["replans"] == []
    assert summarise(path).is_complete


def test_the_same_seed_gives_the_same_flight_recorded_or_not(recorded_demo, capsys):
    result, _ = recorded_demo
    again = demo(capsys)
    for figure in (
        "sim_seconds",
        "area",
        "touchdown_error_m",
        "position_rmse_m",
        "attitude_rmse_deg",
        "state_hash",
    ):
        assert again[figure] == result[figure]


def test_another_seed_gives_another_flight(capsys):
    short = ("--headless-seconds", "2")
    one, again, other = (demo(capsys, "--seed", seed, *short) for seed in (0, 0, 5))
    assert one["state_hash"] == again["state_hash"] != other["state_hash"]


@THOROUGH  # test_relief_flights lands one over hills
def test_a_hummingbird_lands_too(capsys):
    result = demo(capsys, "--scene", "45", "--vehicle", "hummingbird")
    assert result["success"] is True
    assert result["contacts_before_touchdown"] == 0


def test_standard_gnss_leaves_errors_of_metres(capsys):
    result = demo(capsys, "--gnss", "standard", "--headless-seconds", "12")
    assert result["position_rmse_m"] > 0.5


# The disk is full for this process alone, from a moment after the start.
FILLING_UP = """
import resource, sys
from scenarios.cli import sitl

def run(self, *args, run=sitl.Sitl.run):
    size = self.cfg.record.stat().st_size + 50_000
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return run(self, *args)

sitl.Sitl.run = run
sys.exit(sitl.main())
"""


def test_a_disk_that_fills_up_costs_the_recording_and_not_the_figures(tmp_path):
    path = tmp_path / "flight.rrd"
    args = ("--scene", "field", "--headless-seconds", "8", "--speed", "max", "--camera-hz", "0")
    done = subprocess.run(
        [sys.executable, "-B", "-c", FILLING_UP, "--instance", str(own_instance())]
        + [*args, "--json", "--record", str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert json.loads(done.stdout)["reason"] == "ended"
    assert "Traceback" not in done.stderr
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("aeroscene-sitl: ")]
    assert line.startswith(f"aeroscene-sitl: recording {path} lacks its end and is removed: ")
    assert not path.exists()
    assert json.loads(path.with_suffix(".json").read_text())["result"]["reason"] == "ended"


def test_a_summary_that_cannot_be_written_costs_the_verdict_nothing(tmp_path):
    path = tmp_path / "flight.rrd"
    path.with_suffix(".json").mkdir()
    args = ("--scene", "field", "--headless-seconds", "1", "--speed", "max", "--camera-hz", "0")
    done = sitl(*args, "--json", "--record", str(path))
    assert done.returncode == 2, done.stderr
    assert json.loads(done.stdout)["reason"] == "ended"
    assert f"summary {path.with_suffix('.json')} is not written: " in done.stderr
    assert "Traceback" not in done.stderr
    assert summarise(path).is_complete


@pytest.mark.parametrize("name", ["flight.json", "flight.rrd"])
def test_a_recording_does_not_take_the_place_of_standard_output(tmp_path, name):
    with (tmp_path / name).open("wb") as out:
        done = subprocess.run(
            [*COMMAND, "--json", "--record", str(tmp_path / "flight.rrd")],
            stdout=out,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == (
        f"aeroscene-sitl: error: record '{tmp_path / 'flight.rrd'}' writes '{tmp_path / name}', "
        "where standard output goes; valid: another name for one of them\n"
    )


def test_interrupting_closes_the_recording_and_gives_the_ports_back(tmp_path):
    path = tmp_path / "cut.rrd"
    args = ["--instance", str(own_instance()), "--record", str(path), "--camera-hz", "0"]
    process = subprocess.Popen([*COMMAND, *args], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    port = 5760 + 10 * own_instance()
    assert process.stderr is not None
    assert any(b"Ctrl-C ends" in line for line in process.stderr)
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    assert b"Traceback" not in errors
    assert summarise(path).is_complete
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(("127.0.0.1", port))


def test_a_demo_ends_when_its_time_is_up(capsys):
    args = ("--demo", "--speed", "max", "--json", "--headless-seconds", "2")
    status, out, _ = here(capsys, *args)
    result = json.loads(out)
    assert status == 1
    assert result["sim_seconds"] == 2.0
    assert result["code"] == "time_up"
    assert "not finished, still in " in result["reason"]


def test_a_demo_that_is_told_to_end_says_by_what():
    process = subprocess.Popen(
        [*COMMAND, "--instance", str(own_instance()), "--demo", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    assert any("pilot: arm" in line for line in process.stderr)
    process.send_signal(signal.SIGTERM)
    output, _ = process.communicate()
    result = json.loads(output)
    assert process.returncode == 1
    assert result["code"] == "stopped"
    assert result["reason"].startswith("stopped by SIGTERM: not finished, still in ")


@pytest.fixture
def watched():
    """A run with a web viewer whose flight has ended: the process and the page's address."""
    args = ["--viewer", "web", "--camera-hz", "0", "--speed", "max", "--headless-seconds", "0.5"]
    process = subprocess.Popen(
        [*COMMAND, "--instance", str(own_instance()), *args, "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    try:
        page = next(line for line in process.stderr if line.startswith("Watch at ")).split()[-1]
        assert json.loads(process.stdout.readline())["reason"] == "ended"
        assert "stays until it is closed, or Ctrl-C" in process.stderr.readline()
        children = psutil.Process(process.pid).children(recursive=True)
        yield process, page
        assert process.wait() == 0
        assert not psutil.wait_procs(children, timeout=60)[1]
    finally:
        process.kill()
        process.communicate()


def test_a_page_outlives_the_flight_until_it_is_left(watched):
    process, page = watched
    with urllib.request.urlopen(page) as response:
        assert b"EventSource('/reader')" in response.read()
    reader = http.client.HTTPConnection(urlsplit(page).netloc)
    reader.request("GET", "/reader")
    assert reader.getresponse().readline() == b": still here\n"
    assert process.poll() is None
    reader.close()


def test_a_page_that_nobody_opened_ends_with_ctrl_c(watched):
    process, _ = watched
    process.send_signal(signal.SIGINT)


def test_a_run_that_is_stopped_before_its_first_step_ends_like_any_other():
    with Sitl(SitlCfg(bench=TestbenchCfg(instance=own_instance()))) as run:
        result = run.run(lambda: True)
    assert result.success is None
    assert result.sim_seconds == 0.0
    assert result.position_rmse_m is None


def test_a_port_in_use_is_named_with_the_way_out(capsys):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 18570 + own_instance()))
        status, _, err = here(capsys)
    assert status == 2
    assert f"UDP port {18570 + own_instance()}" in err
    assert "--instance" in err
    assert err.count("\n") == 1


def test_a_recording_that_cannot_be_written_is_refused_before_anything_flies(tmp_path, capsys):
    (tmp_path / "file").touch()
    status, out, err = here(capsys, "--record", tmp_path / "file" / "flight.rrd")
    assert (status, out) == (2, "")
    assert err.count("\n") == 1


def test_a_folder_that_is_missing_is_made_and_told(tmp_path, capsys):
    path = tmp_path / "new" / "flight.rrd"
    status, _, err = here(capsys, "--record", path, "--headless-seconds", "0.1")
    assert status == 0
    assert f"Folder {tmp_path / 'new'} was missing and is made." in err
    assert summarise(path).is_complete


def test_the_first_heartbeat_comes_unasked_and_nothing_listens_beyond_loopback():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(("127.0.0.1", 14550 + own_instance()))
        station.settimeout(30.0)
        process = subprocess.Popen(
            [*COMMAND, "--instance", str(own_instance())],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            messages = mavlink.MAVLink(None).parse_buffer(station.recv(2048))
            opened = [each.laddr for each in psutil.Process(process.pid).net_connections()]
        finally:
            process.send_signal(signal.SIGTERM)
            # Its ports are open a moment before it runs.
            assert process.wait() in {0, 130}
    assert any(message.get_type() == "HEARTBEAT" for message in messages)
    assert {address.ip for address in opened} == {"127.0.0.1"}
    assert 5760 + 10 * own_instance() in {address.port for address in opened}
