"""What the microservices share: how they are called, and how they reach all partners."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import Layout, layout
from flightsim.mavlink.parsing import Message

Handler = Callable[[Channel, Message], None]


class Service(Protocol):
    """One MAVLink microservice that answers messages."""

    @property
    def handlers(self) -> Mapping[str, Handler]:
        """What to call for which message; messages for other systems are filtered before."""
        ...


class StatefulService(Service, Protocol):
    """A microservice that keeps something for its partners and has things to do on its own."""

    def update(self) -> None:
        """Do what is due; once a tick."""
        ...

    def forget(self, channel: Channel) -> None:
        """A partner is gone: drop what was kept for it."""
        ...


class Partners:
    """All partners at present, for what everybody is told."""

    def __init__(self) -> None:
        self.channels: Sequence[Channel] = ()

    def broadcast(self, message: Layout, payload: bytes) -> None:
        """Send one payload to everybody."""
        for channel in self.channels:
            channel.send(message, payload)


def send(channel: Channel, name: str, **values: Any) -> None:
    """Send a message by names of its fields: for answers, not for streams."""
    message = layout(name)
    channel.send(message, message.encode(**values))
