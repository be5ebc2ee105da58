"""Writes a run to an .rrd file that can be opened while it grows, and after a crash."""

from __future__ import annotations

import socket
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

import numpy as np
import rerun as rr

from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive
from autonomy.types import Vector3
from flightsim.autopilot.events import Severity
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout
from scenarios.recording.blueprint import recording_blueprint
from scenarios.recording.columns import ExecutedPath, set_sim_time
from scenarios.recording.contact_log import log_contacts
from scenarios.recording.lidar_log import log_scan
from scenarios.recording.metadata import RunInfo, log_run, log_verdict
from scenarios.recording.plan_log import PlanLog
from scenarios.recording.state_log import StateLog

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.autopilot.reports import FlightReports
    from flightsim.plant import Plant
    from flightsim.sensors.cameras import RgbdFrame
    from flightsim.sensors.lidars import LidarScan

FLUSH_PERIOD_US = 1_000_000
"""Simulated time between two writes of the fast data."""
SUMMARY_FLUSH_PERIOD_US = 60_000_000
"""The same in a summary, which each write makes larger by several times what it holds."""
_LOOPBACK = "127.0.0.1"
_CLOSING_TIMEOUT_S = 30.0
_SERVER_MEMORY = "512MiB"
# A process that is killed while it writes a chunk leaves a file that needs mending: small chunks
# make that rare. One camera image is about this large.
_CHUNK_BYTES = 64 * 1024
_EXECUTED_RGB = (255, 235, 60)

_LEVELS: Mapping[Severity, rr.TextLogLevel] = {
    Severity.EMERGENCY: rr.TextLogLevel.CRITICAL,
    Severity.ALERT: rr.TextLogLevel.CRITICAL,
    Severity.CRITICAL: rr.TextLogLevel.CRITICAL,
    Severity.ERROR: rr.TextLogLevel.ERROR,
    Severity.WARNING: rr.TextLogLevel.WARN,
    Severity.NOTICE: rr.TextLogLevel.INFO,
    Severity.INFO: rr.TextLogLevel.INFO,
    Severity.DEBUG: rr.TextLogLevel.DEBUG,
}


class RecordingError(OSError):
    """The recording cannot be written to the given path or port."""


