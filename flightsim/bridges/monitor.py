"""Reports of an external flight stack by MAVLink: its estimate, mode, arming and texts.

The physics protocols carry motor outputs alone, and nothing about the stack's estimate or mode. The
monitor is therefore a MAVLink client like any ground station's, on a port of its own. By the same
port it sends the stack, ten times a second, the distances to obstacles around the vehicle, as a
sensor on board would.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from autonomy.types import State
from flightsim.autopilot.events import Severity
from flightsim.autopilot.modes import LandedState
from flightsim.bridges.pipes import Tap, Wire
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.client import Habits, MavlinkClient, Telemetry
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.mavlink.personalities import Personality
from flightsim.mavlink.ring_report import OBSTACLE_DISTANCE, RingReport
from flightsim.plant import Plant

_ASK_EVERY_US = 1_000_000  # once a second, as long as something is missing
_OBSTACLES_EVERY_US = 100_000
_STREAMS_HZ = {
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 50,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5,
}
_LANDED = {
    mavlink.MAV_LANDED_STATE_TAKEOFF: LandedState.TAKEOFF,
    mavlink.MAV_LANDED_STATE_IN_AIR: LandedState.IN_AIR,
    mavlink.MAV_LANDED_STATE_LANDING: LandedState.LANDING,
}


class ModeName(NamedTuple):
    """Name of a flight mode, of a stack that has modes of its own.

    It has a `value` as our `Mode` has, so that records and windows show either.
    """

    value: str


class Monitor:
    """MAVLink client on a port of the stack; call `update` after every 20 ms.

    Attributes:
        telemetry: Latest state that the stack has reported.
        listeners: Functions called with the severity and the text of each of its messages.
        failsafe: Always None; a stack reports a failsafe as a mode and in texts.
    """

    failsafe = None

    def __init__(
        self,
        wire: Wire,
        plant: Plant,
        frame: LocalFrame,
        *,
        names: Personality,
        habits: Habits,
        origin: Geodetic | None = None,
    ) -> None:
        """Prepare to listen; nothing is opened yet.

        Args:
            wire: Connection to the port; it is opened as soon as the stack is there.
            plant: Vehicle, which has the time and the obstacles.
            frame: Local frame of the scene.
            names: Our imitation of the stack, which knows the names of its modes.
            habits: Peculiarities of the stack that a client must know.
            origin: Place on earth from which its odometry counts, if it flies by odometry alone at
                first: it has no fix to find that by, so we send it. None otherwise.
        """
        self._wire, self._plant = wire, plant
        self._origin = origin
        self._taps: list[Tap] = []
        self._client = MavlinkClient(Tap(wire, self._taps), frame, habits=habits)
        # The client goes on changing this object, so it is always the latest.
        self.telemetry: Telemetry = self._client.telemetry
        self.listeners: list[Callable[[Severity, str], None]] = []
        # The first of several entries of a number is the preferred one.
        self._names = {
            entry.custom_mode: entry.title or entry.mode.value for entry in reversed(names.modes)
        }
        self._ask_due_us, self._asked_at_ms = 0, -1
        self._ring = RingReport(plant)
        self._obstacles_due_us, self._n_scans = 0, 0

    def tap(self) -> Tap:
        """Return a byte pipe to the stack for a companion, which shares this port."""
        return Tap(self._wire, self._taps)

    def update(self) -> None:
        """Read the messages that have come, ask for those that are missing, and send obstacles."""
        if not self._wire.open():
            return
        telemetry, time_us = self.telemetry, self._plant.time_us
        self._client.update(time_us)
        # A stack has an id as soon as it has been heard; before that nothing can be addressed to
        # it.
        if time_us >= self._ask_due_us and telemetry.system_id:
            self._ask_due_us = time_us + _ASK_EVERY_US
            # No position comes before the estimator is ready, nor from a stack that began anew.
            has_position = telemetry.position_time_ms not in {0, self._asked_at_ms}
            if has_position and self._origin is not None:
                self._client.send_origin(self._origin)
                self._origin = None
            if not has_position or telemetry.local_origin_enu_m is None:
                self._ask()
            self._asked_at_ms = telemetry.position_time_ms
        if telemetry.system_id and time_us >= self._obstacles_due_us:
            self._obstacles_due_us = time_us + _OBSTACLES_EVERY_US
            self._report_obstacles(self._ring.payload(time_us))  # as any sensor, not in lockstep
        for severity, text in telemetry.texts:
            for listener in self.listeners:
                listener(Severity(min(severity, Severity.DEBUG)), text)
        telemetry.texts.clear()

    def _report_obstacles(self, payload: bytes) -> None:
        """Send a scan of the distances all around, as a sensor of the vehicle does."""
        self._n_scans = (self._n_scans + 1) % 256
        # Under the stack's own system id, as from a part of its vehicle.
        sender = self.telemetry.system_id, mavlink.MAV_COMP_ID_OBSTACLE_AVOIDANCE
        self._wire.send(OBSTACLE_DISTANCE.frame_v2(payload, self._n_scans, *sender))

    def _ask(self) -> None:
        """Ask for the origin of its local frame, and for the streams that are recorded."""
        self._client.command(
            mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
        )
        for message_id, hz in _STREAMS_HZ.items():
            self._client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, 1e6 / hz)

    @property
    def estimate(self) -> State | None:
        """State that the stack believes in; None before it has reported any."""
        telemetry = self.telemetry
        if not telemetry.has_state:
            return None
        return State(
            time_us=self._plant.time_us,
            position_enu_m=telemetry.position_enu_m,
            velocity_enu_mps=telemetry.velocity_enu_mps,
            quat_wxyz=telemetry.quat_wxyz,
            angular_rate_flu_radps=telemetry.angular_rate_flu_radps,
        )

    @property
    def is_armed(self) -> bool:
        """True if the stack says that its rotors may turn."""
        return self.telemetry.is_armed

    @property
    def mode(self) -> ModeName:
        """Flight mode, by the name that the stack's users know."""
        if not self.telemetry.system_id:
            return ModeName("not heard yet")
        number = self.telemetry.custom_mode
        return ModeName(self._names.get(number, f"mode {number}"))

    @property
    def landed_state(self) -> LandedState:
        """Phase between ground and air; on the ground until the stack says otherwise."""
        return _LANDED.get(self.telemetry.landed_state, LandedState.ON_GROUND)

    def close(self) -> None:
        """Release the port."""
        self._wire.close()
