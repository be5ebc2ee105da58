"""UDP to one named address, where the vehicle speaks first, as to a ground station elsewhere."""

from __future__ import annotations

import contextlib
import functools
import selectors
import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

from flightsim.mavlink.channel import Channel, Clock
from flightsim.mavlink.links.link import LinkError, is_loopback
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.streams import Profile

_DATAGRAMS_PER_TICK = 128  # bounds the work of a tick
_VALID = "udp:HOST:PORT, such as udp:192.168.1.20:14550"


@dataclass(frozen=True, slots=True)
class OutAddress:
    """Address to which the vehicle speaks first."""

    host: str
    address: str
    """IPv4 address of the host."""
    port: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the address of udp:HOST:PORT.

        Raises:
            LinkError: If the text has another form, or the host is unknown.
        """
        kind, _, rest = text.partition(":")
        host, _, port = rest.rpartition(":")
        # Cut before the conversion: a text of a million digits must not be turned into a number.
        is_port = port.isascii() and port.isdigit() and 1 <= int(port[:6]) <= 65535
        if kind != "udp" or not host or not is_port:
            raise LinkError(f"out {text!r} is no address; valid: {_VALID}")
        address = _resolved(host)
        if address is None:
            raise LinkError(f"out {text!r}: host {host!r} is unknown; valid: {_VALID}")
        return cls(host, address, int(port))


@functools.cache
def _resolved(host: str) -> str | None:
    """Return the IPv4 address of a host; None if it has none."""
    try:
        found = socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_DGRAM)
    except (OSError, UnicodeError):
        return None
    return str(found[0][4][0])


class UdpOutLink:
    """A UDP socket whose only partner is the address that a user named.

    The socket is connected: datagrams that others send to its port never reach it, so that it may
    be open to other machines. The system chooses its port.
    """

    def __init__(
        self,
        out: OutAddress,
        *,
        profile: Profile = "normal",
        is_lockstep: bool = False,
        signing: Signing | None = None,
    ) -> None:
        """Prepare a link.

        Args:
            out: Address of the partner.
            profile: Default stream rates.
            is_lockstep: True runs protocol timeouts in simulated time.
            signing: Key and timestamps that all links share; None never signs.
        """
        self.name = f"udp:{out.host}:{out.port}"
        self._out = (out.address, out.port)
        self._is_lockstep = is_lockstep
        self._clock: Clock = time.monotonic
        self._socket: socket.socket | None = None
        self._selector: selectors.BaseSelector | None = None
        signing = signing or Signing()
        self._channel = Channel(
            self.name,
            self._write,
            profile=profile,
            clock=lambda: self._clock(),  # noqa: PLW0108 - set when the link is opened
            is_datagram=True,
            is_local=is_loopback(out.address),
            signing=signing,
            link_id=signing.new_link_id(),
        )

    @property
    def channels(self) -> Sequence[Channel]:
        """The one partner, even before it answers."""
        return (self._channel,)

    def open(self, selector: selectors.BaseSelector, simulated_us: Callable[[], int]) -> None:
        """Open the socket.

        Raises:
            LinkError: If there is no route to the address.
        """
        if self._is_lockstep:
            self._clock = lambda: simulated_us() * 1e-6
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            udp.connect(self._out)
        except OSError as error:
            udp.close()
            raise LinkError(f"cannot send to {self.name}: {error.strerror or error}") from error
        udp.setblocking(False)
        # At full speed the simulation sends a second's telemetry within milliseconds.
        with contextlib.suppress(OSError):
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
        self._socket, self._selector = udp, selector
        selector.register(udp, selectors.EVENT_READ, self._read)

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None and self._selector is not None:
            self._selector.unregister(self._socket)
            self._socket.close()
        self._socket = None

    def _read(self) -> None:
        assert self._socket is not None
        for _ in range(_DATAGRAMS_PER_TICK):
            try:
                data = self._socket.recv(65536)
            except (BlockingIOError, InterruptedError):
                return
            except OSError:
                continue  # an ICMP error: nobody listens there yet
            self._channel.receive(data)

    def _write(self, frames: Sequence[bytes]) -> None:
        """Send frames as one datagram, in the groups that a channel makes."""
        if self._socket is None:
            return
        # A full buffer or an unreachable partner loses the datagram, as radio would.
        with contextlib.suppress(OSError):
            self._socket.send(b"".join(frames))
