"""Shape and states of a vehicle in a recording: everything that a summary leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from aeroscene.scene import Scene
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout
from scenarios.recording.chase_log import ChaseLog
from scenarios.recording.columns import send_history
from scenarios.recording.entity_stream import EntityStream
from scenarios.recording.flow_log import FlowLog
from scenarios.recording.frames import FrameLog
from scenarios.recording.landing_log import LandingLog
from scenarios.recording.series import log_legends
from scenarios.recording.status import StatusLog
from scenarios.recording.track_log import TrackLog
from scenarios.recording.traffic import TrafficLog
from scenarios.recording.vehicle import log_vehicle

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.autopilot.reports import FlightReports
    from flightsim.plant import Plant


class StateLog:
    """Writes the vehicle's shape at once, and its states in stretches of simulated time.

    Attributes:
        frames: Log of the camera frames.
        landing: Log of the landing map.
        tracks: Log of the tracked movers.
    """

    def __init__(
        self,
        stream: EntityStream,
        scene: Scene,
        airframe: Airframe,
        *,
        has_traffic: bool,
    ) -> None:
        self._stream = stream
        log_vehicle(stream, airframe)
        log_legends(stream, len(airframe.quadrotor.rotors))
        stream.log(layout.ESTIMATE, rr.TransformAxes3D(0.5), static=True)
        self._status = StatusLog(stream)
        self._traffic = TrafficLog(stream) if has_traffic else None
        self._chase = ChaseLog(stream)
        self._flow = FlowLog(stream)
        self.frames = FrameLog(stream, scene)
        self.landing = LandingLog(stream)
        self.tracks = TrackLog(stream)

    def on_tick(self, plant: Plant, autopilot: FlightReports | None) -> None:
        """Sample the quantities that are no part of `Plant.history`.

        Args:
            plant: Plant after the tick.
            autopilot: Reports of the flight stack; None if there is none.
        """
        self._status.on_tick(plant, autopilot)
        self._flow.on_tick(plant)
        if self._traffic is not None:
            self._traffic.on_tick(plant)

    def send(self, plant: Plant, history: np.ndarray) -> None:
        """Write a stretch of history.

        Args:
            plant: Plant of the vehicle, for its world.
            history: Rows of `Plant.history`, oldest first, that continue those of the last call.
        """
        send_history(self._stream, history)
        self._chase.send(plant.world, history)

    def flush(self) -> None:
        """Write the buffered samples."""
        self._status.flush()
        self._flow.flush()
        if self._traffic is not None:
            self._traffic.flush()
