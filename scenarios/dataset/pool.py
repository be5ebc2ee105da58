"""Parallel map over scenes in a number of processes, results in order.

Processes are spawned, which behaves alike on Linux and macOS and shares no state; each costs about
half a second of imports. They ignore Ctrl-C, which is the parent's to handle, and end with the
parent however it ends.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

_T = TypeVar("_T")
_R = TypeVar("_R")

_AHEAD_PER_JOB = 3
"""Tasks queued per process ahead of the results."""


class WorkerDiedError(RuntimeError):
    """A process was killed."""


def default_jobs() -> int:
    """Number of cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_all(
    function: Callable[[_T], _R], items: Sequence[_T], jobs: int
) -> Generator[_R, None, None]:
    """Results of a function for each item, in order; leaving the iterator ends the processes.

    Args:
        function: Function at the top level of a module, so that another process finds it.
        items: Arguments, one per call.
        jobs: Number of processes; 1 works in the present one.

    Raises:
        WorkerDiedError: If a process was killed, for example for lack of memory.
    """
    if min(jobs, len(items)) <= 1:
        yield from map(function, items)
        return
    not_ours = set(multiprocessing.active_children())
    executor = ProcessPoolExecutor(
        min(jobs, len(items)), multiprocessing.get_context("spawn"), initializer=_end_with_parent
    )
    pending: deque[Future[_R]] = deque()
    is_done = False
    try:
        for item in items:
            with _without_interrupts():
                pending.append(executor.submit(function, item))
            if len(pending) >= _AHEAD_PER_JOB * jobs:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
        is_done = True
    except BrokenProcessPool:
        raise WorkerDiedError(
            "a worker process was ended from outside (too little memory?); valid: fewer --jobs"
        ) from None
    finally:
        if not is_done:
            # The results of running tasks are no longer needed.
            for process in set(multiprocessing.active_children()) - not_ours:
                process.terminate()
        executor.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block Ctrl-C; processes started meanwhile inherit that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
