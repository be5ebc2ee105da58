"""UDP link like PX4's: it sends to a known port first and answers any other sender."""

from __future__ import annotations

import contextlib
import selectors
import socket
import time
from collections.abc import Callable, Sequence

from flightsim.mavlink.channel import Channel, Clock
from flightsim.mavlink.links.link import MAX_PARTNERS, bind, is_loopback
from flightsim.mavlink.parsing import starts_with_message
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.streams import Profile

_Address = tuple[str, int]

_DATAGRAMS_PER_TICK = 128  # bounds the work of a tick
_SILENCE_LIMIT_S = 60.0  # silence after which a learnt partner may lose its place


class UdpLink:
    """A UDP port with a default partner, addressed first, and partners learnt from traffic.

    Only a sender of MAVLink becomes a partner, because others would take the places of clients.
    """

    def __init__(
        self,
        *,
        local_port: int,
        remote_port: int,
        profile: Profile = "normal",
        bind_address: str = "127.0.0.1",
        remote_address: str = "127.0.0.1",
        is_lockstep: bool = False,
        signing: Signing | None = None,
    ) -> None:
        """Prepare a link.

        Args:
            local_port: Port to bind.
            remote_port: Port of the partner that is addressed first.
            profile: Default stream rates.
            bind_address: Address to bind.
            remote_address: Address of the partner that is addressed first.
            is_lockstep: True runs protocol timeouts in simulated time.
            signing: Key and timestamps that all links share; None never signs.
        """
        self._is_lockstep = is_lockstep
        self._signing = signing or Signing()
        self._link_id = self._signing.new_link_id()
        self._clock: Clock = time.monotonic
        self.name = f"udp:{local_port}->{remote_port}"
        self._local: _Address = (bind_address, local_port)
        self._profile: Profile = profile
        self._default: _Address = (remote_address, remote_port)
        self._partners: dict[_Address, Channel] = {self._default: self._new(self._default)}
        self._last_heard_s: dict[_Address, float] = {}
        self._socket: socket.socket | None = None
        self._selector: selectors.BaseSelector | None = None

    @property
    def channels(self) -> Sequence[Channel]:
        """The default partner and those learnt from traffic."""
        return tuple(self._partners.values())

    def open(self, selector: selectors.BaseSelector, simulated_us: Callable[[], int]) -> None:
        """Bind the local port.

        Raises:
            PortInUseError: If it is taken.
            LinkError: If it cannot be bound for another reason.
        """
        if self._is_lockstep:
            self._clock = lambda: simulated_us() * 1e-6
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        bind(udp, "UDP", *self._local)
        udp.setblocking(False)
        # At full speed the simulation sends a second's telemetry within milliseconds.
        with contextlib.suppress(OSError):
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
        self._socket, self._selector = udp, selector
        selector.register(udp, selectors.EVENT_READ, self._read)

    def close(self) -> None:
        """Release the port."""
        if self._socket is not None and self._selector is not None:
            self._selector.unregister(self._socket)
            self._socket.close()
        self._socket = None

    def _read(self) -> None:
        assert self._socket is not None
        for _ in range(_DATAGRAMS_PER_TICK):
            try:
                data, address = self._socket.recvfrom(65536)
            except (BlockingIOError, InterruptedError):
                return
            except OSError:
                continue  # an ICMP error left by a partner that is gone
            channel = self._partners.get(address)
            if channel is None and starts_with_message(data, self._signing):
                channel = self._learn(address)
            if channel is not None:
                self._last_heard_s[address] = time.monotonic()
                channel.receive(data)

    def _learn(self, address: _Address) -> Channel | None:
        """Create a channel for a new partner, replacing a silent one if the link is full."""
        if len(self._partners) >= MAX_PARTNERS:
            # The default partner keeps its place: it is addressed even if it is silent.
            learnt = [known for known in self._partners if known != self._default]
            silent = min(learnt, key=lambda known: self._last_heard_s.get(known, 0.0))
            if time.monotonic() - self._last_heard_s.get(silent, 0.0) < _SILENCE_LIMIT_S:
                return None
            self._forget(silent)
        self._partners[address] = self._new(address)
        return self._partners[address]

    def _forget(self, address: _Address) -> None:
        self._partners.pop(address).is_open = False
        self._last_heard_s.pop(address, None)

    def _new(self, address: _Address) -> Channel:
        return Channel(
            f"{self.name} {address[0]}:{address[1]}",
            lambda frames: self._write(frames, address),
            profile=self._profile,
            clock=lambda: self._clock(),  # noqa: PLW0108 - set when the link is opened
            is_datagram=True,
            is_local=is_loopback(address[0]),
            signing=self._signing,
            link_id=self._link_id,
        )

    def _write(self, frames: Sequence[bytes], address: _Address) -> None:
        """Send frames as one datagram, in the groups that a channel makes."""
        if self._socket is None:
            return
        # A full buffer or an unreachable partner loses the datagram, as radio would.
        with contextlib.suppress(OSError):
            self._socket.sendto(b"".join(frames), address)
