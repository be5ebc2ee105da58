"""Forecast of a campaign's duration: the real crew and schedule, over workers that only wait.

The schedule decides how often scenes are opened, so a formula would have to repeat it. Instead time
is simulated. The cost of a trial is drawn from trials that were flown: from the first ones of a
scene and a vehicle, which open them, if a worker comes to another scene or vehicle, else from all
others.
"""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

import pyarrow as pa

from scenarios.campaigns.engines.crew import Crew
from scenarios.campaigns.flyer import Row, Trial

_STARTING_S = 3.0
"""CPU time in which a process gets ready: its imports."""
_KEEPING_S = 0.3e-3
"""CPU time in which the campaign keeps a row and gives out the next trial."""


@dataclass(frozen=True, kw_only=True)
class Costs:
    """CPU seconds of trials that were flown."""

    first_s: Sequence[float]
    """Costs of trials that opened their scene or vehicle."""
    others_s: Sequence[float]


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """Expected effort of a campaign, with a core for each worker."""

    wall_seconds: float
    cpu_seconds: float
    openings: int
    """Number of times that a worker comes to a scene and a vehicle."""
    share_at_work: float
    """Share of the workers' time in which they fly; the rest is spent waiting."""


def measured_costs(table: pa.Table) -> Costs | None:
    """Return the costs of the trials of a campaign, in the order in which they ended.

    Args:
        table: Rows as `read_results` returns them.

    Returns:
        The costs; None if too few trials were flown to measure both kinds.
    """
    seen: set[tuple[str, str]] = set()
    first_s: list[float] = []
    others_s: list[float] = []
    columns = (table[name].to_pylist() for name in ("scene", "vehicle", "trial_cpu_seconds"))
    for scene, vehicle, cost_s in zip(*columns, strict=True):
        if cost_s is None:
            continue
        # Only roughly: several workers may have opened the same scene.
        (others_s if (scene, vehicle) in seen else first_s).append(cost_s)
        seen.add((scene, vehicle))
    return Costs(first_s=first_s, others_s=others_s) if first_s and others_s else None


def forecast(trials: Sequence[Trial], costs: Costs, n_workers: int) -> Forecast:
    """Let a crew fly trials in simulated time.

    Args:
        trials: At least one.
        costs: Costs of trials that were flown.
        n_workers: Number of workers, each with a core of its own.
    """
    engine = _WaitingEngine(costs)
    with Crew(engine, n_workers, math.inf, clock=lambda: engine.now_s) as crew:
        for _ in crew.fly(trials):
            engine.now_s += _KEEPING_S
    paid_s = n_workers * engine.now_s
    return Forecast(
        wall_seconds=engine.now_s,
        cpu_seconds=engine.worked_s,
        openings=engine.n_openings,
        share_at_work=engine.worked_s / paid_s,
    )


class _WaitingWorker:
    """A worker whose flights consist of waiting."""

    def __init__(self, engine: _WaitingEngine) -> None:
        self._engine = engine
        self._place: tuple[str, str] | None = None
        self._row: Row | None = None
        engine.busy(self, _STARTING_S)

    def give(self, trial: Trial) -> None:
        engine, place = self._engine, (trial.scene, trial.vehicle)
        is_first = place != self._place
        engine.n_openings += is_first
        self._place, self._row = place, {"trial_id": trial.id}
        costs_s = engine.costs.first_s if is_first else engine.costs.others_s
        engine.busy(self, engine.random.choice(costs_s))

    def receive(self) -> Row | None:
        return self._row

    def end(self) -> None:
        pass


class _WaitingEngine:
    """Workers in simulated time."""

    def __init__(self, costs: Costs) -> None:
        self.costs = costs
        self.now_s = 0.0
        self.worked_s = 0.0
        self.n_openings = 0
        # A fixed seed: the same campaign gets the same forecast.
        self.random = random.Random(0)
        self._due: list[tuple[float, int, _WaitingWorker]] = []
        self._n_due = 0

    def busy(self, worker: _WaitingWorker, seconds: float) -> None:
        """Have a worker answer after some time."""
        self.worked_s += seconds
        self._n_due += 1
        # The running number orders workers that are due at the same time, which cannot be compared.
        heapq.heappush(self._due, (self.now_s + seconds, self._n_due, worker))

    def hire(self) -> _WaitingWorker:
        return _WaitingWorker(self)

    def wait(self, _: float) -> Sequence[_WaitingWorker]:
        """Return the worker that answers next, and advance the time to that moment."""
        due_s, _, worker = heapq.heappop(self._due)
        self.now_s = max(self.now_s, due_s)
        return (worker,)
