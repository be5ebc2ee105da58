"""One HTTP request to a stranger: bounded in size and time, without redirects and proxies."""

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
"""Longest body that is read; one byte more says that there is more."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer of a server."""

    status: int
    body: bytes


@dataclass
class _Exchange:
    """One request with its result."""

    connection: http.client.HTTPConnection
    socket: socket.socket | None = None
    """Kept here, because the connection forgets it once the answer has begun."""
    found: list[Answer | Exception] = field(default_factory=list)

    def run(self, path: str, body: bytes, headers: Mapping[str, str]) -> None:
        try:
            with closing(self.connection):
                self.connection.connect()
                self.socket = self.connection.sock
                self.connection.request("POST", path, body=body, headers=dict(headers))
                with closing(self.connection.getresponse()) as response:
                    self.found.append(Answer(response.status, response.read(MOST_BYTES + 1)))
        except (OSError, http.client.HTTPException, ValueError) as error:
            self.found.append(error)

    def cut(self) -> None:
        if self.socket is not None:
            with contextlib.suppress(OSError):  # It may have ended by itself.
                self.socket.shutdown(socket.SHUT_RDWR)


def posted(
    address: SplitResult,
    path: str,
    body: bytes,
    headers: Mapping[str, str],
    most_seconds: float,
) -> Answer | Exception | None:
    """Send a request by POST.

    A thread waits for the answer. A timeout of a socket bounds the wait for the next byte alone, so
    a server that sends one now and then would hold the program for hours.

    Args:
        address: Scheme, host and port.
        path: Path on the server.
        body: Body of the request.
        headers: Headers of the request.
        most_seconds: Time for everything.

    Returns:
        The answer, the error that came instead, or None if the time was over.
    """
    make = http.client.HTTPSConnection if address.scheme == "https" else http.client.HTTPConnection
    exchange = _Exchange(make(address.hostname or "", address.port, timeout=most_seconds))
    thread = threading.Thread(target=exchange.run, args=(path, body, headers), daemon=True)
    thread.start()
    thread.join(most_seconds)
    if not thread.is_alive():
        return exchange.found[0]
    exchange.cut()
    return None
