"""Order in which workers fly trials.

Opening a scene costs as much as several trials in it, so a worker stays with a scene and a vehicle
as long as there are trials of them. Then it begins a pair that nobody has begun, of its own scene
if it can. When all pairs have been begun, it helps where most trials are left per worker.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence

from scenarios.campaigns.flyer import Trial

_MOST_DEATHS = 2
"""Number of processes that a trial may end before it counts as failed."""

_Place = tuple[str, str]
"""A scene and a vehicle."""


class Schedule:
    """Trials that no worker has begun."""

    def __init__(self, trials: Sequence[Trial]) -> None:
        self._piles: dict[_Place, deque[Trial]] = {}
        for trial in trials:
            self._piles.setdefault(_place(trial), deque()).append(trial)
        self._fresh = dict.fromkeys(self._piles)
        """Places without a worker, in their order."""
        self._n_workers_at: Counter[_Place] = Counter()
        self._deaths: Counter[Trial] = Counter()
        self.n_left = len(trials)
        """Number of trials that no worker has begun."""

    def next(self, last: Trial | None) -> Trial | None:
        """Take the next trial for a worker.

        Args:
            last: Trial that it flew before; None if it has just begun.

        Returns:
            The trial; None if none is left.
        """
        if not self._piles:
            return None
        here = None if last is None else _place(last)
        if here not in self._piles:
            if here is not None:
                self._leave(here)
            here = self._choose(here)
            self._fresh.pop(here, None)
            self._n_workers_at[here] += 1
        trial = self._piles[here].popleft()
        if not self._piles[here]:
            del self._piles[here]
        self.n_left -= 1
        return trial

    def give_back(self, trial: Trial) -> bool:
        """Take back a trial whose process died; another one flies it, and continues from there.

        Returns:
            True if it will be flown again; False if it has ended too many processes.
        """
        self.abandon(trial)
        self._deaths[trial] += 1
        if self._deaths[trial] >= _MOST_DEATHS:
            return False
        place = _place(trial)
        # At the front: it is the next trial of its place.
        self._piles.setdefault(place, deque()).appendleft(trial)
        self.n_left += 1
        self._renew(place)
        return True

    def abandon(self, trial: Trial) -> None:
        """Note that the worker of a trial is gone, so that another one continues its place."""
        self._leave(_place(trial))
        self._renew(_place(trial))

    def _leave(self, place: _Place) -> None:
        self._n_workers_at[place] -= 1
        if self._n_workers_at[place] <= 0:
            del self._n_workers_at[place]

    def _renew(self, place: _Place) -> None:
        """Let the next worker that seeks a place begin with one that was abandoned."""
        if place in self._piles and not self._n_workers_at[place]:
            # In front: it goes on before new places are begun.
            self._fresh = {place: None} | self._fresh

    def _choose(self, before: _Place | None) -> _Place:
        """Return the place for a worker that was at another one."""
        if self._fresh:
            # Another vehicle in the same scene, which the worker has open.
            kindred = (place for place in self._fresh if before and place[0] == before[0])
            return next(kindred, next(iter(self._fresh)))
        return max(
            self._piles,
            key=lambda place: len(self._piles[place]) / (1 + self._n_workers_at[place]),
        )


def _place(trial: Trial) -> _Place:
    return trial.scene, trial.vehicle
