"""Workers that are actors of Ray: on this machine, or on all machines of a cluster.

Ray comes with the extra `cluster`, and is imported only when a campaign asks for it, because it is
large.
"""

from __future__ import annotations

import importlib
import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from aeroscene import __version__
from scenarios.campaigns.engines.crew import WorkerError, WorkerGoneError
from scenarios.campaigns.engines.worker_setup import begin_work
from scenarios.campaigns.flyer import Flyer, Row, Suite, Trial

_SETTINGS = {
    # No figures are sent to Ray's makers.
    "RAY_USAGE_STATS_ENABLED": "0",
    # A program that flies, and what it has started, ends with its worker.
    "RAY_kill_child_processes_on_worker_exit_with_raylet_subreaper": "true",
    # The accelerators that its worker sees are left as they are.
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
}
_LOOPBACK = {"RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0"}
"""Ray then listens on loopback alone, on every system, so that nobody from outside can join it."""
_OBJECT_STORE_BYTES = 100 << 20
"""Memory for results under way: a row has two kilobytes."""


class _Station:
    """The actor: a process of Ray that flies trials."""

    def __init__(self, suite: Suite, patience_s: float, version: str) -> None:
        self._suite = suite
        self._patience_s = patience_s
        self._version = version
        self._flyer: Flyer | None = None

    def begin(self) -> str | None:
        """Get ready; return None, or one line that says why this machine cannot fly."""
        if self._version != __version__:
            return f"a machine of the cluster has version {__version__}; valid: {self._version}"
        begin_work(self._suite.pilot)
        # Ray's worker ignores children, so a program's exit status would be lost.
        _heed_children()
        try:
            self._flyer = Flyer(self._suite, patience_s=self._patience_s)
        except Exception as error:  # noqa: BLE001 - whatever it is, the campaign says it
            return _one_line(error)
        return None

    def fly(self, trial: Trial) -> Row | str:
        """Return the row of a trial, or a line that says why this machine cannot fly."""
        assert self._flyer is not None
        try:
            return self._flyer.fly(trial)
        except Exception as error:  # noqa: BLE001 - as above
            return _one_line(error)


class _Actor:
    """A worker of Ray, as the campaign sees it."""

    def __init__(self, ray: Any, station: Any) -> None:
        self._ray = ray
        self._station = station
        self.answer = station.begin.remote()
        self.has_ended = False

    def give(self, trial: Trial) -> None:
        self.answer = self._station.fly.remote(trial)

    def receive(self) -> Row | None:
        try:
            said = self._ray.get(self.answer)
        except self._ray.exceptions.RayActorError as error:
            raise WorkerGoneError(f"its process ended: {_one_line(error)}") from None
        except self._ray.exceptions.RayError as error:
            raise WorkerError(_one_line(error)) from None
        if isinstance(said, str):
            raise WorkerError(said)
        return said

    def end(self) -> None:
        self.has_ended = True
        self._ray.kill(self._station)


class RayEngine:
    """Actors of Ray, one core each."""

    def __init__(self, ray: Any, suite: Suite, patience_s: float) -> None:
        """Prepare, without starting anything; see `ray_engine`."""
        self._ray = ray
        # The crew replaces a dead worker itself, so that Ray must not.
        self._make = ray.remote(num_cpus=1, max_restarts=0)(_Station)
        self._job = (suite, patience_s, __version__)
        self._hired: list[_Actor] = []

    def hire(self) -> _Actor:
        """Start a worker on a free core."""
        actor = _Actor(self._ray, self._make.remote(*self._job))
        self._hired.append(actor)
        return actor

    def wait(self, timeout_s: float) -> Sequence[_Actor]:
        """Return the workers that have an answer; wait for the first at most that long."""
        self._hired = [actor for actor in self._hired if not actor.has_ended]
        # Ray waits on answers, not on actors.
        by_answer = {actor.answer: actor for actor in self._hired}
        answers = list(by_answer)
        self._ray.wait(answers, num_returns=1, timeout=timeout_s)
        ready, _ = self._ray.wait(answers, num_returns=len(answers), timeout=0)
        return [by_answer[answer] for answer in ready]


def _ray(settings: dict[str, str]) -> Any:
    """Import Ray, which reads its settings from the environment.

    Raises:
        WorkerError: If the extra `cluster` is not installed.
    """
    os.environ.update(settings)
    try:
        return importlib.import_module("ray")
    except ModuleNotFoundError as error:
        if error.name != "ray":
            raise
        raise WorkerError(
            "engine 'ray' needs ray, which is not installed: pip install 'aeroscene[cluster]'; "
            "valid without it: --engine local"
        ) from None


@contextmanager
def ray_engine(
    suite: Suite, patience_s: float, n_workers: int, address: str | None = None
) -> Iterator[RayEngine]:
    """Connect to Ray, or start it on this machine and end it afterwards.

    Args:
        suite: Suite that the workers fly.
        patience_s: Wall time for one trial.
        n_workers: Number of workers, for which a Ray of our own has room.
        address: Address of a cluster, as Ray has it; None starts one that listens on loopback.

    Raises:
        WorkerError: If Ray is not installed, or cannot be reached.
    """
    ray = _ray(_SETTINGS if address else _SETTINGS | _LOOPBACK)
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "error"}
    own: dict[str, Any] = {
        "num_cpus": n_workers,
        "include_dashboard": False,
        "object_store_memory": _OBJECT_STORE_BYTES,
    }
    try:
        ray.init(**quiet, **({"address": address} if address else own))
    except Exception as error:  # noqa: BLE001 - a bare one says that it took too long
        ray.shutdown()
        where = f"ray-address {address!r}" if address else "ray"
        raise WorkerError(f"{where}: {_one_line(error)}") from None
    _heed_children()
    try:
        yield RayEngine(ray, suite, patience_s)
    finally:
        ray.shutdown()


def _heed_children() -> None:
    """Restore the default handling of child processes, because Ray discards their exit status."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
