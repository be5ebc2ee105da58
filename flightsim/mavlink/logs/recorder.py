"""Record of each flight from arming to disarming, with PX4's topics.

Logs stay in memory: clients read them over MAVLink, and a simulation leaves no files behind that
nobody asked for. The oldest ones are dropped.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from flightsim.autopilot.events import Severity
from flightsim.mavlink.hardware_uid import hardware_uid
from flightsim.mavlink.logs import ulog
from flightsim.mavlink.logs.topics import LOGGED, SENSOR_COMBINED, InertialPacker
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView

MAX_LOGS = 4
MAX_BYTES = 16 << 20
"""Most bytes of one log, a flight of some ten minutes; later samples are not kept."""

_TOPICS = (*(logged.topic for logged in LOGGED), SENSOR_COMBINED)
_INERTIAL_ID = len(LOGGED)
_LARGEST_SAMPLE_BYTES = 4096
"""Room that all messages of one tick fit into."""


@dataclass(kw_only=True)
class FlightLog:
    """One log.

    Attributes:
        started_us: Simulated time at which it began.
        data: Bytes so far.
    """

    started_us: int
    data: bytearray = field(default_factory=bytearray)

    @property
    def has_room(self) -> bool:
        """True if a sample of all topics may be added."""
        return len(self.data) + _LARGEST_SAMPLE_BYTES <= MAX_BYTES

    def append(self, more: bytes) -> None:
        """Add bytes while there is room for all of them."""
        if len(self.data) + len(more) <= MAX_BYTES:
            self.data += more


class FlightRecorder:
    """Keeps the logs of the latest flights in memory.

    Attributes:
        logs: Logs, the oldest first.
    """

    def __init__(self, view: VehicleView, statustext: StatustextSender) -> None:
        self._view = view
        self.logs: list[FlightLog] = []
        self._is_recording = False
        self._due_us = [0] * len(LOGGED)
        plant = view.plant
        self._inertial = InertialPacker(_INERTIAL_ID, plant.history, plant.tick_us)
        statustext.listeners.append(self._note)

    def update(self) -> None:
        """Begin, continue or end a log; call it once a tick."""
        is_armed = self._view.autopilot.is_armed
        if is_armed and not self._is_recording:
            self._begin()
        self._is_recording = is_armed
        if is_armed and self.logs[-1].has_room:
            self.logs[-1].data += b"".join(self._due())

    def _due(self) -> Iterator[bytes]:
        """Yield data messages of the topics that are due."""
        view = self._view
        time_us = view.time_us
        for message_id, logged in enumerate(LOGGED):
            if time_us >= self._due_us[message_id]:
                self._due_us[message_id] += 1000 * logged.interval_ms
                yield logged.topic.pack(message_id, time_us, *logged.sample(view))
        # Every sample of the inertial sensor belongs to the log, so it is packed in each tick.
        yield self._inertial.pack()

    def files(self) -> Mapping[str, bytearray]:
        """Return the logs as files, by their paths; one that is being written grows."""
        return {f"log/{number}.ulg": log.data for number, log in enumerate(self.logs)}

    def erase(self) -> None:
        """Drop all logs but one that is being written."""
        del self.logs[: -1 if self._is_recording else None]

    def _begin(self) -> None:
        view = self._view
        log = FlightLog(started_us=view.time_us)
        self._due_us = [view.time_us] * len(LOGGED)
        airframe = view.plant.world.airframe
        parameters = view.autopilot.parameters
        log.append(
            ulog.start(
                view.time_us,
                _TOPICS,
                {
                    "sys_name": "PX4",
                    "ver_hw": "AEROSCENE_SITL",
                    "sys_mcu": airframe.title,
                    "sys_uuid": hardware_uid(int(parameters["MAV_SYS_ID"])).hex(),
                },
                {name: parameters[name] for name in parameters},
            )
        )
        self.logs = [*self.logs, log][-MAX_LOGS:]

    def _note(self, severity: Severity, line: str) -> None:
        if self._is_recording:
            self.logs[-1].append(ulog.text(self._view.time_us, int(severity), line))
