"""MAVProxy, a ground station on the command line."""

import contextlib
import os
import queue
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from flightsim.mavlink.personalities import ARDUPILOT

MAVPROXY = Path(sys.executable).with_name("mavproxy.py")
N_PARAMETERS = len(ARDUPILOT.aliases) + len(ARDUPILOT.settings)


class MavProxy:
    """A MAVProxy process that is typed to and read from."""

    def __init__(self, master: str, directory: Path, dialect: str = "common"):
        self._process = subprocess.Popen(
            [
                *(
                    sys.executable,
                    "-u",
                    str(MAVPROXY),
                    f"--master={master}",
                    f"--dialect={dialect}",
                ),
                *(f"--state-basedir={directory}", f"--logfile={directory / 'mav.tlog'}"),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=directory,
            env=os.environ | {"HOME": str(directory)},
        )
        self._lines: queue.Queue[str] = queue.Queue()
        self.seen = ""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        # The pipe is closed under the reader when the process ends.
        with contextlib.suppress(ValueError):
            for line in self._process.stdout:
                self._lines.put(line)

    def type(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def expect(self, pattern: str, timeout_s: float = 300.0) -> re.Match[str]:
        """Read on until a line matches."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            try:
                line = self._lines.get(timeout=0.2)
            except queue.Empty:
                continue
            self.seen += line
            found = re.search(pattern, line)
            if found:
                return found
        raise AssertionError(f"no {pattern!r} in:\n{self.seen}")

    def wait_until_said(self, pattern: str) -> None:
        """Read on until a line matches, unless one has matched before."""
        if not re.search(pattern, self.seen):
            self.expect(pattern)

    def ask(self, line: str, pattern: str) -> re.Match[str]:
        """Type a question until a line answers it as expected."""
        for _ in range(20):
            self.type(line)
            with contextlib.suppress(AssertionError):
                return self.expect(pattern, timeout_s=1.0)
        raise AssertionError(f"no {pattern!r} to {line!r} in:\n{self.seen}")

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.communicate()


@pytest.mark.timeout(150)
def test_mavproxy_connects_lists_parameters_and_arms(testbench, tmp_path):
    proxy = MavProxy(f"udpin:127.0.0.1:{14550 + testbench.instance}", tmp_path)
    try:
        proxy.expect(rf"Detected vehicle {1 + testbench.instance}:1")
        n_parameters = int(proxy.expect(r"Received (\d+) parameters")[1])
        assert n_parameters > 50
        proxy.type("param set MIS_TAKEOFF_ALT 4")
        proxy.ask("param show MIS_TAKEOFF_ALT", r"MIS_TAKEOFF_ALT\s+4\.0")
        proxy.type("ftp list")
        proxy.expect("Listing /")
        proxy.type("arm throttle")
        proxy.expect(r"COMPONENT_ARM_DISARM: ACCEPTED")
        proxy.expect("ARMED")
        proxy.type("takeoff 4")
        proxy.expect(r"NAV_TAKEOFF: ACCEPTED")
        proxy.expect("Takeoff detected")
        proxy.type("disarm")
        proxy.expect("Disarming denied")
        proxy.type("exit")
    finally:
        proxy.close()


@pytest.fixture
def guided(copter, tmp_path):
    """MAVProxy at a vehicle as ArduPilot's, which signs all that either says from the start."""
    proxy = MavProxy(f"tcp:127.0.0.1:{copter.tcp_port}", tmp_path, dialect="ardupilotmega")
    try:
        proxy.expect(rf"Detected vehicle {1 + copter.instance}:1")
        n_parameters = int(proxy.expect(r"Received (\d+) parameters \(ftp\)")[1])
        assert n_parameters == N_PARAMETERS
        proxy.type("signing setup open-sesame")
        proxy.expect("Signing is on")
        yield proxy
        proxy.type("signing remove")
        proxy.expect("Signing is off")
        proxy.type("exit")
    finally:
        proxy.close()


def _save_and_load_parameters(proxy, directory):
    saved = directory / "saved.parm"
    proxy.type("param set RTL_ALT 800")
    proxy.ask("param show RTL_ALT", r"RTL_ALT\s+800\.0")
    proxy.type(f"param save {saved}")
    proxy.expect(rf"Saved {N_PARAMETERS} parameters")
    proxy.type("param set RTL_ALT 1200")
    proxy.ask("param show RTL_ALT", r"RTL_ALT\s+1200\.0")
    proxy.type(f"param load {saved}")
    proxy.expect(r"changed RTL_ALT from 1200\S* to 800")
    proxy.expect(rf"Loaded {N_PARAMETERS} parameters .*\(changed 1\)")


def _load_and_read_back(proxy, directory, name, title, items):
    """Load a plan's file, read it back from the vehicle, and hold that it is the same."""
    sent, came = directory / f"{name}.txt", directory / f"{name}_back.txt"
    rows = ["\t".join(map(str, (seq, 0, *item, 1))) for seq, item in enumerate(items)]
    sent.write_text("\n".join(("QGC WPL 110", *rows, "")))
    proxy.type(f"{name} load {sent}")
    proxy.expect(rf"Loaded {len(items)} {title} in")
    proxy.type(f"{name} save {came}")
    proxy.expect(rf"Saved {len(items)} {title} to {came}")
    back = [[float(word) for word in line.split()] for line in came.read_text().splitlines()[1:]]
    n_home_items = 1 if name == "wp" else 0  # The vehicle knows better where home is.
    assert len(back) == len(items)
    for row, item in zip(back[n_home_items:], items[n_home_items:], strict=True):
        assert row[2:11] == pytest.approx(item, abs=1e-6)


def _switch_the_fence(proxy):
    # MAVProxy tells changes between two reports, and the first after the upload may be on its way.
    proxy.wait_until_said("fence enabled")
    proxy.type("fence disable")
    proxy.expect(r"DO_FENCE_ENABLE: ACCEPTED")
    proxy.expect("fence disabled")
    proxy.type("fence enable")
    proxy.expect(r"DO_FENCE_ENABLE: ACCEPTED")
    proxy.expect("fence enabled")


def _place(proxy):
    place = proxy.ask("status GLOBAL_POSITION_INT", r"lat : (-?\d+), lon : (-?\d+)")
    return tuple(int(part) * 1e-7 for part in place.groups())


def _load_plans(proxy, directory, latitude_deg, longitude_deg, altitude_m):
    nothing, here = (0, 0, 0, 0), (latitude_deg, longitude_deg)
    home = (0, 16, *nothing, *here, altitude_m)
    away = (3, 16, *nothing, latitude_deg + 5e-5, longitude_deg, 9)
    back = (3, 20, *nothing, 0, 0, 0)
    _load_and_read_back(proxy, directory, "wp", "waypoints", [home, away, back])
    circle = (0, 5003, 150, 0, 0, 0, *here, 0)
    _load_and_read_back(proxy, directory, "fence", "fence items", [circle])
    rally = (3, 5100, *nothing, latitude_deg - 5e-5, longitude_deg, 12)
    _load_and_read_back(proxy, directory, "rally", "rally items", [rally])


def _fly_guided_and_the_mission(proxy, latitude_deg, longitude_deg):
    # The prompt has the vehicle's mode; of heartbeats, `status` has whatever component's came last.
    proxy.ask("mode guided", "GUIDED>")
    proxy.type("arm throttle")
    proxy.expect("ARMED")
    proxy.type("takeoff 6")
    proxy.expect(r"NAV_TAKEOFF: ACCEPTED")
    height = r"relative_alt : (5[6-9]\d\d|6[0-4]\d\d)\b"
    proxy.ask("status GLOBAL_POSITION_INT", height)
    proxy.type(f"guided {latitude_deg + 1e-4} {longitude_deg} 9")
    proxy.ask("status GLOBAL_POSITION_INT", r"relative_alt : (8[7-9]\d\d|9[0-3]\d\d)\b")
    proxy.ask("status GLOBAL_POSITION_INT", rf"lat : {round(latitude_deg * 1e7 + 1000) // 100}")
    proxy.type("mode auto")
    proxy.ask("status MISSION_CURRENT", r"seq : 2\b")
    proxy.expect("Disarmed by landing|DISARMED", timeout_s=300.0)


def _download_the_log(proxy, directory):
    """By the log protocol and by FTP, and hold that both are one."""
    by_log, by_ftp = directory / "by_log.ulg", directory / "by_ftp.ulg"
    proxy.type("log list")
    size = int(proxy.expect(r"^Log 0 +numLogs 1 lastLog 0 size (\d+)")[1])
    proxy.type(f"log download 0 {by_log}")
    proxy.expect(rf"Finished downloading .* \({size} bytes")
    proxy.type("ftp list /log")
    proxy.expect(rf"0\.ulg\s+{size}\b")
    proxy.type(f"ftp get /log/0.ulg {by_ftp}")
    proxy.expect(rf"Wrote {size} bytes")
    deadline_s = time.monotonic() + 10.0
    while by_ftp.stat().st_size < size and time.monotonic() < deadline_s:
        time.sleep(0.1)  # It says that it has written before it has.
    assert by_log.read_bytes() == by_ftp.read_bytes()
    assert by_log.read_bytes().startswith(b"ULog")


@pytest.mark.timeout(300)
def test_mavproxy_works_and_flies_signed_as_with_ardupilot(guided, copter, tmp_path):
    latitude_deg, longitude_deg = _place(guided)
    _save_and_load_parameters(guided, tmp_path)
    _load_plans(guided, tmp_path, latitude_deg, longitude_deg, 0.0)
    _switch_the_fence(guided)
    guided.type("motortest 1 0 10 1")
    guided.expect(r"DO_MOTOR_TEST: ACCEPTED")
    _fly_guided_and_the_mission(guided, latitude_deg, longitude_deg)
    _download_the_log(guided, tmp_path)
