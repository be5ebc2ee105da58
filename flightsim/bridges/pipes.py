"""MAVLink connections to an external flight stack, shared by our recorder and a pilot."""

from __future__ import annotations

import contextlib
import socket
from typing import Protocol

_CHUNK_BYTES = 1 << 16


class Wire(Protocol):
    """Connection to a MAVLink port of a flight stack."""

    def open(self) -> bool:
        """Whether it is connected, or could be just now."""
        ...

    def send(self, data: bytes) -> None:
        """Send frames; what cannot be sent is lost, as on a radio."""
        ...

    def recv(self) -> bytes:
        """All bytes received since the last call, possibly none."""
        ...

    def close(self) -> None:
        """Release the connection."""
        ...


class TcpWire:
    """Connection to a TCP server, such as ArduPilot's SERIAL2."""

    def __init__(self, port: int) -> None:
        self._address = ("127.0.0.1", port)
        self._socket: socket.socket | None = None

    def open(self) -> bool:
        """Whether it is connected, or could be just now."""
        if self._socket is None:
            with contextlib.suppress(OSError):
                self._socket = socket.create_connection(self._address, timeout=1.0)
                self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._socket.setblocking(False)
        return self._socket is not None

    def send(self, data: bytes) -> None:
        """Send frames; what cannot be sent is lost, as on a radio."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.sendall(data)

    def recv(self) -> bytes:
        """All bytes received since the last call, possibly none."""
        if self._socket is None:
            return b""
        try:
            data = self._socket.recv(_CHUNK_BYTES)
        except (BlockingIOError, InterruptedError):
            return b""
        except OSError:
            data = b""
        if not data:
            self.close()
        return data

    def close(self) -> None:
        """Release the connection."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None


class UdpWire:
    """A pair of UDP ports, ours and the flight stack's, such as PX4's for gimbals."""

    def __init__(self, port: int, stack_port: int) -> None:
        self._port = port
        self._socket: socket.socket | None = None
        self._stack = ("127.0.0.1", stack_port)

    def open(self) -> bool:
        """Whether the port is bound."""
        if self._socket is None:
            udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                udp.bind(("127.0.0.1", self._port))
            except OSError:
                udp.close()
                return False
            udp.setblocking(False)
            self._socket = udp
        return True

    def send(self, data: bytes) -> None:
        """Send frames; what cannot be sent is lost, as on a radio."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(data, self._stack)

    def recv(self) -> bytes:
        """All bytes received since the last call, possibly none."""
        received = []
        with contextlib.suppress(OSError):
            while self._socket is not None:
                received.append(self._socket.recv(_CHUNK_BYTES))
        return b"".join(received)

    def close(self) -> None:
        """Release the port."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None


class Tap:
    """One of several readers of a wire: what any of them reads, each of them gets."""

    def __init__(self, wire: Wire, taps: list[Tap]) -> None:
        """Join the readers of a wire, which are kept in one list."""
        self._wire, self._taps = wire, taps
        self._unread = bytearray()
        taps.append(self)

    def send(self, data: bytes) -> None:
        """Send bytes to the vehicle."""
        self._wire.send(data)

    def recv(self) -> bytes:
        """All bytes received since the last call, possibly none."""
        if data := self._wire.recv():
            for tap in self._taps:
                tap._unread += data
        mine = bytes(self._unread)
        self._unread.clear()
        return mine
