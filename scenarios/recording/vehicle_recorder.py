"""The recorder of one vehicle, which writes into the vehicle's part of the recording.

A state log has a row for every control tick, 250 a second. Writing each row at once would be slow
(see `columns`), so rows are kept as bytes and written once a simulated second. This period is also
the most that a killed run loses.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr

from aeroscene.scene import Scene
from flightsim.autopilot.events import Severity
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout
from scenarios.recording.columns import ExecutedPath, set_sim_time
from scenarios.recording.contact_log import log_contacts
from scenarios.recording.entity_stream import EntityStream
from scenarios.recording.lidar_log import log_scan
from scenarios.recording.plan_log import PlanLog
from scenarios.recording.state_log import StateLog

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.autopilot.reports import FlightReports
    from flightsim.cameras import RgbdFrame
    from flightsim.lidars import LidarScan
    from flightsim.plant import Plant

FLUSH_PERIOD_US = 1_000_000
"""Simulated time between two writes of the fast data."""
SUMMARY_FLUSH_PERIOD_US = 60_000_000
"""The same in a summary, whose few rows take less room than the overhead of each write."""
EXECUTED_RGB = (255, 235, 60)

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


class VehicleRecorder:
    """Records a vehicle; call `on_tick` after every simulator tick.

    Attributes:
        plans: Log of the plans.
        states: Log of the vehicle and its states; None in a summary.
    """

    def __init__(
        self,
        stream: EntityStream,
        scene: Scene,
        airframe: Airframe,
        *,
        is_summary: bool,
        has_traffic: bool,
    ) -> None:
        """Write the vehicle.

        Args:
            stream: Part of the recording that belongs to the vehicle.
            scene: Scene of the flight.
            airframe: Airframe of the vehicle.
            is_summary: True leaves out all states.
            has_traffic: True writes the movers of the world too.
        """
        self._stream = stream
        self._plant: Plant | None = None
        self._history: list[bytes] = []
        self._flush_period_us = SUMMARY_FLUSH_PERIOD_US if is_summary else FLUSH_PERIOD_US
        self._flush_due_us = self._flush_period_us
        self._executed = ExecutedPath()
        style = rr.LineStrips3D.from_fields(colors=EXECUTED_RGB, radii=rr.Radius.ui_points(1.5))
        stream.log(layout.EXECUTED, style, static=True)
        self.plans = PlanLog(stream)
        self.states: StateLog | None = None
        if not is_summary:
            self.states = StateLog(stream, scene, airframe, has_traffic=has_traffic)

    def on_tick(self, plant: Plant, autopilot: FlightReports | None = None) -> None:
        """Record the last 20 ms.

        Args:
            plant: Plant after the tick.
            autopilot: Reports of the flight stack; without one no modes are shown.
        """
        # As bytes, because numpy copies and joins records of many fields one field at a time.
        self._history.append(plant.history.tobytes())
        self._plant = plant
        if self.states is not None:
            self.states.on_tick(plant, autopilot)
        if plant.time_us >= self._flush_due_us:
            self._flush_due_us = plant.time_us + self._flush_period_us
            self.flush()

    def flush(self) -> None:
        """Write all buffered data, without waiting for the file."""
        if self._plant is not None and self._history:
            history = np.frombuffer(b"".join(self._history), self._plant.history.dtype)
            self._history.clear()
            self._executed.send(self._stream, history)
            if self.states is not None:
                self.states.send(self._plant, history)
        if self.states is not None:
            self.states.flush()

    def log_frame(self, frame: RgbdFrame, *, has_colour: bool = True) -> None:
        """Write a camera frame at its own time; a summary takes none.

        Args:
            frame: Frame of a camera.
            has_colour: False writes the depth alone.
        """
        if self.states is not None:
            set_sim_time(self._stream, frame.time_us)
            self.states.frames.log(frame, has_colour=has_colour)

    def log_scan(self, scan: LidarScan) -> None:
        """Write a scan of the lidar at its own time; a summary takes none."""
        if self.states is not None:
            set_sim_time(self._stream, scan.time_us)
            log_scan(self._stream, scan)

    def log_phase(self, time_us: int, phase: str) -> None:
        """Write the phase of the pilot, which holds from this time on.

        Args:
            time_us: Simulated time of the change.
            phase: Name of the phase.
        """
        set_sim_time(self._stream, time_us)
        self._stream.log(layout.PHASE, rr.StateChange(state=phase))

    def log_statustext(self, time_us: int, severity: Severity, text: str) -> None:
        """Write a message of the autopilot or the pilot.

        Args:
            time_us: Simulated time of the message.
            severity: Severity by MAVLink's scale, which becomes a log level of rerun's.
            text: Message.
        """
        set_sim_time(self._stream, time_us)
        self._stream.log(layout.STATUSTEXT, rr.TextLog(text, level=_LEVELS[severity]))

    def conclude(self, verdict: Mapping[str, Any]) -> None:
        """Write buffered data and the contacts of the flight.

        Args:
            verdict: Figures of the flight; "contacts" may be missing.
        """
        self.flush()
        log_contacts(self._stream, verdict.get("contacts", ()))

    def log_verdict(self, verdict: Mapping[str, Any]) -> None:
        """Write the figures of a vehicle after the first.

        The first one's are a property of the recording, see `metadata.log_verdict`.
        """
        figures = rr.AnyValues(figures=json.dumps(verdict, sort_keys=True))
        self._stream.log(layout.VERDICT, figures, static=True)
