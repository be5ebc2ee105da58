"""One published example against a fresh testbench."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from tests.clients.conftest import TestbenchProcess
from tests.clients.published.examples import EXAMPLES, Example

_WARNINGS = re.compile(r"^(?:\[|I\d{4}|WARNING|.*FutureWarning|\s)")
_LIMIT_S = 300.0
_ENDLESS_S = 8.0
"""Time for which an endless example goes on without a fault after what it should say."""
_FAULTS = re.compile(r"Traceback|Error\b|exception was never retrieved")
_FAULT_S = 2.0
"""Time in which an example says the whole of a fault: it may wait for ever after it."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of an example."""

    finishes: bool
    seconds: float
    note: str
    output: str


def package_of(python: str) -> str:
    """Package of an interpreter that has the examples' interface: it was renamed in 2026."""
    renamed = subprocess.run([python, "-c", "import mavsdk_grpc"], capture_output=True, check=False)
    return "mavsdk" if renamed.returncode else "mavsdk_grpc"


class Runner:
    """Runs one example after the other, each with a vehicle that none but its forerunner flew."""

    def __init__(self, examples: Path, instance: int, python: str) -> None:
        self._examples = examples
        self._instance = instance
        self._python = python
        self._package = package_of(python)
        self._bench: TestbenchProcess | None = None

    def run(self, example: Example) -> Outcome:
        """Run an example to its end, or to its limit."""
        if example.options or example.follows:
            self.close()
        if self._bench is None:
            options = ("--speed", "1", "--headless-seconds", "3600", *example.options)
            self._bench = TestbenchProcess(*options, instance=self._instance)
            self._bench.wait_until_open()
        try:
            if example.follows:
                self._run(EXAMPLES[example.follows], self._bench)
            return self._run(example, self._bench)
        finally:
            if example.options or not example.is_quiet:
                self.close()

    def _run(self, example: Example, bench: TestbenchProcess) -> Outcome:
        with tempfile.TemporaryDirectory() as folder:
            return self._run_in(Path(folder), example, bench)

    def _run_in(self, folder: Path, example: Example, bench: TestbenchProcess) -> Outcome:
        published = example.path(self._examples)
        for data in (*published.parent.glob("*.plan"), *published.parent.glob("*.csv")):
            shutil.copy(data, folder)
        script = folder / published.name
        source = published.read_text(encoding="utf-8")
        for there, here in example.edits.items():
            source = source.replace(there, here)
        script.write_text(_addressed(source, bench, self._package), encoding="utf-8")
        before = time.monotonic()
        process = subprocess.Popen(
            [self._python, "-u", "-W", "ignore", script.name],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        output: list[str] = []
        reader = threading.Thread(target=_read, args=(process, output), daemon=True)
        reader.start()
        has_ended = _wait(example, process, output)
        seconds = time.monotonic() - before
        if process.poll() is not None:
            reader.join(5.0)
        text = "".join(output)  # What the interrupt makes it say is no fault of its.
        _end(process)
        is_said = re.search(example.says, text) is not None
        is_sound = not _FAULTS.search(text) and bench.process.poll() is None
        lines = [line for line in text.splitlines() if line and not _WARNINGS.match(line)]
        return Outcome(
            finishes=has_ended and is_said and is_sound,
            seconds=seconds,
            note=lines[-1][:90] if lines else "",
            output=text,
        )

    def close(self) -> None:
        """End the testbench."""
        if self._bench is not None:
            self._bench.kill()
        self._bench = None


def _end(process: subprocess.Popen[str]) -> None:
    """End an example as Ctrl-C does, so that it ends its server too, or by force."""
    process.send_signal(signal.SIGINT)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(10.0)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _read(process: subprocess.Popen[str], output: list[str]) -> None:
    assert process.stdout is not None
    while piece := process.stdout.readline():
        output.append(piece)


def _wait(example: Example, process: subprocess.Popen[str], output: list[str]) -> bool:
    """Wait for the end of an example; return whether it has come to it."""
    deadline = time.monotonic() + _LIMIT_S
    while time.monotonic() < deadline:
        if process.poll() is not None:
            return process.returncode == 0
        if _FAULTS.search("".join(output)):
            time.sleep(_FAULT_S)
            return False
        if example.is_endless and re.search(example.says, "".join(output)):
            time.sleep(_ENDLESS_S)
            return process.poll() is None
        time.sleep(0.2)
    return False


def _addressed(source: str, bench: TestbenchProcess, package: str) -> str:
    """Source of an example with its address, its server's port and its package put in."""
    server = bench.sdk_server_port
    for there, here in (
        ("udpin://0.0.0.0:14540", bench.sdk_address),
        ("serial:///dev/ttyACM0:57600", bench.sdk_address),
        ('System(mavsdk_server_address="localhost", port=50051)', f"System(port={server})"),
        ("System()", f"System(port={server})"),
        (".connect()", f'.connect(system_address="{bench.sdk_address}")'),
        ("from mavsdk", f"from {package}"),
        ("import mavsdk", f"import {package}"),
    ):
        source = source.replace(there, here)
    return source
