"""MAVLink companion client in lockstep with the simulation, over any byte pipe.

It speaks MAVLink 2 like any other onboard computer: it sends heartbeats, repeats commands until
they are acknowledged, and streams setpoints. Its only clock is the simulated time passed to
`update`. It uses the server's dialect, because loading another one takes a tenth of a second.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

from autonomy.types import LEVEL, FlatReference, Quaternion, Vector3
from flightsim.frames import (
    Geodetic,
    LocalFrame,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
    swap_yaw_enu_ned,
)
from flightsim.mavlink.client.habits import PX4_HABITS, Habits
from flightsim.mavlink.client.telemetry import Telemetry, TelemetryReader
from flightsim.mavlink.dialect import dialect as mavlink

_HEARTBEAT_PERIOD_US = 1_000_000
# Silence after which a command is sent again, also after the vehicle has reported progress.
_ACK_TIMEOUT_US = 500_000
_PROGRESS_TIMEOUT_US = 5_000_000
_TRIES = 5
_FORCE_MAGIC = 21196
"""Second parameter of the command to arm or disarm that forces it, as MAVLink defines it."""
_AUTOPILOT_COMPONENT = 1
_VELOCITY_ALONE = (
    mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE
)
_POSITION_ALONE = (
    mavlink.POSITION_TARGET_TYPEMASK_VX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE
)
_UNKNOWN_VARIANCE = 1e6  # so large that no filter uses the value
_VARIANCES = dict.fromkeys((11, 15, 18, 20), _UNKNOWN_VARIANCE)
"""Indexes of height and attitude in the upper triangle of a 6 by 6 covariance, with their
variances."""


class BytePipe(Protocol):
    """Bidirectional pipe for MAVLink frames; neither end blocks."""

    def send(self, data: bytes) -> None:
        """Send bytes to the vehicle."""
        ...

    def recv(self) -> bytes:
        """Return all bytes received since the last call, possibly none."""
        ...


class CommandState(Enum):
    """Progress of a command."""

    PENDING = "pending"
    ACCEPTED = "accepted"
    REFUSED = "refused"
    UNANSWERED = "unanswered"


@dataclass(kw_only=True, slots=True)
class Command:
    """A COMMAND_LONG and the state of its delivery."""

    command: int
    params: tuple[float, ...]
    state: CommandState = CommandState.PENDING
    result: int | None = None
    """MAV_RESULT of the acknowledgement."""
    tries: int = 0
    due_us: int = 0

    @property
    def is_done(self) -> bool:
        """True if the command has reached its final state."""
        return self.state is not CommandState.PENDING

    @property
    def is_accepted(self) -> bool:
        """True if the vehicle accepted the command."""
        return self.state is CommandState.ACCEPTED

    def outcome(self) -> str:
        """Return the result in words: MAVLink's name of it, or the state without an answer."""
        if self.result is None:
            return self.state.value
        return mavlink.enums["MAV_RESULT"][self.result].name.removeprefix("MAV_RESULT_").lower()


