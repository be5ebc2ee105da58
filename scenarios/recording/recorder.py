"""The recorder of a run, whose .rrd file can be opened while it grows, and after a crash.

The recorder opens file and live port, writes the scene once, and hands every vehicle's data to a
`VehicleRecorder`. It only reads the simulation, so a flight is the same bit for bit whether it is
recorded or not. A fault of the file, such as a full disk, is noted and never ends a flight.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

import rerun as rr

from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout
from scenarios.recording.blueprint import recording_blueprint
from scenarios.recording.entity_stream import VehicleStream
from scenarios.recording.legend import AREA_ROWS, FLIGHT_ROWS, log_legend
from scenarios.recording.metadata import RunInfo, log_document, log_run, log_verdict
from scenarios.recording.output import (
    CHUNK_BYTES,
    RecordingError,
    close_output,
    require_room,
    write_out,
)
from scenarios.recording.scene import log_scene
from scenarios.recording.vehicle_recorder import VehicleRecorder

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.autopilot.reports import FlightReports
    from flightsim.plant import Plant

_LOOPBACK = "127.0.0.1"
_SERVER_MEMORY = "512MiB"


class Recorder:
    """Records one run; call `on_tick` after every simulator tick and `close` at the end.

    At any moment the file holds everything up to the last simulated second, or the last minute in a
    summary, whatever happens to this process.

    Attributes:
        path: File of the recording; None if only a live viewer listens.
        url: Address at which a viewer can watch live; None unless a port was given.
        fault: Reason why the file lacks its end, such as a full disk; None if it is whole.
        first: Recorder of the vehicle, or of the first of several.
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
        other_vehicles: Mapping[str, Airframe] = MappingProxyType({}),
    ) -> None:
        """Open the file, the live port or both, and write the scene.

        Args:
            path: The .rrd file; None records for live viewers only.
            scene: Scene of the flight.
            primitives: Shapes of the scene, from which the world was built.
            airframe: Vehicle that flies.
            info: Identity of the run.
            goal_enu_m: Goal, in view together with the start; None shows all.
            serve_port: Loopback port on which viewers can watch live.
            is_summary: True keeps only the verdict, the configuration, the planned and the flown
                trajectory, the pilot's phases, texts and contacts.
            has_segments: True adds views of objects and classes, if camera frames will have them.
            other_vehicles: Other vehicles in the same world, by their names.

        Raises:
            RecordingError: If the file cannot be written or the port is taken.
        """
        self.path = path
        self.url: str | None = None
        self.fault: str | None = None
        self._info = info
        self._stream = _new_stream()
        blueprint = None
        if not is_summary:
            blueprint = recording_blueprint(
                scene,
                airframe,
                goal_enu_m,
                has_segments=has_segments,
                other_vehicles=other_vehicles,
            )
        self._stream.set_sinks(*self._open_sinks(serve_port), default_blueprint=blueprint)
        self._is_open = True
        log_run(self._stream, info, airframe)
        if not is_summary:
            log_document(self._stream, scene)
            log_scene(self._stream, scene, primitives)
            log_legend(self._stream, (*AREA_ROWS, *FLIGHT_ROWS))
        self.first = VehicleRecorder(
            self._stream, scene, airframe, is_summary=is_summary, has_traffic=True
        )
        recorder = partial(VehicleRecorder, is_summary=is_summary, has_traffic=False)
        self.other_vehicles = {
            name: recorder(VehicleStream(self._stream, name), scene, other)
            for name, other in other_vehicles.items()
        }
        """Recorder of each of the other vehicles, by their names."""

    def _open_sinks(self, serve_port: int | None) -> list[rr.FileSink | rr.GrpcServerSink]:
        sinks: list[rr.FileSink | rr.GrpcServerSink] = []
        if self.path is not None:
            require_room(self.path)
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
        """Record the last 20 ms of the first vehicle; see `VehicleRecorder.on_tick`."""
        self.first.on_tick(plant, autopilot)

    def flush(self) -> None:
        """Write all buffered data of all vehicles."""
        for vehicle in (self.first, *self.other_vehicles.values()):
            vehicle.flush()

    def conclude(
        self, verdict: Mapping[str, Any], other_results: Sequence[Mapping[str, Any]] = ()
    ) -> None:
        """Write buffered data and the run's figures, and finish the file if nobody watches live.

        Args:
            verdict: Verdict and figures of the vehicle, or of the first of several.
            other_results: Verdicts and figures of the other vehicles, in their order.
        """
        for vehicle, figures in zip(self.other_vehicles.values(), other_results, strict=False):
            vehicle.conclude(figures)
            vehicle.log_verdict(figures)
        self.flush()
        self.first.conclude(verdict)
        log_verdict(self._stream, self._info, verdict)
        self._write_out()
        # A viewer may stay open after the flight, and reads from this stream.
        if self.url is None:
            self.close()

    def close(self) -> None:
        """Write buffered data, finish the file, leave live viewers; a second call does nothing."""
        if not self._is_open:
            return
        self._is_open = False
        self.flush()
        self._write_out()
        close_output(self._stream, self.fault)

    def discard(self) -> None:
        """Remove the file, because a summary and pictures of the run may need its room."""
        self.close()
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def _write_out(self) -> None:
        """Wait until everything is in the file; note a full disk, and let the run continue."""
        # A later success must not hide an earlier fault.
        self.fault = write_out(self._stream, self.path) or self.fault

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _require_free(port: int) -> None:
    """Refuse a port that is taken, because the server itself would only log it."""
    # SO_REUSEADDR, because a port that was just released may still linger.
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((_LOOPBACK, port))
        except OSError as error:
            raise RecordingError(
                f"recording port {port} cannot be had ({error.strerror}); valid: a free TCP port"
            ) from None


def _new_stream() -> rr.RecordingStream:
    """Return a stream with an id of its own.

    Otherwise viewers take all recordings of one process for a single one.
    """
    stream = rr.RecordingStream(
        layout.APPLICATION_ID,
        recording_id=uuid4(),
        batcher_config=rr.ChunkBatcherConfig(flush_num_bytes=CHUNK_BYTES),
    )
    # rerun would otherwise add a second timeline of wall times.
    stream.set_log_time_enabled(False)
    return stream
