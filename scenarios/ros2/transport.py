"""What a transport offers: outlets for topics, inlets, and services; and their quality of service.

Everything is polled. No thread of ours runs, and no partner can delay or end a flight.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, kw_only=True, slots=True)
class Qos:
    """Quality of service, in the terms of ROS 2; the history is always "keep last"."""

    is_reliable: bool
    """Whether lost messages are repeated; otherwise best effort."""
    is_latched: bool = False
    """Whether who subscribes late still gets the last messages (transient local)."""
    depth: int = 10
    """Number of messages that are kept."""


SENSOR = Qos(is_reliable=False, depth=5)
"""ROS 2's profile for sensor data: clock, measurements, images, points."""
STATE = Qos(is_reliable=True)
"""ROS 2's default profile: odometry and commands."""
TRANSFORM = Qos(is_reliable=True, depth=100)
"""Profile of tf2 for moving transforms."""
LATCHED = Qos(is_reliable=True, is_latched=True, depth=1)
"""Profile of tf2 for fixed transforms, and of all that never or rarely changes."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Kind:
    """Type of a topic or a service."""

    name: str
    """Such as `sensor_msgs/msg/Imu` or `std_srvs/srv/Trigger`."""
    type_hash: str
    """Hash after REP 2011, such as `RIHS01_7d9a00ff...`."""

    @property
    def dds_name(self) -> str:
        """Name that DDS and rmw_zenoh have for it, such as `sensor_msgs::msg::dds_::Imu_`."""
        package, folder, name = self.name.split("/")
        return f"{package}::{folder}::dds_::{name}_"


class TransportError(RuntimeError):
    """A transport cannot be opened; the message has no subject."""


class Outlet(Protocol):
    """A topic to publish on."""

    @property
    def is_heard(self) -> bool:
        """Whether anybody subscribes, as of a tenth of a second ago at most."""
        ...

    def send(self, data: bytes) -> None:
        """Publish a message in CDR; it is dropped where it cannot be sent at once."""
        ...


class Inlet(Protocol):
    """A topic that is subscribed to."""

    def take(self) -> Sequence[bytes]:
        """Messages in CDR that have come since the last call."""
        ...


@dataclass(frozen=True, kw_only=True, slots=True)
class Request:
    """A request to a service, which waits for its reply."""

    data: bytes
    """The request in CDR."""
    reply: Callable[[bytes], None]
    """Sends the reply in CDR, to a client that may have gone."""


class Service(Protocol):
    """A service that is offered."""

    def take(self) -> Sequence[Request]:
        """Requests that have come since the last call."""
        ...


class Transport(Protocol):
    """A way to the other nodes of a domain."""

    def outlet(self, topic: str, kind: Kind, qos: Qos) -> Outlet:
        """Offer a topic, such as `/imu`."""
        ...

    def inlet(self, topic: str, kind: Kind, qos: Qos) -> Inlet:
        """Subscribe to a topic."""
        ...

    def service(self, name: str, kind: Kind) -> Service:
        """Offer a service, such as `/arm`."""
        ...

    def close(self) -> None:
        """Leave the domain."""
        ...
