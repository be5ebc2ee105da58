"""Record of each flight from arming to disarming, as PX4's topics name what is in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from flightsim.autopilot.events import Severity
from flightsim.autopilot.modes import LandedState, Mode
from flightsim.frames import euler_rpy_rad
from flightsim.mavlink.logs import ulog
from flightsim.mavlink.logs.ulog import Topic
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView

MAX_LOGS = 4
MAX_BYTES = 2 << 20
"""Bytes of one log, a flight of some twenty minutes; what comes after is not kept."""
_EVERY = 5
"""Ticks between two samples: 0.1 s."""

_POSITION = Topic(
    "vehicle_local_position",
    *(f"float {name}" for name in ("x", "y", "z", "vx", "vy", "vz", "heading")),
)
_ATTITUDE = Topic("vehicle_attitude", "float[4] q")
_RATES = Topic("vehicle_angular_velocity", "float[3] xyz")
_GPS = Topic(
    "vehicle_gps_position",
    *("int32_t lat", "int32_t lon", "int32_t alt", "float eph", "float epv"),
    *("uint8_t fix_type", "uint8_t satellites_used"),
)
_BATTERY = Topic(
    "battery_status",
    *(f"float {name}" for name in ("voltage_v", "current_a", "discharged_mah", "remaining")),
)
_STATUS = Topic("vehicle_status", "uint8_t nav_state", "uint8_t arming_state", "bool failsafe")
_LANDED = Topic("vehicle_land_detected", "bool landed")
_TOPICS = (_POSITION, _ATTITUDE, _RATES, _GPS, _BATTERY, _STATUS, _LANDED)
_SAMPLE_BYTES = sum(topic.size for topic in _TOPICS)

# PX4's vehicle_status.msg, v1.15.
_NAV_STATES = {
    Mode.MANUAL: 0,
    Mode.ALTITUDE: 1,
    Mode.POSITION: 2,
    Mode.MISSION: 3,
    Mode.HOLD: 4,
    Mode.RETURN: 5,
    Mode.ACRO: 10,
    Mode.DESCEND: 12,
    Mode.TERMINATION: 13,
    Mode.OFFBOARD: 14,
    Mode.STABILIZED: 15,
    Mode.TAKEOFF: 17,
    Mode.LAND: 18,
    Mode.FOLLOW: 19,
    Mode.PRECISION_LAND: 20,
    Mode.ORBIT: 21,
}
_ARMED = 2


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
        """Whether a sample of all topics may be added."""
        return len(self.data) + _SAMPLE_BYTES <= MAX_BYTES

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
        self._n_ticks = 0
        statustext.listeners.append(self._note)

    def update(self) -> None:
        """Begin, continue or end a log; call once a tick."""
        is_armed = self._view.autopilot.is_armed
        if is_armed and not self._is_recording:
            self._begin()
        self._is_recording = is_armed
        if is_armed and self._n_ticks % _EVERY == 0 and self.logs[-1].has_room:
            time_us, samples = self._view.time_us, zip(_TOPICS, self._samples(), strict=True)
            self.logs[-1].data += b"".join(
                topic.pack(message_id, time_us, *values)
                for message_id, (topic, values) in enumerate(samples)
            )
        self._n_ticks += 1

    def files(self) -> Mapping[str, bytearray]:
        """The logs as files, by their paths; one that is being written grows."""
        return {f"log/{number}.ulg": log.data for number, log in enumerate(self.logs)}

    def erase(self) -> None:
        """Drop all logs but one that is being written."""
        del self.logs[: -1 if self._is_recording else None]

    def _begin(self) -> None:
        view = self._view
        log = FlightLog(started_us=view.time_us)
        airframe = view.plant.world.airframe
        parameters = view.autopilot.parameters
        log.append(
            ulog.start(
                view.time_us,
                _TOPICS,
                {"sys_name": "PX4", "ver_hw": "AEROSCENE_SITL", "sys_mcu": airframe.title},
                {name: parameters[name] for name in parameters},
            )
        )
        self.logs = [*self.logs, log][-MAX_LOGS:]

    def _note(self, severity: Severity, line: str) -> None:
        if self._is_recording:
            self.logs[-1].append(ulog.text(self._view.time_us, int(severity), line))

    def _samples(self) -> Sequence[Sequence[float]]:
        """Values of each topic at this tick."""
        view, autopilot = self._view, self._view.autopilot
        gnss, battery = view.plant.sensors.gnss, autopilot.battery
        place, quat = view.frame.geodetic_from_enu(gnss.position_enu_m), view.quat_ned_frd
        return (
            (*view.position_ned_m, *view.velocity_ned_mps, euler_rpy_rad(quat)[2]),
            quat,
            view.rates_frd_radps,
            (
                round(place.latitude_deg * 1e7),
                round(place.longitude_deg * 1e7),
                round(place.altitude_m * 1e3),
                *(gnss.eph_m, gnss.epv_m, gnss.fix_type, min(255, gnss.n_satellites)),
            ),
            (battery.voltage_v, battery.current_a, battery.consumed_mah, battery.remaining),
            (_NAV_STATES[autopilot.mode], _ARMED, autopilot.failsafe is not None),
            (autopilot.landed_state is LandedState.ON_GROUND,),
        )
