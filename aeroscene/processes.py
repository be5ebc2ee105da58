"""Parallel work on scenes in a number of processes, results in order.

Processes share no state with the parent; `fresh_processes` explains how they start. They ignore
Ctrl-C and SIGTERM, which the parent handles, and end with the parent however it ends.
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.context import ForkServerContext, SpawnContext
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

_T = TypeVar("_T")
_R = TypeVar("_R")

_PATIENCE_S = 0.5
"""Time for a process to finish its present task when it has to end."""
_AHEAD_PER_JOB = 3
"""Number of tasks queued for each process ahead of the results."""


class WorkerDiedError(RuntimeError):
    """Raised if a process was killed."""


def default_jobs() -> int:
    """Number of cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_all(
    function: Callable[[_T], _R], items: Sequence[_T], jobs: int
) -> Generator[_R, None, None]:
    """Yield the result of a function for each item, in order.

    Leaving the iterator ends the processes.

    Args:
        function: Function at the top level of a module, so that another process finds it.
        items: Arguments, one for each call.
        jobs: Number of processes; 1 works in the present one.

    Raises:
        WorkerDiedError: If a process was killed, for example for lack of memory.
    """
    jobs = min(jobs, len(items))
    if jobs <= 1:
        yield from map(function, items)
        return
    with Workers(function, items, jobs, _AHEAD_PER_JOB * jobs) as results:
        yield from results


class Workers(Generic[_T, _R]):
    """Processes that work ahead of the consumer of their results, which come in order.

    The work begins at once. At most `ahead` results are made or in the making, so there may be any
    number of items.
    """

    def __init__(
        self, function: Callable[[_T], _R], items: Iterable[_T], jobs: int, ahead: int
    ) -> None:
        """Start the processes.

        Args:
            function: Function at the top level of a module, so that another process finds it.
            items: Arguments, one for each call.
            jobs: Number of processes.
            ahead: Number of calls begun or queued before their results are taken.
        """
        self._items = iter(items)
        self._not_ours = set(multiprocessing.active_children())
        # The function goes with the process, not with each item: a queue of large items cannot be
        # closed once nobody reads it.
        self._executor = ProcessPoolExecutor(
            jobs,
            fresh_processes(_module_of(function)),
            initializer=_begin,
            initargs=(function, dict(os.environ)),
        )
        self._results: Any = self._executor._result_queue
        self._pending: deque[Future[_R]] = deque()
        try:
            with _naming_death():
                for _ in range(ahead):
                    self._submit()
        except BaseException:
            self.close()
            raise

    def __iter__(self) -> Self:
        """Return this iterator."""
        return self

    def __next__(self) -> _R:
        """Return the next result; wait for it if it is not ready.

        Raises:
            WorkerDiedError: If a process was killed, for example for lack of memory.
        """
        if not self._pending:
            raise StopIteration
        with _naming_death():
            result = self._pending.popleft().result()
            self._submit()
        return result

    def __enter__(self) -> Self:
        """Return this iterator."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes."""
        self.close()

    def close(self) -> None:
        """End the processes, in half a second at most; results that were not taken are lost."""
        patience = threading.Timer(_PATIENCE_S, self._kill)
        patience.start()
        self._executor.shutdown(wait=True, cancel_futures=True)
        patience.cancel()

    def _kill(self) -> None:
        for process in set(multiprocessing.active_children()) - self._not_ours:
            # Not terminate: they ignore SIGTERM, which is the parent's to handle.
            process.kill()
        # A process that is killed while it hands over a result leaves half of it, and the executor
        # would wait for the rest as long as this process could write it too.
        with contextlib.suppress(OSError):  # The executor may be closing it at this moment.
            self._results._writer.close()

    def _submit(self) -> None:
        for item in self._items:
            with without_interrupts():
                self._pending.append(self._executor.submit(_call, item))
            return


@contextmanager
def _naming_death() -> Iterator[None]:
    try:
        yield
    except BrokenProcessPool:
        raise WorkerDiedError(
            "a worker process was ended from outside (too little memory?); valid: fewer --jobs"
        ) from None


def fresh_processes(*modules: str) -> SpawnContext | ForkServerContext:
    """Context that starts processes without any of this one's state.

    On Linux a server, itself a fresh interpreter, imports the modules once and is copied for each
    process. Elsewhere each process is a fresh interpreter that imports them itself, because the
    libraries of macOS do not survive being copied.

    The first call in a process decides what its server imports. A process has the environment with
    which the server began: pass it the changes for `become`.

    Args:
        modules: Modules that all processes use.
    """
    if sys.platform != "linux":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(modules))
    return context


def become(environment: Mapping[str, str]) -> None:
    """Take over the parent's present environment in a process that it has started."""
    os.environ.clear()
    os.environ.update(environment)


def _module_of(function: Callable[..., Any]) -> str:
    while isinstance(function, functools.partial):
        function = function.func
    return function.__module__


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Block Ctrl-C and SIGTERM; processes started in the meantime inherit that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_function: Callable[[Any], Any]
"""Function of this worker process."""


def _begin(function: Callable[[Any], Any], environment: Mapping[str, str]) -> None:
    global _function  # noqa: PLW0603 - a process has no other place for it
    for each in (signal.SIGINT, signal.SIGTERM):  # a server that began elsewhere hands on its mask
        signal.signal(each, signal.SIG_IGN)
    _function = function
    become(environment)
    end_with_parent()


def _call(item: Any) -> Any:
    return _function(item)


def end_with_parent() -> None:
    """End this process, from now on, as soon as the one that started it ends in any way."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
