"""Workers that are processes of this machine.

Processes, not threads: a pilot that crashes, hangs or exhausts memory then takes down only itself.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from aeroscene.processes import become, fresh_processes, without_interrupts
from scenarios.campaigns.engines.crew import WorkerError, WorkerGoneError
from scenarios.campaigns.engines.worker_setup import begin_work
from scenarios.campaigns.external.program import end_program
from scenarios.campaigns.flyer import Flyer, Row, Suite, Trial

_READY = "ready"  # first message of a process
_FAREWELL_S = 5.0
"""Time in which a process must end its program, before it is killed."""


@dataclass(frozen=True)
class _Job:
    """Parameters of a new process."""

    suite: Suite
    patience_s: float
    port: int | None
    """Port on which pilots that start by themselves connect."""
    instance: int
    """Offset of the ports of a flight stack of another project."""
    environment: Mapping[str, str]
    """The parent's environment variables."""


class _LocalWorker:
    """One process, and a link to it."""

    def __init__(self, number: int, job: _Job) -> None:
        # Trials plan with SciPy's optimiser, which takes a quarter of a second to import.
        context = fresh_processes(__name__, "scipy.optimize")
        self.number = number
        self.link, theirs = context.Pipe()
        # Otherwise Ctrl-C could reach the child before it ignores it.
        self._process = context.Process(target=_work, args=(theirs, job), daemon=True)
        with without_interrupts():
            self._process.start()
        # Closed here, so that the end of the process is seen as the end of the link.
        theirs.close()

    def give(self, trial: Trial) -> None:
        # If it has died, the next read from it finds that out.
        with contextlib.suppress(OSError):
            self.link.send(trial)

    def receive(self) -> Row | None:
        try:
            said: Any = self.link.recv()
        except (EOFError, OSError):
            self._process.join(_FAREWELL_S)
            raise WorkerGoneError(f"its process ended with {self._process.exitcode}") from None
        if isinstance(said, WorkerError):
            raise said
        return None if said == _READY else said

    def end(self) -> None:
        # SIGTERM first, so that the worker can end its program; SIGKILL if it does not.
        self._process.terminate()
        self._process.join(_FAREWELL_S)
        self._process.kill()
        self._process.join()
        self.link.close()


class LocalEngine:
    """Processes of this machine; each takes one or two seconds to start."""

    def __init__(
        self,
        suite: Suite,
        patience_s: float,
        first_port: int | None = None,
        first_instance: int = 0,
    ) -> None:
        """Prepare, without starting anything.

        Args:
            suite: Suite that the workers fly.
            patience_s: Wall time for one trial.
            first_port: Port on which the first worker waits for pilots that start by themselves;
                each next worker's is 10 higher.
            first_instance: Instance of a flight stack of another project at the first worker; each
                next worker's is 1 higher.
        """
        self._suite = suite
        self._patience_s = patience_s
        self._first_port = first_port
        self._first_instance = first_instance
        self._hired: list[_LocalWorker] = []
        """Workers that have not been ended, and perhaps some that have."""

    def hire(self) -> _LocalWorker:
        """Start a worker, with the first number that is free."""
        # Ports follow from the number, so the number of a dead worker is used again.
        taken = {worker.number for worker in self._present()}
        number = next(n for n in range(len(taken) + 1) if n not in taken)
        port = None if self._first_port is None else self._first_port + 10 * number
        instance = self._first_instance + number
        job = _Job(self._suite, self._patience_s, port, instance, dict(os.environ))
        worker = _LocalWorker(number, job)
        self._hired.append(worker)
        return worker

    def wait(self, timeout_s: float) -> Sequence[_LocalWorker]:
        """Return the workers that have an answer; wait for the first at most that long."""
        present = self._present()
        ready = wait([worker.link for worker in present], timeout_s)
        return [worker for worker in present if worker.link in ready]

    def _present(self) -> list[_LocalWorker]:
        self._hired = [worker for worker in self._hired if not worker.link.closed]
        return self._hired


class _EndRequest(BaseException):
    """SIGTERM has come, or the parent is gone. No `except Exception` of a pilot catches it."""


def _work(link: Connection[Any, Any], job: _Job) -> None:
    """Fly the trials that come over a link, until it is closed."""
    try:
        become(job.environment)
        _end_on_sigterm()
        begin_work(job.suite.pilot)
        with Flyer(
            job.suite, patience_s=job.patience_s, port=job.port, instance=job.instance
        ) as flyer:
            link.send(_READY)
            while True:
                link.send(flyer.fly(link.recv()))
    except (EOFError, _EndRequest):
        return
    except Exception as error:  # noqa: BLE001 - whatever it is, the parent says it
        link.send(WorkerError(" ".join(str(error).split()) or type(error).__name__))


def _end_on_sigterm() -> None:
    """End this process, and the program that flies for it, with SIGTERM and with the parent."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def leave(*_: object) -> None:
        # A second signal must not interrupt the clean-up of the first.
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise _EndRequest

    def watch() -> None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)
        # A pilot may swallow any exception, so end the process without one.
        time.sleep(_FAREWELL_S)
        end_program()
        os._exit(1)

    signal.signal(signal.SIGTERM, leave)
    # Ctrl-C is the parent's to handle.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # `without_interrupts` of the parent is inherited.
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    threading.Thread(target=watch, daemon=True).start()
