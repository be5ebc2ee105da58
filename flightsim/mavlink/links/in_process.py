"""In-process link without sockets, for a client in lockstep with the simulation."""

from __future__ import annotations

import selectors
from collections.abc import Callable, Sequence

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.streams import Profile

# Frames beyond it are dropped: a client that never reads must not fill the memory.
_BACKLOG_LIMIT_BYTES = 4 << 20


class InProcessClient:
    """Client end of the link: a byte pipe."""

    def __init__(self, deliver: Callable[[bytes], None], incoming: bytearray) -> None:
        self._deliver = deliver
        self._incoming = incoming
        self.is_present = False
        """True once the pipe has been used; nothing is streamed before that."""

    def send(self, data: bytes) -> None:
        """Send bytes to the vehicle, which reads them in its next tick."""
        self.is_present = True
        self._deliver(data)

    def recv(self) -> bytes:
        """Return all bytes received since the last call, possibly none."""
        self.is_present = True
        data = bytes(self._incoming)
        self._incoming.clear()
        return data


class InProcessLink:
    """One client in this process; protocol timeouts run in simulated time."""

    def __init__(self, *, profile: Profile = "onboard", name: str = "in-process") -> None:
        self.name = name
        self._simulated_us: Callable[[], int] = lambda: 0
        self._to_client = bytearray()
        self._channel = Channel(
            name,
            self._write,
            profile=profile,
            clock=lambda: self._simulated_us() * 1e-6,
            is_datagram=False,
        )
        self.client = InProcessClient(self._channel.receive, self._to_client)

    def _write(self, frames: Sequence[bytes]) -> None:
        """Queue frames for the client; frames are dropped while it does not read."""
        if len(self._to_client) < _BACKLOG_LIMIT_BYTES:
            self._to_client += b"".join(frames)

    @property
    def channels(self) -> Sequence[Channel]:
        """The one partner, once it has connected."""
        return (self._channel,) if self.client.is_present else ()

    def open(self, _: selectors.BaseSelector, simulated_us: Callable[[], int]) -> None:
        """Use the simulated time as the clock of protocol timeouts."""
        self._simulated_us = simulated_us

    def close(self) -> None:
        """Do nothing: there is no port to release."""
