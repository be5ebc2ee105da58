"""MAVLink connections to an external flight stack, shared by our monitor and a pilot.

ArduPilot serves a TCP port and PX4 a pair of UDP ports; `Wire` makes both alike. The monitor and a
pilot inside this process read the same port, and each must see every message, so each reads by a
`Tap` of its own.
"""

from __future__ import annotations

import contextlib
import socket
from typing import Protocol

_CHUNK_BYTES = 1 << 16


class Wire(Protocol):
    """Connection to a MAVLink port of a flight stack, which may not be there yet."""

    def open(self) -> bool:
        """Return True if it is connected, after a try to connect if need be."""
        ...

    def send(self, data: bytes) -> None:
        """Send frames; those that cannot be sent are lost, as on a radio."""
        ...

    def recv(self) -> bytes:
        """Return all bytes received since the last call, possibly none; it does not wait."""
        ...

    def close(self) -> None:
        """Release the connection."""
        ...


class TcpWire:
    """Connection to a TCP server, such as ArduPilot's SERIAL2.

    It connects at the first `open` that finds the server, and again after the server has gone.
    """

    def __init__(self, port: int) -> None:
        self._address = ("127.0.0.1", port)
        self._socket: socket.socket | None = None

    def open(self) -> bool:
        """Return True if it is connected, after a try to connect if need be.

        The flight stack opens its port some time after its start, so a caller simply tries again
        later. A try waits for a second at most.
        """
        if self._socket is None:
            with contextlib.suppress(OSError):
                # Loopback refuses at once while nobody listens; the time limit is for a halted
                # stack.
                self._socket = socket.create_connection(self._address, timeout=1.0)
                # A small frame must not wait for the next one to fill a packet.
                self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._socket.setblocking(False)
        return self._socket is not None

    def send(self, data: bytes) -> None:
        """Send frames; those that cannot be sent are lost, as on a radio."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.sendall(data)

    def recv(self) -> bytes:
        """Return all bytes received since the last call, possibly none; it does not wait."""
        if self._socket is None:
            return b""
        try:
            data = self._socket.recv(_CHUNK_BYTES)
        except (BlockingIOError, InterruptedError):
            return b""
        except OSError:
            data = b""
        if not data:  # the server has gone; `open` tries anew
            self.close()
        return data

    def close(self) -> None:
        """Release the connection."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None


class UdpWire:
    """A pair of UDP ports, ours and the flight stack's, such as PX4's link for us.

    UDP has no connection, so `open` being true does not mean that the stack is there.
    """

    def __init__(self, port: int, stack_port: int) -> None:
        self._port = port
        self._socket: socket.socket | None = None
        self._stack = ("127.0.0.1", stack_port)

    def open(self) -> bool:
        """Return True if the port is bound, after a try to bind it if need be.

        Another process may hold it; then nothing is sent and read until it lets go.
        """
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
        """Send frames; those that cannot be sent are lost, as on a radio."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(data, self._stack)

    def recv(self) -> bytes:
        """Return all bytes received since the last call, possibly none; it does not wait."""
        received = []
        with contextlib.suppress(OSError):  # ends the loop once no datagram is left
            while self._socket is not None:
                received.append(self._socket.recv(_CHUNK_BYTES))
        return b"".join(received)

    def close(self) -> None:
        """Release the port."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None


class Tap:
    """One of several readers of a wire; bytes that one of them reads reach all of them.

    It is a `BytePipe` for `MavlinkClient`; sending needs no share, so that goes straight to the
    wire.
    """

    def __init__(self, wire: Wire, taps: list[Tap]) -> None:
        """Join the readers of a wire.

        Args:
            wire: Connection to read and to send by.
            taps: Readers that share it, in a list that all of them hold; this one is appended.
        """
        self._wire, self._taps = wire, taps
        self._unread = bytearray()
        taps.append(self)

    def send(self, data: bytes) -> None:
        """Send bytes to the vehicle."""
        self._wire.send(data)

    def recv(self) -> bytes:
        """Return all bytes that came for this reader since its last call, possibly none."""
        if data := self._wire.recv():
            # Whoever reads first takes the bytes off the wire, for the others too.
            for tap in self._taps:
                tap._unread += data
        mine = bytes(self._unread)
        self._unread.clear()
        return mine
