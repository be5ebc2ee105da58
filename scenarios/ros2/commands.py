"""Commands that nodes send to a vehicle, passed on by MAVLink like those of any companion.

Commands take the way of a real companion computer, because a door of its own into the autopilot
would skip the checks and failsafes that users want to test. A stream of set points takes the
vehicle into OFFBOARD once, when it begins. If a failsafe or a pilot changes the mode afterwards,
the door does not take it back.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from typing import Any

from autonomy.types import FlatReference, Vector3, yaw_of
from flightsim.mavlink.client import Command, MavlinkClient
from scenarios.ros2.frames import BASE, MAP, ODOM
from scenarios.ros2.topics import Topics
from scenarios.ros2.transport import STATE, Inlet, Kind, Service, Transport

_LOG = logging.getLogger(__name__)
_STREAM_GAP_US = 500_000
"""Pause after which a stream of set points has ended. PX4 asks for at least 2 Hz."""
_RETRY_US = 200_000  # between two requests for OFFBOARD
# Hashes of std_srvs/srv/SetBool and Trigger; tests compute them with another library.
SET_BOOL = Kind(
    name="std_srvs/srv/SetBool",
    type_hash="RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
)
TRIGGER = Kind(
    name="std_srvs/srv/Trigger",
    type_hash="RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
)


class Commands:
    """Listens to the commands of one vehicle; call `on_tick` after each tick."""

    def __init__(
        self,
        topics: Topics,
        transport: Transport,
        connect: Callable[[], MavlinkClient],
    ) -> None:
        """Listen from now on.

        Args:
            topics: Topics of the vehicle.
            transport: Transport that the commands come by.
            connect: Function that connects a companion to the vehicle. It is called with the first
                command, so that nodes which only watch add no companion.
        """
        self._ros, self._connect = topics.ros, connect
        self._client: MavlinkClient | None = None
        # Frames of set points, and whether they turn with the heading. No frame means the body's.
        self._frames = {topics.frame(BASE): True, MAP: False, topics.frame(ODOM): False, "": True}
        self._inlets: list[tuple[Inlet, str, Callable[[Any], object]]] = [
            (transport.inlet(topics.name(topic), topics.kind(kind), STATE), kind, act)
            for topic, kind, act in (
                ("cmd_vel", "geometry_msgs/TwistStamped", self._on_twist),
                ("command/trajectory", "trajectory_msgs/MultiDOFJointTrajectory", self._on_points),
                ("command/arm", "std_msgs/Bool", lambda m: self._arm(is_armed=m.data)),
                ("command/land", "std_msgs/Empty", lambda _: self._land()),
            )
        ]
        self._services: list[tuple[Service, str, str, Callable[[Any], Command]]] = [
            (
                transport.service(topics.name("arm"), SET_BOOL),
                "SetBool",
                "arm",
                lambda m: self._arm(is_armed=m.data),
            ),
            (
                transport.service(topics.name("land"), TRIGGER),
                "Trigger",
                "land",
                lambda _: self._land(),
            ),
        ]
        self._waiting: list[tuple[Command, Callable[[bool, str], None]]] = []
        self._stream = _Stream()
        self._warned: set[str] = set()

    def on_tick(self, time_us: int) -> None:
        """Pass on the commands that have arrived; no message can end the flight.

        Args:
            time_us: Simulated time after the tick.
        """
        for inlet, kind, act in self._inlets:
            for data in inlet.take():
                self._guard(kind, data, act)
        for service, kind, name, act in self._services:
            for request in service.take():
                self._serve(kind, name, request, act)
        if self._client is None:
            return
        self._stream.on_tick(time_us, self._client)
        self._client.update(time_us)
        for command, answer in self._waiting:
            if command.is_done:
                answer(command.is_accepted, command.outcome())
        # Commands that the autopilot has not acknowledged yet stay for later ticks.
        self._waiting = [each for each in self._waiting if not each[0].is_done]

    @property
    def client(self) -> MavlinkClient:
        """The companion, which is connected at the first use."""
        if self._client is None:
            self._client = self._connect()
            self._client.request_streams()
        return self._client

    def _guard(self, kind: str, data: bytes, act: Callable[[Any], Any]) -> Any:
        """Decode a message and act on it; malformed bytes are dropped and reported once."""
        try:
            message = self._ros.decode(data, kind)
        except Exception as error:  # noqa: BLE001  # the library raises what the bytes lead it to
            self._warn(f"{kind} of {len(data)} bytes is dropped: {error!r}")
            return None
        return act(message)

    def _serve(self, kind: str, name: str, request: Any, act: Callable[[Any], Command]) -> None:
        def answer(success: bool, message: str) -> None:
            reply = self._ros.new(f"std_srvs/{kind}_Response", success=success, message=message)
            request.reply(self._ros.encode(reply))

        command = self._guard(f"std_srvs/{kind}_Request", request.data, act)
        if command is None:
            answer(False, f"the request to {name} is no {kind}")
        else:
            self._waiting.append((command, answer))

    def _arm(self, *, is_armed: bool) -> Command:
        self._stream.is_released = False  # Arming begins a new flight.
        return self.client.arm() if is_armed else self.client.disarm()

    def _land(self) -> Command:
        self._stream.is_released = True
        return self.client.set_mode(self.client.habits.land_here)

    def _on_twist(self, message: Any) -> None:
        """Follow a velocity and a yaw rate, in the level frame of the heading or in the world."""
        frame = message.header.frame_id
        is_of_body = self._frames.get(frame)
        linear, yaw_rate = message.twist.linear, message.twist.angular.z
        velocity = (linear.x, linear.y, linear.z)
        if is_of_body is None:
            valid = ", ".join(name for name in self._frames if name)
            self._warn(f"cmd_vel in frame {frame!r} is dropped; valid: {valid}")
            return
        if not all(map(math.isfinite, (*velocity, yaw_rate))):
            self._warn("cmd_vel with a value that is not finite is dropped")
            return
        if is_of_body:
            velocity = _turned(velocity, self.client.telemetry.yaw_rad)
        self._follow(lambda: self.client.send_velocity(velocity, yaw_rate))

    def _on_points(self, message: Any) -> None:
        """Follow the first point of a trajectory: a position with optional derivatives."""
        frame = message.header.frame_id
        # Positions have no meaning in a frame that moves with the body.
        if self._frames.get(frame, True) and frame:
            self._warn(f"trajectory in frame {frame!r} is dropped; valid: {MAP}, {ODOM}")
            return
        reference = _reference(message)
        if reference is None:
            self._warn("trajectory without a finite first point is dropped")
            return
        self._follow(lambda: self.client.send_setpoint(reference))

    def _follow(self, send: Callable[[], None]) -> None:
        """Pass a set point on, unless the vehicle was told to land."""
        if self._stream.is_released:
            self._warn("setpoints are dropped after land, until the vehicle is told to arm")
            return
        _ = self.client  # connects, if this is the first command
        self._stream.setpoint = send

    def _warn(self, line: str) -> None:
        # Bounded, since lines quote names from messages and could be new ones for ever.
        if line not in self._warned and len(self._warned) < 100:
            self._warned.add(line)
            _LOG.warning("ROS 2: %s", line)


class _Stream:
    """A stream of set points, and the change of mode with which it begins."""

    def __init__(self) -> None:
        self.setpoint: Callable[[], None] | None = None
        """Function that sends the newest set point; None if none came since the last tick."""
        self.is_released = False
        """True after a command to land, so that further set points are dropped."""
        self._last_us = -_STREAM_GAP_US - 1
        self._has_mode = False
        self._asked: Command | None = None
        self._asked_us = 0

    def on_tick(self, time_us: int, client: MavlinkClient) -> None:
        """Send the newest set point, and ask for OFFBOARD until it is granted once.

        Args:
            time_us: Simulated time after the tick.
            client: Companion of the vehicle.
        """
        if self.setpoint is None or not client.telemetry.has_state:
            return
        if time_us - self._last_us > _STREAM_GAP_US:
            self._has_mode, self._asked = False, None
        self._last_us = time_us
        # The set point comes before the request, since OFFBOARD is refused without a stream.
        self.setpoint()
        self.setpoint = None
        if self._asked is not None and self._asked.is_done:
            self._has_mode = self._has_mode or self._asked.is_accepted
            self._asked = None
        if not self._has_mode and self._asked is None and time_us - self._asked_us > _RETRY_US:
            self._asked, self._asked_us = client.set_mode(client.habits.offboard), time_us


def _turned(vector_flu: Vector3, yaw_rad: float) -> Vector3:
    """Return a vector of the level frame of the heading in the world's frame."""
    x, y, z = vector_flu
    sin, cos = math.sin(yaw_rad), math.cos(yaw_rad)
    return (x * cos - y * sin, x * sin + y * cos, z)


def _reference(message: Any) -> FlatReference | None:
    """Return the first point of a trajectory, None if there is no finite one."""
    if not message.points or not message.points[0].transforms:
        return None
    point = message.points[0]
    pose = point.transforms[0]
    at, turn = pose.translation, pose.rotation
    speed = point.velocities[0] if point.velocities else None
    push = point.accelerations[0] if point.accelerations else None
    reference = FlatReference(
        position_enu_m=(at.x, at.y, at.z),
        velocity_enu_mps=_xyz(speed),
        acceleration_enu_mps2=_xyz(push),
        yaw_rad=yaw_of((turn.w, turn.x, turn.y, turn.z)),
        yaw_rate_radps=0.0 if speed is None else speed.angular.z,
    )
    values = (
        *reference.position_enu_m,
        *reference.velocity_enu_mps,
        *reference.acceleration_enu_mps2,
        reference.yaw_rad,
        reference.yaw_rate_radps,
    )
    return reference if all(map(math.isfinite, values)) else None


def _xyz(twist: Any) -> Vector3:
    if twist is None:
        return (0.0, 0.0, 0.0)
    return (twist.linear.x, twist.linear.y, twist.linear.z)
