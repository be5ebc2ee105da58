"""Workers that fly trials: each stays warm, and one that dies or hangs costs only its trial.

A user's pilot may crash, hang or take all memory, and a campaign of thousands of trials must
survive that. The engine decides where the workers are: processes of this machine, a cluster, or a
simulation of either. The crew gives out trials, takes rows and replaces workers, and is the same
for all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

from scenarios.campaigns.engines.schedule import Schedule
from scenarios.campaigns.flyer import NoFlightCode, Row, Trial, blank_row, failure

_GRACE_S = 3.0
"""Time beyond the patience, after which the crew ends a worker.

A worker that flies an external program ends the trial itself when the patience is over. It needs a
moment for that, and then goes on with the next trial."""
_READY_S = 600.0
"""Time in which the first worker must be ready to fly."""
_MOST_STILLBORN = 3
"""Number of workers that end before they fly, one after the other, until the campaign ends."""
_LOOK_S = 1.0
"""Time between two checks for workers that hang."""


class WorkerError(RuntimeError):
    """No trial can be flown; one line says why."""


class WorkerGoneError(Exception):
    """A worker has ended; the message says how."""


class Worker(Protocol):
    """Process that flies one trial after another, somewhere."""

    def give(self, trial: Trial) -> None:
        """Have it fly a trial; a dead worker is noticed when it is heard."""
        ...

    def receive(self) -> Row | None:
        """Take its next answer: first None, when it is ready, then the row of each trial.

        Raises:
            WorkerGoneError: If it has ended.
            WorkerError: If it cannot fly at all.
        """
        ...

    def end(self) -> None:
        """End it at once, with every process that it has started."""
        ...


class Engine(Protocol):
    """Hires workers."""

    def hire(self) -> Worker:
        """Start a worker."""
        ...

    def wait(self, timeout_s: float, /) -> Sequence[Worker]:
        """Return the workers that have an answer; wait for the first at most that long."""
        ...


@dataclass(eq=False)
class _Post:
    """State of a worker."""

    since_s: float
    """Time at which the present state began."""
    is_ready: bool = False
    trial: Trial | None = None
    """The trial that it flies."""
    last: Trial | None = None
    """The trial before that."""


class Crew:
    """Workers of an engine; leaving the context ends them."""

    def __init__(
        self,
        engine: Engine,
        n_workers: int,
        patience_s: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare a crew, without starting any worker.

        Args:
            engine: Source of the workers.
            n_workers: Number of workers.
            patience_s: Time for one trial, after which its worker is ended.
            clock: Time in s; another one lets a test or a forecast run in simulated time.
        """
        self._engine = engine
        self._n_workers = n_workers
        self._patience_s = patience_s
        self._clock = clock
        self._posts: dict[Worker, _Post] = {}
        self._schedule = Schedule(())
        self._has_begun = False
        """True once any worker was ready to fly."""
        self._n_stillborn = 0
        """Number of workers that ended before they flew, since the last answer of any."""

    def fly(self, trials: Sequence[Trial]) -> Iterator[Row]:
        """Yield the rows of all trials, in the order in which they end.

        A trial whose worker dies is flown once more, because the worker may have been the cause. A
        trial whose worker hangs is not: it fails at once as `hung`, since a second try could take
        the whole patience again.

        Raises:
            WorkerError: If a worker reports that it cannot fly at all, if three workers in a row
                end before they flew, or if no worker at all was ready within 600 s.
        """
        self._schedule = Schedule(trials)
        looked_s = self._clock()
        while self._employ():
            for worker in self._engine.wait(_LOOK_S):
                row = self._receive(worker)
                if row is not None:
                    yield row
            if self._clock() - looked_s >= _LOOK_S:
                looked_s = self._clock()
                yield from self._give_up()

    def _employ(self) -> bool:
        """Give every worker a trial, and dismiss workers for which none is left.

        Returns:
            True if any worker is still at work.
        """
        schedule, posts = self._schedule, self._posts
        n_idle = sum(post.trial is None for post in posts.values())
        # Hire only as many as there are trials.
        while n_idle < schedule.n_left and len(posts) < self._n_workers:
            posts[self._engine.hire()] = _Post(self._clock())
            n_idle += 1
        for worker, post in list(posts.items()) if n_idle else ():
            if post.trial is not None:
                continue
            if post.is_ready and (trial := schedule.next(post.last)) is not None:
                post.trial, post.since_s = trial, self._clock()
                worker.give(trial)
            # A trial that is given back later gets a new worker.
            elif not schedule.n_left:
                self._dismiss(worker)
        return bool(posts)

    def _receive(self, worker: Worker) -> Row | None:
        """Take a worker's answer: return a row, or None if it is ready or gone."""
        post = self._posts[worker]
        try:
            row = worker.receive()
        except WorkerGoneError as error:
            return self._bury(worker, str(error))
        # Any answer shows that workers can start at all.
        post.is_ready = self._has_begun = True
        self._n_stillborn = 0
        post.last, post.trial = post.trial, None
        return row

    def _bury(self, worker: Worker, how: str) -> Row | None:
        """Give a dead worker's trial to others; a trial that kills again has failed."""
        trial = self._dismiss(worker).trial
        if trial is None:
            self._n_stillborn += 1
            if self._n_stillborn >= _MOST_STILLBORN:
                raise WorkerError(f"{_MOST_STILLBORN} workers ended before they flew: {how}")
            return None
        # The worker may have been the cause, so another one gets a try.
        if self._schedule.give_back(trial):
            return None
        return blank_row(trial) | failure(NoFlightCode.DIED, f"{how}, twice")

    def _give_up(self) -> Iterator[Row]:
        """Yield the rows of the trials that take too long; their workers are ended.

        Raises:
            WorkerError: If no worker gets ready.
        """
        for worker, post in list(self._posts.items()):
            waited_s = self._clock() - post.since_s
            if post.trial is not None and waited_s > self._patience_s + _GRACE_S:
                self._dismiss(worker)
                self._schedule.abandon(post.trial)
                reason = f"no end in {self._patience_s:g} s"
                yield blank_row(post.trial) | failure(NoFlightCode.HUNG, reason)
            # Once one was ready, later ones may take longer without ending the campaign.
            elif not self._has_begun and waited_s > _READY_S:
                raise WorkerError(f"no worker was ready to fly within {_READY_S:g} s")

    def _dismiss(self, worker: Worker) -> _Post:
        worker.end()
        return self._posts.pop(worker)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End all workers."""
        # One by one: ending a worker waits until its process is gone.
        while self._posts:
            self._dismiss(next(iter(self._posts)))
