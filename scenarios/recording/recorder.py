"""Writes a run to an .rrd file that can be opened while it grows, and after a crash."""

from __future__ import annotations

import logging
import socket
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

import numpy as np
import rerun as rr
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.shapes import Primitive
from autonomy.model.quadrotor import Vector3
from flightsim.autopilot.events import Severity
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout
from scenarios.recording.blueprint import recording_blueprint
from scenarios.recording.columns import ExecutedPath, send_history
from scenarios.recording.frames import FrameLog
from scenarios.recording.metadata import RunInfo, log_run, log_verdict
from scenarios.recording.scene import log_scene
from scenarios.recording.series import log_legends
from scenarios.recording.status import StatusLog
from scenarios.recording.traffic import TrafficLog
from scenarios.recording.vehicle import log_vehicle

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.autopilot.autopilot import Autopilot
    from flightsim.plant import Plant
    from flightsim.sensors.camera import RgbdFrame

_log = logging.getLogger(__name__)

FLUSH_PERIOD_US = 1_000_000
"""Simulated time between two writes of the fast data."""
_LOOPBACK = "127.0.0.1"
_CLOSING_TIMEOUT_S = 30.0
_SERVER_MEMORY = "512MiB"
# A process that is killed while it writes a chunk leaves a file that needs mending: small chunks
# make that rare. One camera image is about this large.
_CHUNK_BYTES = 64 * 1024
_PLANNED_RGB, _EXECUTED_RGB = (255, 80, 200), (255, 235, 60)
_TOUCHDOWN_RGB, _TOUCHDOWN_RADIUS_M = (255, 255, 255), 0.08
_SAFE_RGB, _UNSAFE_RGB, _CELL_RADIUS_M = (60, 200, 90), (220, 50, 40), 0.025

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
    """A recording that cannot be written where it was asked for."""


