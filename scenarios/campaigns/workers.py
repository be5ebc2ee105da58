"""Processes that fly trials: each stays warm, and one that dies or hangs costs only its trial."""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection, wait
from types import TracebackType
from typing import Self

from aeroscene.processes import end_with_parent, without_interrupts
from scenarios.campaigns.flyer import Flyer, Mishap, Row, Suite, Trial, blank_row, failure

_MOST_DEATHS = 2
"""Times that a trial may end its process before it counts as failed."""
_LOOK_S = 1.0
"""Time after which the parent looks for processes that hang."""
_BLOCKS_A_WORKER = 4
_MOST_IN_A_BLOCK = 25


class WorkerError(RuntimeError):
    """No trial can be flown on this machine; one line says why."""


def in_blocks(trials: Sequence[Trial], n_workers: int) -> deque[list[Trial]]:
    """Trials in their order in blocks of one scene and vehicle, small enough for all workers."""
    size = max(1, min(_MOST_IN_A_BLOCK, len(trials) // (n_workers * _BLOCKS_A_WORKER)))
    blocks: deque[list[Trial]] = deque()
    for trial in trials:
        last = blocks[-1] if blocks else []
        if last and len(last) < size and last[-1][:2] == trial[:2]:
            last.append(trial)
        else:
            blocks.append([trial])
    return blocks


class _Worker:
    """One process, and what it is at."""

    def __init__(self, suite: Suite) -> None:
        context = multiprocessing.get_context("spawn")
        self.link, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(theirs, suite), daemon=True)
        with without_interrupts():
            self.process.start()
        theirs.close()
        self.block: deque[Trial] = deque()
        """Trials that it has not returned yet; the first is in the air."""
        self.since_s = time.monotonic()

    def give(self, block: Sequence[Trial]) -> None:
        """Have it fly a block of trials."""
        self.block.extend(block)
        self.since_s = time.monotonic()
        # If it has died, whoever reads from it finds that out.
        with contextlib.suppress(OSError):
            self.link.send(list(block))

    def end(self) -> None:
        """End it at once."""
        self.process.kill()
        self.process.join()
        self.link.close()


class Workers:
    """Processes that fly the trials of a suite; leaving it ends them."""

    def __init__(self, suite: Suite, n_workers: int, patience_s: float) -> None:
        """Start nothing yet.

        Args:
            suite: What they fly.
            n_workers: Number of processes.
            patience_s: Wall time for one trial, after which its process is ended.
        """
        self._suite = suite
        self._n_workers = n_workers
        self._patience_s = patience_s
        self._workers: list[_Worker] = []
        self._blocks: deque[list[Trial]] = deque()
        self._deaths: Counter[Trial] = Counter()

    def fly(self, trials: Sequence[Trial]) -> Iterator[Row]:
        """Rows of all trials, in the order in which they end.

        Raises:
            WorkerError: If a process says that it cannot fly at all.
        """
        self._blocks = in_blocks(trials, self._n_workers)
        while self._blocks or self._workers:
            self._employ()
            ready = wait([worker.link for worker in self._workers], timeout=_LOOK_S)
            for worker in list(self._workers):
                if worker.link in ready:
                    row = self._hear(worker)
                    if row is not None:
                        yield row
                elif time.monotonic() - worker.since_s > self._patience_s:
                    self._dismiss(worker)
                    yield self._given_up(worker, Mishap.HUNG, f"no end in {self._patience_s:g} s")

    def _employ(self) -> None:
        """Give everybody something to do, and let those go for whom there is nothing."""
        while self._blocks and len(self._workers) < self._n_workers:
            self._workers.append(_Worker(self._suite))
            self._workers[-1].give(self._blocks.popleft())
        for worker in list(self._workers):
            if not worker.block:
                if self._blocks:
                    worker.give(self._blocks.popleft())
                else:
                    self._dismiss(worker)

    def _hear(self, worker: _Worker) -> Row | None:
        """Take what a worker says: a row, or nothing any more."""
        try:
            said = worker.link.recv()
        except (EOFError, OSError):
            return self._bury(worker)
        if isinstance(said, str):
            raise WorkerError(said)
        worker.block.popleft()
        worker.since_s = time.monotonic()
        return said

    def _bury(self, worker: _Worker) -> Row | None:
        """Have others fly what a dead worker has not; a trial that kills again has failed."""
        self._dismiss(worker)
        self._deaths[worker.block[0]] += 1
        if self._deaths[worker.block[0]] >= _MOST_DEATHS:
            reason = f"its process ended with {worker.process.exitcode}, {_MOST_DEATHS} times"
            return self._given_up(worker, Mishap.DIED, reason)
        self._blocks.appendleft(list(worker.block))
        return None

    def _given_up(self, worker: _Worker, code: Mishap, reason: str) -> Row:
        """Row of the trial that a worker was at; the rest of its block is for others."""
        trial = worker.block.popleft()
        if worker.block:
            self._blocks.appendleft(list(worker.block))
        return blank_row(trial) | failure(code, reason)

    def _dismiss(self, worker: _Worker) -> None:
        worker.end()
        self._workers.remove(worker)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End all processes."""
        while self._workers:
            self._dismiss(self._workers[0])


def _work(link: Connection, suite: Suite) -> None:
    """Fly the blocks that come over a link, until it is closed."""
    end_with_parent()
    # Ctrl-C and SIGTERM are the parent's to handle.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    try:
        with Flyer(suite) as flyer:
            while True:
                for trial in link.recv():
                    link.send(flyer.fly(trial))
    except EOFError:
        return
    except Exception as error:  # noqa: BLE001 - whatever it is, the parent says it
        link.send(" ".join(str(error).split()) or type(error).__name__)
