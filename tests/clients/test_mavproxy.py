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
        for line in self._process.stdout:
            self._lines.put(line)

    def type(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def expect(self, pattern: str, timeout_s: float = 30.0) -> re.Match[str]:
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


@pytest.mark.timeout(300)
def test_mavproxy_flies_guided_as_with_ardupilot(copter, tmp_path):
    proxy = MavProxy(f"tcp:127.0.0.1:{copter.tcp_port}", tmp_path, dialect="ardupilotmega")
    try:
        proxy.expect(rf"Detected vehicle {1 + copter.instance}:1")
        n_parameters = int(proxy.expect(r"Received (\d+) parameters")[1])
        assert n_parameters == len(ARDUPILOT.aliases)
        proxy.type("param set RTL_ALT 800")
        proxy.ask("param show RTL_ALT", r"RTL_ALT\s+800\.0")
        proxy.type("mode guided")
        proxy.ask("status HEARTBEAT", r"custom_mode : 4\b")
        proxy.type("arm throttle")
        proxy.expect("ARMED")
        proxy.type("takeoff 6")
        proxy.expect(r"NAV_TAKEOFF: ACCEPTED")
        height = r"relative_alt : (5[6-9]\d\d|6[0-4]\d\d)\b"
        proxy.ask("status GLOBAL_POSITION_INT", height)
        place = proxy.ask("status GLOBAL_POSITION_INT", r"lat : (-?\d+), lon : (-?\d+)")
        latitude_deg, longitude_deg = (int(part) * 1e-7 for part in place.groups())
        proxy.type(f"guided {latitude_deg + 1e-4} {longitude_deg} 9")
        proxy.ask("status GLOBAL_POSITION_INT", r"relative_alt : (8[7-9]\d\d|9[0-3]\d\d)\b")
        proxy.ask("status GLOBAL_POSITION_INT", rf"lat : {round(latitude_deg * 1e7 + 1000) // 100}")
        proxy.type("mode rtl")
        proxy.expect("Disarmed by landing|DISARMED", timeout_s=90.0)
        proxy.type("exit")
    finally:
        proxy.close()
