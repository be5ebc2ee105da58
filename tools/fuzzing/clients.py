"""Hostile clients on each kind of link."""

from __future__ import annotations

import contextlib
import os
import random
import socket
import tty
from typing import Literal, Protocol, Self

from flightsim.mavlink.dialect import LAYOUTS, MARKER_V2, MESSAGE_NAMES, SIGNED_FLAG
from flightsim.mavlink.links import (
    InProcessLink,
    Link,
    SerialLine,
    SerialLink,
    TcpServerLink,
    UdpLink,
)
from flightsim.mavlink.signing import Signing, key_of_passphrase

LinkName = Literal["in-process", "udp", "tcp", "serial", "signed"]
LINKS: tuple[LinkName, ...] = ("in-process", "udp", "tcp", "serial", "signed")

# The key of the signed link: an enemy that cannot sign is turned away before anything is decoded.
_KEY = key_of_passphrase("known to the enemy")
_BAUD = 921_600
_MOST_UNSENT_BYTES = 1 << 16  # a line that nobody reads must not fill the memory
_DISHONEST_SHARE = 0.1
"""Share of the frames on a signed link whose signature is missing, forged or a copy."""


class Client(Protocol):
    """A client that sends whole frames and throws away what it gets."""

    def send(self, data: bytes) -> None:
        """Send a frame, or lose it if the link takes no more."""
        ...

    def recv(self) -> bytes:
        """Return something that came since the last call, possibly nothing, and drop the rest."""
        ...


class Access:
    """Links of a vehicle, and the clients that connect to them.

    Attributes:
        links: Links to give to the vehicle.
        now_s: Clock of a serial line, which is to be set.
    """

    def __init__(self, link: LinkName | None, n_clients: int) -> None:
        self.now_s = 0.0
        self._name = link
        # A line has two ends.
        self._n_clients = 1 if link == "serial" else n_clients
        self._stack = contextlib.ExitStack()
        self._ports = _free_ports()
        self._line = os.openpty() if link == "serial" else (-1, -1)
        self.links: list[Link] = self._links()

    def _links(self) -> list[Link]:
        local, remote, listening = self._ports
        match self._name:
            case "in-process":
                return [InProcessLink() for _ in range(self._n_clients)]
            case "udp":
                return [UdpLink(local_port=local, remote_port=remote)]
            case "signed":
                return [UdpLink(local_port=local, remote_port=remote, signing=Signing(_KEY))]
            case "tcp":
                return [TcpServerLink(port=listening)]
            case "serial":
                tty.setraw(self._line[1])
                line = SerialLine(path=os.ttyname(self._line[1]), baud=_BAUD)
                return [SerialLink(line, now_s=lambda: self.now_s)]
            case _:
                return []

    def connect(self) -> list[Client]:
        """Connect the clients, once the vehicle has opened its links."""
        return [
            self._client(index) for index in range(0 if self._name is None else self._n_clients)
        ]

    def _client(self, index: int) -> Client:
        link = self.links[0 if self._name != "in-process" else index]
        if isinstance(link, InProcessLink):
            return link.client
        if self._name == "serial":
            return _SerialClient(self._line[0])
        is_tcp = self._name == "tcp"
        raw = socket.socket(socket.AF_INET, socket.SOCK_STREAM if is_tcp else socket.SOCK_DGRAM)
        self._stack.callback(raw.close)
        raw.connect(("127.0.0.1", self._ports[2 if is_tcp else 0]))
        raw.setblocking(False)
        client = _SocketClient(raw)
        return _Signer(client, index) if self._name == "signed" else client

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        for end in self._line:
            if end >= 0:
                os.close(end)


class _SocketClient:
    def __init__(self, link: socket.socket) -> None:
        self._socket = link
        self._unsent = b""

    def send(self, data: bytes) -> None:
        # A full buffer loses the frame, as on a radio; to wait would stop the simulation. The rest
        # of a frame of which a TCP socket took only a part goes before the next one, because half a
        # frame would swallow those behind it.
        with contextlib.suppress(BlockingIOError):
            if self._unsent:
                self._unsent = self._unsent[self._socket.send(self._unsent) :]
            if not self._unsent:
                self._unsent = data[self._socket.send(data) :]

    def recv(self) -> bytes:
        data = b""
        with contextlib.suppress(BlockingIOError):
            # To the end, so that the vehicle's sends never block.
            while more := self._socket.recv(1 << 16):
                data = more
        return data


class _SerialClient:
    """The far end of a line, whose driver takes only so much at a time."""

    def __init__(self, end: int) -> None:
        os.set_blocking(end, False)
        self._end = end
        self._unsent = b""

    def send(self, data: bytes) -> None:
        if len(self._unsent) < _MOST_UNSENT_BYTES:
            self._unsent += data
        with contextlib.suppress(BlockingIOError):
            self._unsent = self._unsent[os.write(self._end, self._unsent) :]

    def recv(self) -> bytes:
        with contextlib.suppress(BlockingIOError):
            return os.read(self._end, 1 << 16)
        return b""


class _Signer:
    """A client that has the key, and does not always use it as it should."""

    def __init__(self, client: Client, link_id: int) -> None:
        self._client = client
        self._link_id = link_id
        self._signing = Signing(_KEY)
        self._rng = random.Random(link_id)
        self._last = b""

    def send(self, data: bytes) -> None:
        # Scaled so that draws below 1 are the dishonest ones, and divided among three kinds.
        draw = self._rng.random() / _DISHONEST_SHARE
        if draw < 0.3:
            self._client.send(data)
            return
        frame = self._signed(data)
        if draw < 0.6:
            # The last byte belongs to the signature.
            frame = frame[:-1] + bytes((frame[-1] ^ 1,))
        elif draw < 1.0:
            # A copy has an old time stamp, which a receiver must refuse.
            frame = self._last or frame
        self._last = frame
        self._client.send(frame)

    def recv(self) -> bytes:
        return self._client.recv()

    def _signed(self, data: bytes) -> bytes:
        is_version_2 = data[0] == MARKER_V2
        # Sequence, system and component stand at other places in the two versions.
        start, (sequence, system, component) = (10, data[4:7]) if is_version_2 else (6, data[2:5])
        number = int.from_bytes(data[7:10], "little") if is_version_2 else data[5]
        layout = LAYOUTS[MESSAGE_NAMES[number]]
        payload = data[start : start + data[1]]
        frame = layout.frame_v2(payload, sequence, system, component, SIGNED_FLAG)
        return self._signing.sign(frame, self._link_id)


def _free_ports() -> list[int]:
    """Three ports that nothing has: two of UDP and one of TCP."""
    with contextlib.ExitStack() as stack:
        kinds = (socket.SOCK_DGRAM, socket.SOCK_DGRAM, socket.SOCK_STREAM)
        # All at once, so that the two of UDP differ.
        probes = [stack.enter_context(socket.socket(socket.AF_INET, kind)) for kind in kinds]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]
