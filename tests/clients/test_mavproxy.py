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

MAVPROXY = Path(sys.executable).with_name("mavproxy.py")


class MavProxy:
    """A MAVProxy process that is typed to and read from."""

    def __init__(self, master: str, directory: Path):
        self._process = subprocess.Popen(
            [
                *(sys.executable, "-u", str(MAVPROXY), f"--master={master}", "--dialect=common"),
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

    def ask(self, line: str, pattern: str) -> None:
        """Type a question until a line answers it as expected."""
        for _ in range(20):
            self.type(line)
            with contextlib.suppress(AssertionError):
                self.expect(pattern, timeout_s=1.0)
                return
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
