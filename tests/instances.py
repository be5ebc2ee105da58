"""Ports, and instances of the testbench, that nobody else on this machine uses, tests or not."""

import fcntl
import functools
import itertools
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

_NUMBERS = (*range(60, 70, 2), *range(80, 90, 2))
"""Ports of instances that differ by 10, 30 or 40 meet: no two of these do. A second vehicle takes
the number after."""
_UDP_PORTS, _TCP_PORTS = (14540, 14550, 14580, 18570), (5760, 5762, 5763)
_PORTS_A_PROCESS = 100
_held: list[TextIO] = []


@functools.cache
def own_instance() -> int:
    """Number of an instance for all tests of this process, which fly one after another."""
    return new_instance()


def new_instance() -> int:
    """Number of an instance that belongs to this process until it ends."""
    for number in _NUMBERS:
        if not _is_ours(f"instance-{number}"):
            continue
        try:
            _bind_all(number)
            _bind_all(number + 1)
        except OSError:
            _held.pop().close()
            continue
        return number
    raise RuntimeError(f"the ports of all {len(_NUMBERS)} instances for tests are in use")


def free_port(kind: socket.SocketKind) -> int:
    """A port of TCP or UDP that nothing has, and that no other process of tests is given.

    What the system gives out for port 0 is free for a moment only: any program may be given the
    same one before the test has bound it. These lie below all that systems give out.
    """
    for port in itertools.islice(_own_ports(), _PORTS_A_PROCESS):
        try:
            _bind(kind, port)
        except OSError:
            continue
        return port
    raise RuntimeError("all ports for tests of this process are in use")


@functools.cache
def _own_ports() -> Iterator[int]:
    """The ports of this process, round and round."""
    for first in range(20_000, 30_000, _PORTS_A_PROCESS):
        if _is_ours(f"ports-{first}"):
            return itertools.cycle(range(first, first + _PORTS_A_PROCESS))
    raise RuntimeError("all ports for tests are in use")


def _is_ours(name: str) -> bool:
    """Take what `name` stands for until this process ends, unless another one has it."""
    lock = (Path(tempfile.gettempdir()) / f"aeroscene-test-{name}").open("a")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.close()
        return False
    _held.append(lock)
    return True


def _bind_all(number: int) -> None:
    """Bind each port of an instance for a moment.

    Raises:
        OSError: If one is in use.
    """
    udp = [(socket.SOCK_DGRAM, port + number) for port in _UDP_PORTS]
    tcp = [(socket.SOCK_STREAM, port + 10 * number) for port in _TCP_PORTS]
    for kind, port in (*udp, *tcp):
        _bind(kind, port)


def _bind(kind: socket.SocketKind, port: int) -> None:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", port))