class Recorder:
    """Records one run; call `on_tick` after every simulator tick and `close` at the end.

    What was recorded up to the last simulated second, in a summary the last minute, is in the file
    at any moment, whatever happens to this process.

    Attributes:
        path: File of the recording; None where only a live viewer listens.
        url: Address at which a viewer can watch live; None unless a port was given.
        fault: Reason for which the file may lack its end, such as a full disk; None if it is whole.
        plans: Log of the plans.
        states: Log of scene, vehicle and states; None in a summary.
    """

    def __init__(
        self,
        path: Path | None,
        *,
        scene: Scene,
        primitives: Iterable[Primitive],
        airframe: Airframe,
        info: RunInfo,
        goal_enu_m: Vector3 | None = None,
        serve_port: int | None = None,
        is_summary: bool = False,
        has_segments: bool = False,
    ) -> None:
        """Open the file, the live port or both, and write the scene.

        Args:
            path: The .rrd file; None records for live viewers only.
            scene: Scene of the flight.
            primitives: Shapes of the scene, of which the world was built.
            airframe: Vehicle that flies.
            info: Identity of the run.
            goal_enu_m: Goal, in view together with the start; None shows all.
            serve_port: Loopback port on which viewers can watch live.
            is_summary: Whether to keep only the verdict, the configuration, the planned and the
                flown trajectory, the pilot's phases, texts and contacts.
            has_segments: Whether camera frames will have objects and classes, to be in view.

        Raises:
            RecordingError: If the file cannot be written or the port is taken.
        """
        self.path = path
        self.url: str | None = None
        self.fault: str | None = None
        self._info = info
        self._stream = _new_stream()
        try:
            self._stream.set_sinks(
                *self._open_sinks(serve_port),
                default_blueprint=None
                if is_summary
                else recording_blueprint(scene, airframe, goal_enu_m, has_segments=has_segments),
            )
        except RuntimeError as error:
            raise RecordingError(
                f"recording {str(path)!r} cannot be written ({error}); valid: a file with room"
            ) from None
        self._is_open = True
        self._plant: Plant | None = None
        self._history: list[bytes] = []
        self._flush_period_us = SUMMARY_FLUSH_PERIOD_US if is_summary else FLUSH_PERIOD_US
        self._flush_due_us = self._flush_period_us
        self._executed = ExecutedPath()
        log_run(self._stream, info, airframe)
        style = rr.LineStrips3D.from_fields(colors=_EXECUTED_RGB, radii=rr.Radius.ui_points(1.5))
        self._stream.log(layout.EXECUTED, style, static=True)
        self.plans = PlanLog(self._stream)
        self.states: StateLog | None = None
        if not is_summary:
            self.states = StateLog(self._stream, scene, primitives, airframe)

    def _open_sinks(self, serve_port: int | None) -> list[rr.FileSink | rr.GrpcServerSink]:
        sinks: list[rr.FileSink | rr.GrpcServerSink] = []
        if self.path is not None:
            _require_writable(self.path)
            sinks.append(rr.FileSink(self.path))
        if serve_port is not None:
            _require_free(serve_port)
            server = rr.GrpcServerSink(
                bind_ip=_LOOPBACK, port=serve_port, server_memory_limit=_SERVER_MEMORY
            )
            self.url = server.uri
            sinks.append(server)
        return sinks

    def on_tick(self, plant: Plant, autopilot: FlightReports | None = None) -> None:
        """Record the last 20 ms; without an autopilot there are no modes to show."""
        # Bytes: numpy copies and joins records of many fields one field at a time.
        self._history.append(plant.history.tobytes())
        self._plant = plant
        if self.states is not None:
            self.states.on_tick(plant, autopilot)
        if plant.time_us >= self._flush_due_us:
            self._flush_due_us = plant.time_us + self._flush_period_us
            self.flush()

    def flush(self) -> None:
        """Write all buffered data."""
        if self._plant is not None and self._history:
            history = np.frombuffer(b"".join(self._history), self._plant.history.dtype)
            self._history.clear()
            self._executed.send(self._stream, history)
            if self.states is not None:
                self.states.send(self._plant, history)
        if self.states is not None:
            self.states.flush()

    def log_frame(self, frame: RgbdFrame, *, has_colour: bool = True) -> None:
        """Write a camera frame, or its depth alone; a summary takes none."""
        if self.states is not None:
            set_sim_time(self._stream, frame.time_us)
            self.states.frames.log(frame, has_colour=has_colour)

    def log_scan(self, scan: LidarScan) -> None:
        """Write a scan of the lidar; a summary takes none."""
        if self.states is not None:
            set_sim_time(self._stream, scan.time_us)
            log_scan(self._stream, scan)

    def log_phase(self, time_us: int, phase: str) -> None:
        """Write the phase of the pilot from this time on."""
        set_sim_time(self._stream, time_us)
        self._stream.log(layout.PHASE, rr.StateChange(state=phase))

    def log_statustext(self, time_us: int, severity: Severity, text: str) -> None:
        """Write a message of the autopilot or the pilot."""
        set_sim_time(self._stream, time_us)
        self._stream.log(layout.STATUSTEXT, rr.TextLog(text, level=_LEVELS[severity]))

    def conclude(self, verdict: Mapping[str, Any]) -> None:
        """Write buffered data and the run's figures; without live viewers finish the file too."""
        self.flush()
        log_contacts(self._stream, verdict.get("contacts", ()))
        log_verdict(self._stream, self._info, verdict)
        self._write_out()
        if self.url is None:
            self.close()

    def close(self) -> None:
        """Write buffered data, finish the file, leave live viewers; a second call does nothing."""
        if not self._is_open:
            return
        self._is_open = False
        self.flush()
        self._write_out()
        self._stream.disconnect()

    def _write_out(self) -> None:
        """Wait until all is in the file; a full disk is noted and costs the run nothing else."""
        try:
            self._stream.flush(timeout_sec=_CLOSING_TIMEOUT_S)
        except (RuntimeError, TimeoutError) as error:
            self.fault = str(error)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _require_free(port: int) -> None:
    """Refuse a port that is taken; the server itself would only log it."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((_LOOPBACK, port))
        except OSError as error:
            raise RecordingError(
                f"recording port {port} cannot be had ({error.strerror}); valid: a free TCP port"
            ) from None


def _require_writable(path: Path) -> None:
    """Refuse a path that no file can be written to, before the sink fails behind the scenes."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb"):
            pass
    except OSError as error:
        raise RecordingError(
            f"recording {str(path)!r} cannot be written ({error.strerror}); "
            "valid: a file in a folder you may write to"
        ) from None


def _new_stream() -> rr.RecordingStream:
    """A stream with an id of its own: else viewers take all of one process for one recording."""
    stream = rr.RecordingStream(
        layout.APPLICATION_ID,
        recording_id=uuid4(),
        batcher_config=rr.ChunkBatcherConfig(flush_num_bytes=_CHUNK_BYTES),
    )
    stream.set_log_time_enabled(False)
    return stream
