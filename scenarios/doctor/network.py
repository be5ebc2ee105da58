"""Checks of ports and displays: MAVLink and the viewer."""

from __future__ import annotations

import errno
import socket
from collections.abc import Iterator, Mapping

from scenarios.doctor.check import Check, judged

_LOOPBACK = "127.0.0.1"
# Ports of instance 0, on which the testbench listens.
_VEHICLE_PORTS: Mapping[str, tuple[int, int]] = {
    "UDP 18570": (socket.SOCK_DGRAM, 18570),
    "UDP 14580": (socket.SOCK_DGRAM, 14580),
    "TCP 5760": (socket.SOCK_STREAM, 5760),
}
_CLIENT_PORTS: Mapping[str, int] = {"UDP 14550": 14550, "UDP 14540": 14540}


def check_ports() -> Iterator[Check]:
    """Check that the vehicle's MAVLink ports are free, and report clients that listen already.

    A port of the vehicle that is in use is a fault. A port of a client that is in use is a client.
    """
    for name, (kind, port) in _VEHICLE_PORTS.items():
        has_room = is_free(kind, port)
        remedy = "end what uses it, or fly with --instance 1"
        yield judged(name, "free" if has_room else "in use", remedy, is_fine=has_room)
    for name, port in _CLIENT_PORTS.items():
        has_room = is_free(socket.SOCK_DGRAM, port)
        value = "no client listens yet" if has_room else "a client listens"
        yield Check(name=f"client at {name}", status="ok", value=value)


def check_viewer() -> Iterator[Check]:
    """Report which of rerun's viewers can open."""
    from scenarios.recording.program import RerunMissingError, rerun_program
    from scenarios.recording.viewer import has_display

    try:
        rerun_program()
    except RerunMissingError as error:
        yield Check(name="viewer", status="note", value="missing", remedy=str(error))
        return
    kinds = "web and native" if has_display() else "web; native needs a display"
    yield Check(name="viewer", status="ok", value=kinds)


def is_free(kind: int, port: int) -> bool:
    """Return true if no program has a port on loopback.

    Args:
        kind: `socket.SOCK_STREAM` for TCP or `socket.SOCK_DGRAM` for UDP.
        port: Number of the port.
    """
    # Binding is the test. TCP needs SO_REUSEADDR, or a connection that lingers would count.
    with socket.socket(socket.AF_INET, kind) as probe:
        if kind == socket.SOCK_STREAM:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((_LOOPBACK, port))
        except OSError as error:
            # Other errors, such as a missing permission, do not mean that a program has the port.
            return error.errno != errno.EADDRINUSE
    return True
