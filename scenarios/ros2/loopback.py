"""Confinement of sockets that a library has opened to this machine's loopback interface.

Nothing of AeroScene may listen beyond loopback unless the user asks for it. Cyclone DDS sends
through the interface that it is configured for, but receives on all of them, because its sockets
are bound to 0.0.0.0. The operating system can still bind an open socket to one interface.
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
"""Option IP_BOUND_IF of macOS, from netinet/in.h, which Python does not name."""


def open_sockets() -> set[int]:
    """Return the file descriptors of this process that are sockets."""
    found: set[int] = set()
    for entry in Path("/dev/fd").iterdir():
        # The folder lists the descriptor by which it is read, which may be closed already.
        with contextlib.suppress(OSError, ValueError):
            if stat.S_ISSOCK(os.fstat(int(entry.name)).st_mode):
                found.add(int(entry.name))
    return found


def confine(descriptors: set[int]) -> None:
    """Let internet sockets receive from the loopback interface alone.

    Args:
        descriptors: File descriptors of sockets; others than IPv4 and IPv6 stay as they are.

    Raises:
        OSError: If the system does not allow it.
    """
    for descriptor in descriptors:
        with _socket(descriptor) as each:
            if each.family not in {socket.AF_INET, socket.AF_INET6}:
                continue
            # Linux binds by name, macOS by index; both leave the socket's address as it is.
            if sys.platform == "darwin":
                index = socket.if_nametoindex("lo0")
                each.setsockopt(socket.IPPROTO_IP, _IP_BOUND_IF, index)
            else:
                each.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo\0")


@contextlib.contextmanager
def _socket(descriptor: int) -> Iterator[socket.socket]:
    """Yield a socket object for a descriptor, which stays open."""
    # A duplicate, because closing the object would close the library's descriptor.
    each = socket.socket(fileno=os.dup(descriptor))
    try:
        yield each
    finally:
        each.close()
