"""Preparation of a process that flies trials: its memory is bounded, its pilot's output hidden."""

from __future__ import annotations

import os
import resource
import sys

# No process gets less than this, however many cores share the memory.
_LEAST_MEMORY_BYTES = 4 << 30


def begin_work(pilot: str) -> None:
    """Prepare this process for the pilots of others.

    A pilot that takes more memory than its share of the machine gets a `MemoryError`, on systems
    that support it (Linux). The output of a user's class is not shown, because it could be without
    end, or mix with the JSON of the campaign; `aeroscene fly` shows it.

    Args:
        pilot: Name of the pilot.
    """
    if sys.platform == "linux":
        machine_bytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        # An equal share for each core's worker.
        most = max(_LEAST_MEMORY_BYTES, machine_bytes // (os.cpu_count() or 1))
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        if hard == resource.RLIM_INFINITY or most < hard:
            resource.setrlimit(resource.RLIMIT_DATA, (most, hard))
    if ":" in pilot:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        # The file descriptors, so that output of C libraries and child processes vanishes too.
        for output in (1, 2):
            os.dup2(nowhere, output)
        os.close(nowhere)
