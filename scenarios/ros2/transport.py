"""Interface of a transport: outlets for topics, inlets, services, and their quality of service.

DDS and Zenoh have different ideas of nodes and connections. The door only needs to send bytes, to
take those that arrived, and to know whether anybody listens. Everything is polled, because with
callbacks of other threads a partner could delay or change a flight.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, kw_only=True, slots=True)
class Qos:
    """Quality of service, in the terms of ROS 2; the history is always "keep last"."""

    is_reliable: bool
    """True repeats lost messages; False is "best effort"."""
    is_latched: bool = False
    """True gives late subscribers the last messages ("transient local")."""
    depth: int = 10
    """Number of messages that are kept."""


SENSOR = Qos(is_reliable=False, depth=5)
"""ROS 2's profile for sensor data: clock, measurements, images, points."""
STATE = Qos(is_reliable=True)
"""ROS 2's default profile: odometry and commands."""
TRANSFORM = Qos(is_reliable=True, depth=100)
"""Profile of tf2 for moving transforms."""
LATCHED = Qos(is_reliable=True, is_latched=True, depth=1)
"""Profile of tf2 for fixed transforms, used for everything that never or rarely changes."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Kind:
    """Type of a topic or a service."""

    name: str
    """Full name, such as `sensor_msgs/msg/Imu` or `std_srvs/srv/Trigger`."""
    type_hash: str
    """Hash after REP 2011, such as `RIHS01_7d9a00ff...`."""

    @property
    def dds_name(self) -> str:
        """Name of the type in DDS and rmw_zenoh, such as `sensor_msgs::msg::dds_::Imu_`."""
        package, folder, name = self.name.split("/")
        return f"{package}::{folder}::dds_::{name}_"


class TransportError(RuntimeError):
    """A transport cannot be opened; the message needs a subject before it."""


class Outlet(Protocol):
    """A topic to publish on."""

    @property
    def is_heard(self) -> bool:
        """True if anybody subscribes, as of a tenth of a second ago at most."""
        ...

    def send(self, data: bytes) -> None:
        """Publish a message; it is dropped if it cannot be sent at once.

        Args:
            data: Message in CDR, with the header of its encoding.
        """
        ...


class Inlet(Protocol):
    """A topic that is subscribed to."""

    def take(self) -> Sequence[bytes]:
        """Return the messages in CDR that have arrived since the last call, without waiting."""
        ...


@dataclass(frozen=True, kw_only=True, slots=True)
class Request:
    """A request to a service, whose client waits for the reply."""

    data: bytes
    """Request in CDR."""
    reply: Callable[[bytes], None]
    """Function that sends the reply in CDR; the client may have gone."""


class Service(Protocol):
    """A service that is offered."""

    def take(self) -> Sequence[Request]:
        """Return the requests that have arrived since the last call, without waiting."""
        ...


class Transport(Protocol):
    """A connection to the other nodes of a domain."""

    def outlet(self, topic: str, kind: Kind, qos: Qos) -> Outlet:
        """Offer a topic.

        Args:
            topic: Full name, such as `/imu`.
            kind: Type of its messages.
            qos: Quality of service.
        """
        ...

    def inlet(self, topic: str, kind: Kind, qos: Qos) -> Inlet:
        """Subscribe to a topic.

        Args:
            topic: Full name, such as `/cmd_vel`.
            kind: Type of its messages.
            qos: Quality of service.
        """
        ...

    def service(self, name: str, kind: Kind) -> Service:
        """Offer a service.

        Args:
            name: Full name, such as `/arm`.
            kind: Type of the service.
        """
        ...

    def close(self) -> None:
        """Leave the domain, and free everything that was opened."""
        ...
