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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.clients.conftest import TestbenchProcess

_WARNINGS = re.compile(r"^(?:\[|I\d{4}|WARNING|.*FutureWarning|\s)")
_LIMIT_S = 300.0
_FUTILE_LIMIT_S = 60.0
"""Time after which an example that does not finish here is given up."""
_ENDLESS_S = 8.0
"""Time for which an endless example goes on without a fault after what it should say."""
_FAULTS = re.compile(r"Traceback|Error\b|exception was never retrieved")


@dataclass(frozen=True, kw_only=True)
class Example:
    """A published example, and how it ends."""

    name: str
    says: str = ""
    """What it prints on its way, a regular expression."""
    is_endless: bool = False
    """Whether it never ends by itself, so that going on without a fault is its end."""
    is_quiet: bool = False
    """Whether it leaves the vehicle as it was, so that the next example may have it."""
    folder: str = ""
    """Folder of its own among the examples."""
    edits: Mapping[str, str] = field(default_factory=dict)
    """What of its source is replaced, besides its address."""
    options: Sequence[str] = ()
    """Options of a testbench of its own."""
    but: str | None = None
    """Why it does not finish here; None where it does."""

    def path(self, examples: Path) -> Path:
        """Its script within the folder of the examples."""
        return examples / self.folder / f"{self.name}.py"


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of an example."""

    finishes: bool
    seconds: float
    note: str
    output: str


def _examples(*examples: Example) -> dict[str, Example]:
    return {example.name: example for example in examples}


EXAMPLES = _examples(
    Example(name="takeoff_and_land", is_quiet=True, says="-- Landing"),
    # The log of the flight before it.
    Example(name="logfile_download", is_quiet=True, says="Downloading"),
    # It asks for the firmware of an I/O board, which no simulator has; this is the same log.
    Example(
        name="ftp_download_file",
        says=r"Got (\d+) of \1 bytes",
        edits={"/etc/extras/px4_io-v2_default.bin": "/log/0.ulg"},
    ),
    Example(name="mission", says="Mission progress: 3/3"),
    Example(name="goto", is_endless=True, says="Staying connected"),
    Example(name="offboard_position_ned", says="Stopping offboard"),
    Example(name="offboard_velocity_ned", says="Stopping offboard"),
    Example(name="offboard_velocity_body", says="Stopping offboard"),
    Example(name="offboard_attitude", says="Stopping offboard"),
    Example(name="offboard_position_velocity_ned", says="Stopping offboard"),
    Example(name="offboard_from_csv", folder="offboard_from_csv", says="-- Disarming"),
    Example(name="do_orbit", says="--- Landing"),
    Example(name="geofence", says="Geofence uploaded!"),
    Example(name="follow_me_example", says="-- Landing"),
    Example(name="manual_control", is_endless=True, says="Starting manual control"),
    Example(name="telemetry_takeoff_and_land", says="Altitude: 2"),
    Example(name="telemetry", is_quiet=True, is_endless=True, says="Position: "),
    Example(
        name="telemetry_flight_mode",
        is_quiet=True,
        is_endless=True,
        says="FlightMode: HOLD",
    ),
    Example(
        name="telemetry_is_armed_is_in_air",
        is_quiet=True,
        is_endless=True,
        says="Is_in_air: False",
    ),
    Example(
        name="telemetry_status_text",
        is_quiet=True,
        is_endless=True,
        says="Connected to drone",
    ),
    Example(name="highres_imu", is_quiet=True, is_endless=True, says="Temperature"),
    Example(name="firmware_version", is_quiet=True, says="flight_sw_major"),
    Example(name="all_params", is_quiet=True, says="MIS_TAKEOFF_ALT"),
    Example(name="mission_import", is_quiet=True, says="Mission uploaded"),
    Example(name="mission_raw", is_quiet=True, says="-- Done"),
    Example(name="failure_injection", says="Disabling failure injection"),
    Example(name="ftp_list_dir", is_quiet=True, says="directory list"),
    Example(name="shell", is_quiet=True, is_endless=True, says="nsh> "),
    Example(name="send_status_message", is_quiet=True, says="Connected to drone"),
    Example(name="tune", is_quiet=True, says="Tune played"),
    Example(
        name="mavlink_direct_receive", is_quiet=True, is_endless=True, says=r"ATTITUDE from \d+/1"
    ),
    Example(name="mavlink_direct_send", is_quiet=True, says="Sending airspeed 19"),
    Example(name="px4_ev_automation", is_quiet=True, is_endless=True, says="Flight Mode: "),
    Example(name="rtcm", is_quiet=True),
    Example(
        name="transponder",
        is_quiet=True,
        is_endless=True,
        says="icao_address",
        options=("--traffic", "drones=1"),
    ),
    Example(
        name="calibration",
        is_quiet=True,
        says="Board level calibration finished",
        but="it wants the vehicle turned by hand",
    ),
    Example(
        name="camera",
        is_quiet=True,
        says="Camera mode",
        but="it calls the camera as MAVSDK 2 had it, without naming which",
    ),
    Example(
        name="gimbal",
        is_quiet=True,
        says="Release control",
        but="it finds the gimbal, then waits for an end of the list of gimbals, which has none",
    ),
    Example(
        name="gripper", is_quiet=True, is_endless=True, says="Staying connected", but="no gripper"
    ),
    Example(name="winch", is_quiet=True, is_endless=True, says="Staying connected", but="no winch"),
)

NOT_RUN: Mapping[str, str] = {
    "camera_params": "asks at the keyboard what to set",
    "px4_ev_automation_keyboard": "asks at the keyboard what to set",
    "rtk_base_ublox": "reads a satellite receiver on a serial port",
    "show_debug_output": "connects to an address that is wrong on purpose",
    "upload_params": "takes a file of parameters, of which none is published",
}
"""The other published examples, and why they are not run."""


def package_of(python: str) -> str:
    """Package of an interpreter that has the examples' interface: it was renamed in 2026."""
    renamed = subprocess.run([python, "-c", "import mavsdk_grpc"], capture_output=True, check=False)
    return "mavsdk" if renamed.returncode else "mavsdk_grpc"


class Runner:
    """Runs one example after the other, each with a vehicle that none has flown before."""

    def __init__(self, examples: Path, instance: int, python: str) -> None:
        self._examples = examples
        self._instance = instance
        self._python = python
        self._package = package_of(python)
        self._bench: TestbenchProcess | None = None

    def run(self, example: Example) -> Outcome:
        """Run an example to its end, or to its limit."""
        if example.options:
            self.close()
        if self._bench is None:
            options = ("--speed", "1", "--headless-seconds", "3600", *example.options)
            self._bench = TestbenchProcess(*options, instance=self._instance)
            self._bench.wait_until_open()
        try:
            with tempfile.TemporaryDirectory() as folder:
                return self._run(example, self._bench, Path(folder))
        finally:
            if example.options or not example.is_quiet:
                self.close()

    def _run(self, example: Example, bench: TestbenchProcess, folder: Path) -> Outcome:
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
    deadline = time.monotonic() + (_LIMIT_S if example.but is None else _FUTILE_LIMIT_S)
    while time.monotonic() < deadline:
        if process.poll() is not None:
            return process.returncode == 0
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
