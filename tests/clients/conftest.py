"""Real testbench process on real ports."""

import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.instances import own_instance

DOCS = Path(__file__).parents[2] / "docs"
SPEED = 4
"""Simulated seconds per wall second: clients use wall time."""


class TestbenchProcess:
    """A running `aeroscene-sitl field`, on the ports of this process unless others are named."""

    __test__ = False

    def __init__(self, *options: str, instance: int | None = None) -> None:
        self.instance = own_instance() if instance is None else instance
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", "scenarios.cli.sitl", "field"),
                *("--instance", str(self.instance), *options),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    @property
    def sdk_address(self) -> str:
        return f"udpin://0.0.0.0:{14540 + self.instance}"

    @property
    def sdk_server_port(self) -> int:
        """Port for the server of a MAVSDK that connects: two at one port mix their vehicles."""
        return 50_100 + self.instance

    @property
    def tcp_port(self) -> int:
        return 5760 + 10 * self.instance

    def wait_until_open(self) -> None:
        """Wait until the TCP port accepts connections."""
        deadline = time.monotonic() + 180.0
        while time.monotonic() < deadline:
            assert self.process.poll() is None, "the testbench ended by itself"
            with socket.socket() as probe:
                probe.settimeout(1.0)
                if probe.connect_ex(("127.0.0.1", self.tcp_port)) == 0:
                    return
            time.sleep(0.1)
        raise AssertionError("the testbench did not open its ports within 180 s")

    def stop(self) -> str:
        """Interrupt it as Ctrl-C does and return its standard error."""
        self.process.send_signal(signal.SIGINT)
        _, errors = self.process.communicate()
        return errors

    def kill(self) -> None:
        """End it if it has not ended, and read nothing more of it."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdout, self.process.stderr):
            assert pipe is not None
            pipe.close()


def _running(*options: str) -> Iterator[TestbenchProcess]:
    bench = TestbenchProcess("--speed", str(SPEED), "--headless-seconds", "600", *options)
    try:
        bench.wait_until_open()
        yield bench
        assert bench.process.poll() is None, "the testbench ended by itself"
        errors = bench.stop()
        assert "Traceback" not in errors, errors
        assert bench.process.returncode == 0, errors
    finally:
        bench.kill()


@pytest.fixture
def testbench():
    """A testbench as PX4 is."""
    yield from _running()


@pytest.fixture
def copter():
    """A testbench as ArduPilot is."""
    yield from _running("--personality", "ardupilot")


def run_page(page: str, bench: TestbenchProcess) -> list[str]:
    """Lines that the only script of a page of docs prints, with the ports of this testbench."""
    source = (DOCS / page).read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(.*?)```", source, re.DOTALL)
    for there, here in (
        ("14540", str(14540 + bench.instance)),
        ("5760", str(bench.tcp_port)),
        ("System()", f"System(port={bench.sdk_server_port})"),
    ):
        script = script.replace(there, here)
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.fixture
def run_script():
    """Run a client script to its end in its own process."""

    def run(name: str, *arguments: str) -> None:
        script = Path(__file__).parent / "scripts" / name
        done = subprocess.run(
            [sys.executable, str(script), *arguments],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{name}:\n{done.stdout}\n{done.stderr}"

    return run
