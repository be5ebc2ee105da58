"""Publishers of messages by topic: build and encode them where somebody listens, else nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenarios.ros2.messages import RosMessages
from scenarios.ros2.transport import Kind, Outlet, Qos, Transport


class Topics:
    """The topics of one vehicle, under its namespace.

    Attributes:
        ros: Makes messages.
        prefix: In front of its frames, and with a slash of its topics; empty for the first vehicle.
    """

    def __init__(self, transport: Transport, ros: RosMessages, prefix: str = "") -> None:
        self.ros, self.prefix = ros, prefix
        self._transport = transport

    def publisher(self, topic: str, kind: str, qos: Qos) -> Publisher:
        """Offer a topic such as `imu`; one that starts with a slash is every vehicle's."""
        return Publisher(self._transport.outlet(self.name(topic), self.kind(kind), qos), self.ros)

    def name(self, topic: str) -> str:
        """Full name of a topic of the vehicle."""
        return topic if topic.startswith("/") else f"/{self.prefix}{topic}"

    def kind(self, kind: str) -> Kind:
        """Type of messages, such as `sensor_msgs/Imu`."""
        package, name = kind.split("/")
        return Kind(name=f"{package}/msg/{name}", type_hash=self.ros.type_hash(kind))

    def frame(self, frame: str) -> str:
        """Frame of the vehicle, such as `base_link`."""
        return f"{self.prefix}{frame}"


class Publisher:
    """One topic."""

    def __init__(self, outlet: Outlet, ros: RosMessages) -> None:
        self._outlet, self._ros = outlet, ros

    @property
    def is_heard(self) -> bool:
        """Whether anybody subscribes."""
        return self._outlet.is_heard

    def send(self, message: Any) -> None:
        """Publish a message."""
        self._outlet.send(self._ros.encode(message))

    def offer(self, build: Callable[[], Any]) -> None:
        """Publish a message that is only built if somebody listens."""
        if self._outlet.is_heard:
            self.send(build())
