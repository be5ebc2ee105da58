"""TCP server link, like port 5760 of ArduPilot's simulator: each connection is a partner."""

from __future__ import annotations

import contextlib
import logging
import selectors
import socket
import time
from collections.abc import Callable, Sequence

from flightsim.mavlink.channel import Channel, Clock, Write
from flightsim.mavlink.links.link import MAX_PARTNERS, bind, is_loopback
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.streams import Profile

_LOG = logging.getLogger(__name__)

_ACCEPTS_PER_TICK = 16
_READ_BYTES = 16_384
_BACKLOG_LIMIT_BYTES = 1 << 20  # bytes beyond which frames are dropped
_STUCK_LIMIT_S = 30.0  # a partner that has read nothing for so long is disconnected


class _Connection:
    """One accepted connection and the bytes that its socket has not accepted yet."""

    def __init__(self, tcp: socket.socket, open_channel: Callable[[Write], Channel]) -> None:
        self.socket = tcp
        self.is_broken = False
        self._unsent = bytearray()
        self._last_progress_s = time.monotonic()
        self.channel = open_channel(self.write)

    def read(self) -> None:
        """Read received bytes, unless the partner has exceeded its budget."""
        if not self.channel.has_room:
            return
        try:
            data = self.socket.recv(_READ_BYTES)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""  # no bytes: the partner has closed the connection
        if data:
            self.channel.receive(data)
        else:
            self.is_broken = True

    def write(self, frames: Sequence[bytes]) -> None:
        """Send what the socket accepts; whole frames are dropped while too much is queued."""
        if len(self._unsent) < _BACKLOG_LIMIT_BYTES:
            self._unsent += b"".join(frames)
        try:
            n_sent = self.socket.send(self._unsent)
        except (BlockingIOError, InterruptedError):
            n_sent = 0
        except OSError:
            self.is_broken = True
            return
        now_s = time.monotonic()
        if n_sent:
            del self._unsent[:n_sent]
            self._last_progress_s = now_s
        elif now_s - self._last_progress_s > _STUCK_LIMIT_S:
            self.is_broken = True


class TcpServerLink:
    """A listening port; every connection gets its own channel."""

    def __init__(
        self,
        *,
        port: int,
        profile: Profile = "normal",
        bind_address: str = "127.0.0.1",
        is_lockstep: bool = False,
        signing: Signing | None = None,
    ) -> None:
        """Prepare a link.

        Args:
            port: Port to listen on; 0 takes any that is free.
            profile: Default stream rates.
            bind_address: Address to listen on.
            is_lockstep: True runs protocol timeouts in simulated time.
            signing: Key and timestamps that all links share; None never signs.
        """
        self._is_lockstep = is_lockstep
        self._signing = signing or Signing()
        self._link_id = self._signing.new_link_id()
        self._clock: Clock = time.monotonic
        self.name = f"tcp:{port}"
        self._local = (bind_address, port)
        self._profile: Profile = profile
        self._listener: socket.socket | None = None
        self._selector: selectors.BaseSelector | None = None
        self._connections: list[_Connection] = []
        self._is_full_told = False
        """True if a rejection was logged since the last accepted client."""

    @property
    def port(self) -> int:
        """Port that it listens on, once open: the one that was free if 0 was asked for."""
        return self._local[1] if self._listener is None else self._listener.getsockname()[1]

    @property
    def channels(self) -> Sequence[Channel]:
        """Partners connected now; broken connections are removed first."""
        if any(connection.is_broken for connection in self._connections):
            self._clear_broken()
        return tuple(connection.channel for connection in self._connections)

    def open(self, selector: selectors.BaseSelector, simulated_us: Callable[[], int]) -> None:
        """Listen on the port.

        Raises:
            PortInUseError: If the port is taken.
            LinkError: If it cannot be bound for another reason.
        """
        if self._is_lockstep:
            self._clock = lambda: simulated_us() * 1e-6
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        # Connections of the last run that linger in TIME_WAIT must not hold the port.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bind(listener, "TCP", *self._local)
        listener.listen(_ACCEPTS_PER_TICK)
        listener.setblocking(False)
        self._listener, self._selector = listener, selector
        selector.register(listener, selectors.EVENT_READ, self._accept)

    def close(self) -> None:
        """Close all connections and release the port."""
        for connection in self._connections:
            connection.is_broken = True
        self._clear_broken()
        if self._listener is not None and self._selector is not None:
            self._selector.unregister(self._listener)
            self._listener.close()
        self._listener = None

    def _accept(self) -> None:
        """Accept waiting clients; disconnect those beyond the limit, which is logged once."""
        assert self._listener is not None
        for _ in range(_ACCEPTS_PER_TICK):
            try:
                tcp, address = self._listener.accept()
            except OSError:
                return  # nobody waits any more
            name = f"{self.name} {address[0]}:{address[1]}"
            if len(self.channels) < MAX_PARTNERS:
                self._welcome(tcp, name, is_local=is_loopback(address[0]))
                continue
            tcp.close()
            if not self._is_full_told:
                _LOG.warning("%s is turned away: %d clients are connected", name, MAX_PARTNERS)
            self._is_full_told = True

    def _welcome(self, tcp: socket.socket, name: str, *, is_local: bool) -> None:
        assert self._selector is not None
        self._is_full_told = False
        tcp.setblocking(False)
        # Small frames must leave at once, not when more bytes have gathered.
        with contextlib.suppress(OSError):
            tcp.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection = _Connection(
            tcp,
            lambda write: Channel(
                name,
                write,
                profile=self._profile,
                clock=self._clock,
                is_datagram=False,
                is_local=is_local,
                signing=self._signing,
                link_id=self._link_id,
            ),
        )
        self._connections.append(connection)
        self._selector.register(tcp, selectors.EVENT_READ, connection.read)

    def _clear_broken(self) -> None:
        # Only here, never while frames are written: the server iterates over the channels then.
        for connection in [c for c in self._connections if c.is_broken]:
            self._connections.remove(connection)
            connection.channel.is_open = False
            if self._selector is not None:
                self._selector.unregister(connection.socket)
            connection.socket.close()
