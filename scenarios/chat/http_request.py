"""One HTTP request to a stranger: bounded in size and time, without redirects and proxies.

Redirects could send the key to another host. The standard library's `http.client` follows none, and
knows no proxies, so it is used instead of a larger client.
"""

from __future__ import annotations

import contextlib
import http.client
import socket
import threading
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from urllib.parse import SplitResult

MOST_BYTES = 256 * 1024
"""Greatest length of a body. One byte more is read, which shows that there is more."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer of a server: its status and the beginning of its body."""

    status: int
    body: bytes


@dataclass
class _Exchange:
    """One request with its result."""

    connection: http.client.HTTPConnection
    sock: socket.socket | None = None
    """Kept here, because the connection forgets it once the answer has begun."""
    found: list[Answer | Exception] = field(default_factory=list)

    def run(self, path: str, body: bytes, headers: Mapping[str, str]) -> None:
        try:
            with closing(self.connection):
                self.connection.connect()
                self.sock = self.connection.sock
                self.connection.request("POST", path, body=body, headers=dict(headers))
                with closing(self.connection.getresponse()) as response:
                    self.found.append(Answer(response.status, response.read(MOST_BYTES + 1)))
        except (OSError, http.client.HTTPException, ValueError) as error:
            self.found.append(error)

    # Shutting the socket down wakes a thread that waits in `read`; closing it would not.
    def cut(self) -> None:
        if self.sock is not None:
            with contextlib.suppress(OSError):  # It may have ended by itself.
                self.sock.shutdown(socket.SHUT_RDWR)


def posted(
    address: SplitResult,
    path: str,
    body: bytes,
    headers: Mapping[str, str],
    most_seconds: float,
) -> Answer | Exception | None:
    """Send a request by POST.

    A thread waits for the answer. A socket's own timeout bounds only the wait for the next byte, so
    a server that sends one byte now and then would hold the program for hours.

    Args:
        address: Scheme, host and port.
        path: Path on the server.
        body: Body of the request.
        headers: Headers of the request.
        most_seconds: Time limit for the whole exchange.

    Returns:
        The answer, the error that came instead, or None if the time ran out.
    """
    make = http.client.HTTPSConnection if address.scheme == "https" else http.client.HTTPConnection
    exchange = _Exchange(make(address.hostname or "", address.port, timeout=most_seconds))
    thread = threading.Thread(target=exchange.run, args=(path, body, headers), daemon=True)
    thread.start()
    # A daemon thread, so that a server that never answers cannot keep the program from ending.
    thread.join(most_seconds)
    if not thread.is_alive():
        return exchange.found[0]
    exchange.cut()
    return None