class Recorder:
    """Records one run; call `on_tick` after every simulator tick and `close` at the end.

    What was recorded up to the last simulated second is in the file at any moment, whatever
    happens to this process.

    Attributes:
        path: The file; None where only a live viewer listens.
        url: Where a viewer can watch live; None unless a port was given.
    """

    def __init__(
        self,
        path: Path | None,
        *,
        scene: Scene,
        primitives: Iterable[Primitive],
        airframe: Airframe,
        info: RunInfo,
        serve_port: int | None = None,
    ) -> None:
        """Open the file, the live port or both, and write the scene.

        Args:
            path: The .rrd file; None records for live viewers only.
            scene: What is flown in.
            primitives: Its shapes, as the world was built of.
            airframe: What flies.
            info: Which run it is.
            serve_port: Loopback port on which viewers can watch live.

        Raises:
            RecordingError: If the file cannot be written or the port is taken.
        """
        self.path = path
        self.url: str | None = None
        self._info = info
        self._stream = rr.RecordingStream(
            layout.APPLICATION_ID,
            # Else all recordings of one process are one recording to the viewer.
            recording_id=uuid4(),
            batcher_config=rr.ChunkBatcherConfig(flush_num_bytes=_CHUNK_BYTES),
        )
        self._stream.set_log_time_enabled(False)
        try:
            self._stream.set_sinks(
                *self._open_sinks(serve_port),
                default_blueprint=recording_blueprint(scene, airframe),
            )
        except RuntimeError as error:
            raise RecordingError(
                f"recording {str(path)!r} cannot be written ({error}); valid: a file with room"
            ) from None
        self._is_open = True
        self._history: list[bytes] = []
        self._flush_due_us = FLUSH_PERIOD_US
        self._executed = ExecutedPath()
        log_run(self._stream, info)
        log_scene(self._stream, scene, primitives)
        log_vehicle(self._stream, airframe)
        log_legends(self._stream)
        self._log_styles()
        self._frames = FrameLog(self._stream)
        self._status = StatusLog(self._stream)
        self._traffic = TrafficLog(self._stream)

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

    def _log_styles(self) -> None:
        for entity, rgb in ((layout.PLANNED, _PLANNED_RGB), (layout.EXECUTED, _EXECUTED_RGB)):
            style = rr.LineStrips3D.from_fields(colors=rgb, radii=rr.Radius.ui_points(1.5))
            self._stream.log(entity, style, static=True)
        self._stream.log(layout.ESTIMATE, rr.TransformAxes3D(0.5), static=True)

    def on_tick(self, plant: Plant, autopilot: Autopilot) -> None:
        """Take in the last 20 ms."""
        # Bytes: numpy copies and joins records of many fields one field at a time.
        self._history.append(plant.history.tobytes())
        self._dtype = plant.history.dtype
        self._status.on_tick(plant, autopilot)
        self._traffic.on_tick(plant)
        if plant.time_us >= self._flush_due_us:
            self._flush_due_us = plant.time_us + FLUSH_PERIOD_US
            self.flush()

    def flush(self) -> None:
        """Write everything that waits."""
        if self._history:
            history = np.frombuffer(b"".join(self._history), self._dtype)
            self._history.clear()
            send_history(self._stream, history)
            self._executed.send(self._stream, history)
        self._status.flush()
        self._traffic.flush()

    def log_frame(self, frame: RgbdFrame) -> None:
        """Write a camera frame."""
        self._set_time(frame.time_us)
        self._frames.log(frame)

    def log_statustext(self, time_us: int, severity: Severity, text: str) -> None:
        """Write a line that the autopilot or the pilot said."""
        self._set_time(time_us)
        self._stream.log(layout.STATUSTEXT, rr.TextLog(text, level=_LEVELS[severity]))

    def log_plan(self, time_us: int, legs_enu_m: Sequence[Float[np.ndarray, "_ 3"]]) -> None:
        """Write what is planned from this time on: of each leg points along it, in order."""
        self._set_time(time_us)
        strips = [leg_enu_m.astype(np.float32) for leg_enu_m in legs_enu_m]
        self._stream.log(layout.PLANNED, rr.LineStrips3D.from_fields(strips=strips))

    def log_landing_map(
        self,
        time_us: int,
        cells_enu_m: Float[np.ndarray, "n 3"],
        cost: Float[np.ndarray, " n"],
        touchdown_enu_m: Vector3 | None = None,
    ) -> None:
        """Write what the pilot knows of the ground where it wants to land.

        Args:
            time_us: When it was known.
            cells_enu_m: Observed cells of the elevation map.
            cost: Of each cell, 0 safe to 1 unsafe.
            touchdown_enu_m: The point it chose, if it did.
        """
        self._set_time(time_us)
        share = np.clip(cost, 0.0, 1.0)[:, None]
        colours = (1 - share) * np.array(_SAFE_RGB) + share * np.array(_UNSAFE_RGB)
        cells = rr.Points3D(cells_enu_m, colors=colours.astype(np.uint8), radii=_CELL_RADIUS_M)
        self._stream.log(layout.LANDING_MAP, cells)
        if touchdown_enu_m is not None:
            point = rr.Points3D([touchdown_enu_m], colors=_TOUCHDOWN_RGB, radii=_TOUCHDOWN_RADIUS_M)
            self._stream.log(layout.TOUCHDOWN, point)

    def close(self, verdict: Mapping[str, Any] | None = None) -> None:
        """Write what waits and the verdict, and finish the file; a second call does nothing.

        Args:
            verdict: The figures of the run, as plain data.
        """
        if not self._is_open:
            return
        self._is_open = False
        self.flush()
        if verdict is not None:
            log_verdict(self._stream, self._info, verdict)
        try:
            self._stream.flush(timeout_sec=_CLOSING_TIMEOUT_S)
        except (RuntimeError, TimeoutError) as error:
            # A full disk must not take the verdict away with it.
            _log.warning("recording %s may lack its end: %s", self.path, error)
        self._stream.disconnect()

    def _set_time(self, time_us: int) -> None:
        self._stream.set_time(layout.TIMELINE, duration=np.timedelta64(time_us, "us"))

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
