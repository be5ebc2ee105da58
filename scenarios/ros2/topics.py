"""Publishers of messages by topic, which build and encode a message only if somebody listens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenarios.ros2.messages import RosMessages
from scenarios.ros2.transport import Kind, Outlet, Qos, Transport


class Topics:
    """The topics of one vehicle, under its namespace.

    Attributes:
        ros: Maker of messages.
        prefix: Namespace with a slash at its end, such as `vehicle_2/`, which stands before the
            names of its frames and topics; empty for the first vehicle.
    """

    def __init__(self, transport: Transport, ros: RosMessages, prefix: str = "") -> None:
        self.ros, self.prefix = ros, prefix
        self._transport = transport

    def publisher(self, topic: str, kind: str, qos: Qos) -> Publisher:
        """Offer a topic.

        Args:
            topic: Name, such as `imu`. A name that starts with a slash, such as `/tf`, gets no
                namespace.
            kind: Type of its messages, such as `sensor_msgs/Imu`.
            qos: Quality of service.
        """
        return Publisher(self._transport.outlet(self.name(topic), self.kind(kind), qos), self.ros)

    def name(self, topic: str) -> str:
        """Return the full name of a topic: `/vehicle_2/imu` for `imu`, `/tf` for `/tf`."""
        return topic if topic.startswith("/") else f"/{self.prefix}{topic}"

    def kind(self, kind: str) -> Kind:
        """Return the type of messages, such as `sensor_msgs/Imu`, with its hash."""
        package, name = kind.split("/")
        return Kind(name=f"{package}/msg/{name}", type_hash=self.ros.type_hash(kind))

    def frame(self, frame: str) -> str:
        """Return the full name of a frame of the vehicle, such as `vehicle_2/base_link`."""
        return f"{self.prefix}{frame}"


class Publisher:
    """Publisher of one topic."""

    def __init__(self, outlet: Outlet, ros: RosMessages) -> None:
        self._outlet, self._ros = outlet, ros

    @property
    def is_heard(self) -> bool:
        """True if anybody subscribes, as of a tenth of a second ago at most."""
        return self._outlet.is_heard

    def send(self, message: Any) -> None:
        """Encode and publish a message, whether or not anybody listens."""
        self._outlet.send(self._ros.encode(message))

    def offer(self, build: Callable[[], Any]) -> None:
        """Publish a message that is only built if somebody listens.

        Args:
            build: Function that returns the message.
        """
        if self._outlet.is_heard:
            self.send(build())