class MavlinkClient:
    """One companion computer; call `update` once per tick.

    Attributes:
        telemetry: Latest state reported by the vehicle.
        habits: Numbers and customs of its flight stack.
    """

    def __init__(self, pipe: BytePipe, frame: LocalFrame, *, habits: Habits = PX4_HABITS) -> None:
        """Prepare a connection; nothing is sent before the first `update`.

        Args:
            pipe: Connection to the vehicle.
            frame: Local frame of the scene, used by `telemetry` and by setpoints.
            habits: Numbers and customs of the vehicle's flight stack.
        """
        self._pipe = pipe
        self.habits = habits
        self._mav = mavlink.MAVLink(
            None, srcSystem=1, srcComponent=mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
        )
        self._mav.robust_parsing = True
        self._reader = TelemetryReader(frame, habits)
        self.telemetry: Telemetry = self._reader.telemetry
        self._time_us = 0
        self._heartbeat_due_us = 0
        self._commands: list[Command] = []

    def update(self, time_us: int) -> None:
        """Read messages, send heartbeats and repeat unacknowledged commands.

        Args:
            time_us: Simulated time.
        """
        self._time_us = time_us
        for message in self._mav.parse_buffer(self._pipe.recv()) or ():
            if not self._reader.is_of_vehicle(message):
                continue
            if message.get_type() == "COMMAND_ACK":
                self._on_ack(message)
            else:
                self._reader.read(message)
        if time_us >= self._heartbeat_due_us:
            self._heartbeat_due_us = time_us + _HEARTBEAT_PERIOD_US
            self._send_heartbeat()
        # Acknowledgements identify commands by number only: send one of each number at a time.
        # Reversed, so that the oldest of each number stays in the dictionary.
        first_of_kind = {command.command: command for command in reversed(self._commands)}
        for command in first_of_kind.values():
            self._press(command)
        self._commands = [command for command in self._commands if not command.is_done]

    def command(self, command: int, *params: float) -> Command:
        """Send a command, repeated until the vehicle answers.

        Args:
            command: Number of the command.
            params: Its parameters from the first on; the rest are unused.

        Returns:
            The command, whose state changes with later calls of `update`.
        """
        padded = (*params, *[self.habits.unused] * (7 - len(params)))
        pending = Command(command=command, params=padded)
        self._commands.append(pending)
        return pending

    def request_streams(self, *, is_quiet: bool = False) -> list[Command]:
        """Request the frame's origin and the messages a companion steers by; stop all others.

        Args:
            is_quiet: True stops all but heartbeats, for a companion that knows the state by itself.
        """
        origin = self.command(
            mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
        )
        steered_by = {} if is_quiet else self.habits.streams_hz
        silenced = (
            {*self.habits.streams_hz} - {mavlink.MAVLINK_MSG_ID_HEARTBEAT} if is_quiet else ()
        )
        wanted = [(message_id, 1e6 / hz) for message_id, hz in steered_by.items()]
        unwanted = [(message_id, -1.0) for message_id in (*self.habits.unwanted, *sorted(silenced))]
        return [
            origin,
            *(
                self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, interval_us)
                for message_id, interval_us in (*wanted, *unwanted)
            ),
        ]

    def set_mode(self, custom_mode: int) -> Command:
        """Change the flight mode; see `PX4_OFFBOARD` and the other modes."""
        main, sub = (custom_mode >> shift & 0xFF for shift in self.habits.mode_shifts)
        return self.command(
            mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, main, sub
        )

    def take_off(self, height_m: float) -> Command:
        """Rise to a height above home (m), where the vehicle then waits."""
        unused = self.habits.unused
        return self.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, unused, unused, unused, height_m)

    def arm(self) -> Command:
        """Start the rotors; the vehicle refuses while a check forbids it."""
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    def disarm(self, *, is_forced: bool = False) -> Command:
        """Stop the rotors; refused in the air unless it is forced."""
        magic = (_FORCE_MAGIC,) if is_forced else ()
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, *magic)

    def send_setpoint(self, reference: FlatReference) -> None:
        """Send one offboard setpoint: position, velocity, acceleration and heading.

        Nothing is sent before the origin of MAVLink's local frame is known.

        Args:
            reference: The reference in the scene's frame.
        """
        origin = self.telemetry.local_origin_enu_m
        if origin is None:
            return
        x, y, z = reference.position_enu_m
        self._send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                self._time_us // 1000,
                self.telemetry.system_id,
                _AUTOPILOT_COMPONENT,
                mavlink.MAV_FRAME_LOCAL_NED,
                0,
                *swap_enu_ned((x - origin[0], y - origin[1], z - origin[2])),
                *swap_enu_ned(reference.velocity_enu_mps),
                *swap_enu_ned(reference.acceleration_enu_mps2),
                swap_yaw_enu_ned(reference.yaw_rad),
                -reference.yaw_rate_radps,
            )
        )

    def send_velocity(self, velocity_enu_mps: Vector3, yaw_rate_radps: float) -> None:
        """Send one offboard setpoint of velocity and yaw rate alone.

        Args:
            velocity_enu_mps: Velocity, ENU.
            yaw_rate_radps: Rate of the heading, counter-clockwise.
        """
        self._send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                self._time_us // 1000,
                self.telemetry.system_id,
                _AUTOPILOT_COMPONENT,
                mavlink.MAV_FRAME_LOCAL_NED,
                _VELOCITY_ALONE,
                *(0.0, 0.0, 0.0),
                *swap_enu_ned(velocity_enu_mps),
                *(0.0, 0.0, 0.0),
                0.0,
                -yaw_rate_radps,
            )
        )

    def send_position(self, position_enu_m: Vector3, yaw_rate_radps: float) -> None:
        """Send one offboard setpoint of position and yaw rate alone.

        Nothing is sent before the origin of MAVLink's local frame is known.

        Args:
            position_enu_m: Position in the scene's frame.
            yaw_rate_radps: Rate of the heading, counter-clockwise.
        """
        origin = self.telemetry.local_origin_enu_m
        if origin is None:
            return
        x, y, z = position_enu_m
        self._send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                self._time_us // 1000,
                self.telemetry.system_id,
                _AUTOPILOT_COMPONENT,
                mavlink.MAV_FRAME_LOCAL_NED,
                _POSITION_ALONE,
                *swap_enu_ned((x - origin[0], y - origin[1], z - origin[2])),
                *(0.0, 0.0, 0.0),
                *(0.0, 0.0, 0.0),
                0.0,
                -yaw_rate_radps,
            )
        )

    def send_attitude(
        self,
        quat_wxyz: Quaternion | None,
        angular_rate_flu_radps: Vector3,
        thrust: float,
    ) -> None:
        """Send one offboard setpoint of attitude, or of angular rates alone.

        Args:
            quat_wxyz: Attitude from FLU to ENU; None commands the rates alone.
            angular_rate_flu_radps: Angular rates; feed-forward beside an attitude.
            thrust: Collective thrust as a fraction of the maximum, 0 to 1.
        """
        mask = 0 if quat_wxyz is not None else mavlink.ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE
        self._send(
            mavlink.MAVLink_set_attitude_target_message(
                self._time_us // 1000,
                self.telemetry.system_id,
                _AUTOPILOT_COMPONENT,
                mask,
                swap_quat_enu_flu_ned_frd(LEVEL if quat_wxyz is None else quat_wxyz),
                *swap_flu_frd(angular_rate_flu_radps),
                thrust,
            )
        )

    def send_origin(self, place: Geodetic) -> None:
        """Send a vehicle without a receiver the place on earth of its local frame's origin."""
        self._send(
            mavlink.MAVLink_set_gps_global_origin_message(
                self.telemetry.system_id,
                round(place.latitude_deg * 1e7),
                round(place.longitude_deg * 1e7),
                round(place.altitude_m * 1e3),
                self._time_us,
            )
        )

    def send_place(self, position_enu_m: Vector3, yaw_rad: float, sigma_m: float) -> None:
        """Send the autopilot its present horizontal position, as a companion's vision sees it.

        Args:
            position_enu_m: Position; its height is not to be used.
            yaw_rad: Heading, which is not to be used either.
            sigma_m: Standard deviation of each horizontal axis.
        """
        origin = self.telemetry.local_origin_enu_m
        if origin is None:
            return
        x, y, z = position_enu_m
        covariance = [0.0] * 21
        for place, variance in _VARIANCES.items():
            covariance[place] = variance
        # Places of east and north in the upper triangle.
        covariance[0] = covariance[6] = sigma_m * sigma_m
        self._send(
            mavlink.MAVLink_vision_position_estimate_message(
                self._time_us,
                *swap_enu_ned((x - origin[0], y - origin[1], z - origin[2])),
                0.0,
                0.0,
                swap_yaw_enu_ned(yaw_rad),
                covariance,
            )
        )

    def _send(self, message: Any) -> None:
        self._pipe.send(message.pack(self._mav))
        self._mav.seq = (self._mav.seq + 1) % 256

    def _send_heartbeat(self) -> None:
        self._send(
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
                mavlink.MAV_AUTOPILOT_INVALID,
                0,
                0,
                mavlink.MAV_STATE_ACTIVE,
                3,
            )
        )

    def _press(self, command: Command) -> None:
        """Send a pending command if it is due."""
        # Before the first heartbeat nobody can be addressed.
        if command.is_done or self._time_us < command.due_us or not self.telemetry.system_id:
            return
        if command.tries == _TRIES:
            command.state = CommandState.UNANSWERED
            return
        self._send(
            mavlink.MAVLink_command_long_message(
                self.telemetry.system_id,
                _AUTOPILOT_COMPONENT,
                command.command,
                command.tries,  # MAVLink's "confirmation" counts repetitions
                *command.params,
            )
        )
        command.tries += 1
        command.due_us = self._time_us + _ACK_TIMEOUT_US

    def _on_ack(self, ack: Any) -> None:
        for command in self._commands:
            # Commands that were never sent cannot be meant.
            if command.command != ack.command or not command.tries or command.is_done:
                continue
            if ack.result == mavlink.MAV_RESULT_IN_PROGRESS:
                command.due_us = self._time_us + _PROGRESS_TIMEOUT_US
                return
            command.result = ack.result
            is_accepted = ack.result == mavlink.MAV_RESULT_ACCEPTED
            command.state = CommandState.ACCEPTED if is_accepted else CommandState.REFUSED
            return
