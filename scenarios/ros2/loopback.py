"""Confine sockets that a library has opened to this machine's loopback interface.

Cyclone DDS sends through the interface that it is told, and receives on every one: its sockets are
bound to 0.0.0.0. The system can still bind a socket to an interface, once it is there.
"""

from __future__ import annotations

import contextlib
import os
import socket
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

_IP_BOUND_IF = 25
"""macOS, netinet/in.h."""


def open_sockets() -> set[int]:
    """File descriptors of this process that are sockets."""
    found: set[int] = set()
    for entry in Path("/dev/fd").iterdir():
        # The descriptor by which the folder is read is gone at the end.
        with contextlib.suppress(OSError, ValueError):
            if stat.S_ISSOCK(os.fstat(int(entry.name)).st_mode):
                found.add(int(entry.name))
    return found


def confine(descriptors: set[int]) -> None:
    """Let sockets of the internet receive from the loopback interface alone.

    Raises:
        OSError: If the system does not allow it.
    """
    for descriptor in descriptors:
        with _socket(descriptor) as each:
            if each.family not in {socket.AF_INET, socket.AF_INET6}:
                continue
            if sys.platform == "darwin":
                index = socket.if_nametoindex("lo0")
                each.setsockopt(socket.IPPROTO_IP, _IP_BOUND_IF, index)
            else:
                each.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo\0")


@contextlib.contextmanager
def _socket(descriptor: int) -> Iterator[socket.socket]:
    """A socket by its descriptor, which stays open."""
    each = socket.socket(fileno=os.dup(descriptor))
    try:
        yield each
    finally:
        each.close()
