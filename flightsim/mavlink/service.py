"""Interfaces of the microservices, and ways to reach all partners."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Protocol

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import Layout, layout
from flightsim.mavlink.parsing import Message

Handler = Callable[[Channel, Message], str | None]
"""Answers a message. It returns why the message changes nothing, if nothing else reports that."""


class Service(Protocol):
    """One MAVLink microservice that answers messages."""

    @property
    def handlers(self) -> Mapping[str, Handler]:
        """Handler of each message name; messages for other systems are filtered out before."""
        ...


class StatefulService(Service, Protocol):
    """A microservice that keeps state per partner and acts by itself."""

    @property
    def busy(self) -> Collection[Channel]:
        """Partners for whom work may be due; the others cost nothing."""
        ...

    def update(self, channel: Channel) -> None:
        """Perform due work for a partner; called once per tick for each one in `busy`."""
        ...

    def forget(self, channel: Channel) -> None:
        """Drop the state of a partner that left, or whose due work cannot be done."""
        ...


class CommonService(Service, Protocol):
    """A microservice that acts for all partners together."""

    def update(self) -> None:
        """Perform due work; called once per tick."""
        ...

    def forget(self, channel: Channel) -> None:
        """Drop the state of a partner that left."""
        ...


class Watching(Protocol):
    """An observer of the vehicle, called in each tick."""

    def update(self) -> None:
        """Look at the vehicle, and keep or report what is new; called once per tick."""
        ...


class Partners:
    """All present partners, for broadcasts."""

    def __init__(self) -> None:
        self.channels: Sequence[Channel] = ()

    def broadcast(self, message: Layout, payload: bytes) -> None:
        """Send one payload to all partners; it is packed only once."""
        for channel in self.channels:
            channel.send(message, payload)


def send(channel: Channel, name: str, **values: Any) -> None:
    """Send a message from named field values: for answers, not for streams.

    Args:
        channel: The receiver.
        name: Name of the message.
        values: Values of its fields; fields that are missing are 0.
    """
    message = layout(name)
    channel.send(message, message.encode(**values))
