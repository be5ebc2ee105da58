"""Instance of the testbench whose ports no other test on this machine uses, whoever runs it."""

import fcntl
import functools
import tempfile
from pathlib import Path
from typing import TextIO

_NUMBERS = (*range(60, 70), *range(80, 90))
"""Ports of instances that differ by 10, 30 or 40 meet: no two of these do."""
_held: list[TextIO] = []


@functools.cache
def own_instance() -> int:
    """Number of an instance that belongs to this process until it ends."""
    for number in _NUMBERS:
        lock = (Path(tempfile.gettempdir()) / f"aeroscene-test-instance-{number}").open("a")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        return number
    raise RuntimeError(f"all {len(_NUMBERS)} instances for tests are in use on this machine")
