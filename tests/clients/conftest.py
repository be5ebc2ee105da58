"""Real testbench process on real ports."""

import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.instances import own_instance

SPEED = 4
"""Simulated seconds per wall second: clients use wall time."""


@dataclass
class Testbench:
    """A running `aeroscene-sitl` with its ports."""

    instance: int
    process: subprocess.Popen

    @property
    def sdk_address(self) -> str:
        return f"udpin://0.0.0.0:{14540 + self.instance}"

    @property
    def tcp_port(self) -> int:
        return 5760 + 10 * self.instance

    def wait_until_open(self) -> None:
        """Wait until the TCP port accepts connections."""
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            assert self.process.poll() is None, "the testbench ended by itself"
            with socket.socket() as probe:
                probe.settimeout(1.0)
                if probe.connect_ex(("127.0.0.1", self.tcp_port)) == 0:
                    return
            time.sleep(0.1)
        raise AssertionError("the testbench did not open its ports within 60 s")

    def stop(self) -> str:
        """Interrupt it as Ctrl-C does and return its standard error."""
        self.process.send_signal(signal.SIGINT)
        _, errors = self.process.communicate(timeout=20)
        return errors


@pytest.fixture
def testbench(tmp_path):
    instance = own_instance()
    arguments = ["--scene", "field", "--speed", str(SPEED), "--instance", str(instance)]
    process = subprocess.Popen(
        [sys.executable, "-m", "scenarios.cli.sitl", *arguments, "--headless-seconds", "600"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    bench = Testbench(instance, process)
    try:
        bench.wait_until_open()
        yield bench
        assert process.poll() is None, "the testbench ended by itself"
        errors = bench.stop()
        assert "Traceback" not in errors, errors
        assert process.returncode == 0, errors
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()


@pytest.fixture
def run_script(testbench):
    """Run a client script to its end in its own process."""

    def run(name: str, *arguments: str, timeout_s: float = 60.0) -> None:
        script = Path(__file__).parent / "scripts" / name
        done = subprocess.run(
            [sys.executable, str(script), *arguments],
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
        assert done.returncode == 0, f"{name}:\n{done.stdout}\n{done.stderr}"

    return run
