"""Real MAVLink clients for a benchmark: a process that reads UDP ports and sends heartbeats.

`python -m scenarios.bench.clients N` opens N ports, prints them, and reads. For each line of its
standard input, and at its end, it prints the number of messages until then. It is a separate
process, so that its work is not counted as the testbench's.
"""

from __future__ import annotations

import selectors
import socket
import subprocess
import sys
import time
from typing import Self

LOOPBACK = "127.0.0.1"
_HEARTBEAT_PERIOD_S = 0.5
_BUFFER_BYTES = 1 << 22  # Large, because a full buffer would drop messages uncounted.


class Clients:
    """Handle of the client process.

    Attributes:
        ports: Ports that the clients listen on.
    """

    def __init__(self, count: int) -> None:
        """Start the clients, and wait until they listen.

        Args:
            count: Number of clients, each with a port of its own.
        """
        self._process = subprocess.Popen(  # noqa: S603 - arguments are ours
            [sys.executable, "-m", __name__, str(count)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            # Ctrl-C is for the benchmark; the clients end with their standard input.
            start_new_session=True,
        )
        assert self._process.stdout is not None
        self.ports = tuple(int(port) for port in self._process.stdout.readline().split())

    def n_messages(self) -> int:
        """Return the number of MAVLink messages that all clients have received so far."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return int(self._process.stdout.readline())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._process.poll() is None:
            self._process.communicate()


def main() -> None:
    """Read the ports until standard input ends."""
    sockets = [_open() for _ in range(int(sys.argv[1]))]
    print(*(s.getsockname()[1] for s in sockets), flush=True)  # noqa: T201 - its interface
    _serve(sockets)


def _open() -> socket.socket:
    client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
    client.bind((LOOPBACK, 0))
    client.setblocking(False)
    return client


def _receive(client: socket.socket) -> tuple[bytes, tuple[str, int]] | None:
    try:
        return client.recvfrom(65536)
    except BlockingIOError:
        return None


def _serve(sockets: list[socket.socket]) -> None:
    n_messages = 0
    addresses: dict[socket.socket, tuple[str, int]] = {}
    heartbeat = _heartbeat()
    heartbeat_due_s = 0.0
    with selectors.DefaultSelector() as selector:
        selector.register(sys.stdin, selectors.EVENT_READ)
        for client in sockets:
            selector.register(client, selectors.EVENT_READ)
        while True:
            ready = {key.fileobj for key, _ in selector.select(_HEARTBEAT_PERIOD_S)}
            for client in sockets:
                # Everything that has arrived is read before a count is printed.
                while (received := _receive(client)) is not None:
                    data, addresses[client] = received
                    n_messages += count_messages(data)
            if sys.stdin in ready:
                is_asked = bool(sys.stdin.readline())
                print(n_messages, flush=True)  # noqa: T201
                if not is_asked:
                    return  # The end of standard input.
            if time.monotonic() >= heartbeat_due_s:
                heartbeat_due_s = time.monotonic() + _HEARTBEAT_PERIOD_S
                # Only those that were written to know the testbench's address.
                for client, address in addresses.items():
                    client.sendto(heartbeat, address)


def count_messages(datagram: bytes) -> int:
    """Count the MAVLink 2 frames in a datagram, by their lengths.

    Args:
        datagram: Whole frames, one behind the other; counting ends at anything else.
    """
    n_messages, start = 0, 0
    # 12 bytes: a header of 10 and a checksum of 2. 0xFD is the magic number of MAVLink 2.
    while start + 12 <= len(datagram) and datagram[start] == 0xFD:
        is_signed = datagram[start + 2] & 1
        start += 12 + datagram[start + 1] + 13 * is_signed  # a signature has 13 bytes
        n_messages += 1
    return n_messages


def _heartbeat() -> bytes:
    """Return the frame of a ground station's heartbeat."""
    from pymavlink.dialects.v20 import common  # in the child only

    # 255 and 190 are the usual system and component of a ground station.
    sender = common.MAVLink(None, srcSystem=255, srcComponent=190)
    message = sender.heartbeat_encode(
        common.MAV_TYPE_GCS, common.MAV_AUTOPILOT_INVALID, 0, 0, common.MAV_STATE_ACTIVE
    )
    return message.pack(sender)


if __name__ == "__main__":
    main()
