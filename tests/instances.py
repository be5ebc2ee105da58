"""Instances of the testbench whose ports nobody else on this machine uses, tests or not."""

import fcntl
import functools
import socket
import tempfile
from pathlib import Path
from typing import TextIO

_NUMBERS = (*range(60, 70, 2), *range(80, 90, 2))
"""Ports of instances that differ by 10, 30 or 40 meet: no two of these do. A second vehicle takes
the number after."""
_UDP_PORTS, _TCP_PORTS = (14540, 14550, 14580, 18570), (5760, 5762, 5763)
_held: list[TextIO] = []


@functools.cache
def own_instance() -> int:
    """Number of an instance for all tests of this process, which fly one after another."""
    return new_instance()


def new_instance() -> int:
    """Number of an instance that belongs to this process until it ends."""
    for number in _NUMBERS:
        lock = (Path(tempfile.gettempdir()) / f"aeroscene-test-instance-{number}").open("a")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _bind_all(number)
            _bind_all(number + 1)
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        return number
    raise RuntimeError(f"the ports of all {len(_NUMBERS)} instances for tests are in use")


def _bind_all(number: int) -> None:
    """Bind each port of an instance for a moment.

    Raises:
        OSError: If one is in use.
    """
    udp = [(socket.SOCK_DGRAM, port + number) for port in _UDP_PORTS]
    tcp = [(socket.SOCK_STREAM, port + 10 * number) for port in _TCP_PORTS]
    for kind, port in (*udp, *tcp):
        with socket.socket(socket.AF_INET, kind) as probe:
            probe.bind(("127.0.0.1", port))
