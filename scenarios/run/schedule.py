"""End of a run: its pilot is done, all has come to rest, or the time is up.

The verdict needs more than the moment at which the pilot is done: whether the vehicle slides,
whether the rotors stop, or where a vehicle that was left in the air comes down. A flight therefore
has parts, each with a time limit and a condition that ends it earlier.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from flightsim.plant import Plant
from flightsim.simulator import Simulator
from scenarios.trials.flight_log import FlightLog
from scenarios.trials.limits import LIMITS

if TYPE_CHECKING:
    from scenarios.run.companion import Companion

# Longest time of a part in s, and the condition that ends it earlier.
_Part = tuple[float, Callable[[], bool]]


class Schedule:
    """The parts of a vehicle's run, one after the other; ask `is_over` before each tick."""

    def __init__(
        self,
        plant: Plant,
        log: FlightLog,
        companion: Companion | None,
        longest_s: float | None,
        *,
        is_to_land: bool = False,
    ) -> None:
        """Begin now.

        Args:
            plant: The vehicle.
            log: Its flight.
            companion: The pilot; a run for clients alone has one part, which has no end.
            longest_s: Simulated time after which it is over in any case; None for never.
            is_to_land: True if it has to land even if the companion names no area.
        """
        self._plant, self._log, self._companion = plant, log, companion
        self._is_to_land = is_to_land
        self._is_endless = companion is None
        self._watches_descent = False
        self._parts = iter(()) if companion is None else self._flown(companion, log)
        self._end_us = math.inf if longest_s is None else plant.time_us + round(longest_s * 1e6)
        self._next()

    def is_over(self) -> bool:
        """Return whether the run is over; after True it needs no further call."""
        now_us = self._plant.time_us
        # The time limit is the pilot's. The fate of a vehicle that it left in the air is still
        # watched.
        if now_us >= self._end_us and not (self._watches_descent or self._is_left_in_the_air()):
            return True
        if self._is_endless:
            return False
        while self._part is not None:
            until_us, is_done = self._part
            if now_us < until_us and not is_done():
                return False
            self._next()
        return True

    def _flown(self, companion: Companion, log: FlightLog) -> Iterator[_Part]:
        """Yield the parts of a flight; each begins when the one before is over."""
        yield LIMITS.trial_s, lambda: companion.is_done
        if self._is_left_in_the_air():
            self._watches_descent = True
            yield LIMITS.longest_fall_s, lambda: not log.is_in_the_air()
            yield LIMITS.longest_settle_s, log.is_still
            return
        # The first second always passes: nothing ends this part earlier.
        yield LIMITS.settle_s, lambda: False
        rest_s = LIMITS.longest_settle_s - LIMITS.settle_s
        yield rest_s, lambda: not self._wants_landing(companion) or log.is_still()

    def _wants_landing(self, companion: Companion) -> bool:
        return self._is_to_land or companion.area is not None

    def _is_left_in_the_air(self) -> bool:
        """Return whether a pilot that was to land has ended its flight in the air."""
        companion = self._companion
        if companion is None or not self._wants_landing(companion) or not companion.is_done:
            return False
        return self._log.is_in_the_air()

    def _next(self) -> None:
        part = next(self._parts, None)
        now_us = self._plant.time_us
        self._part = None if part is None else (round(now_us + part[0] * 1e6), part[1])


class RunClock:
    """Wall time and CPU time of a run, from its creation on."""

    def __init__(self) -> None:
        self._wall_s, self._cpu_s = time.perf_counter(), time.process_time()

    def spent_s(self) -> tuple[float, float]:
        """Return wall time and CPU time so far, s."""
        return time.perf_counter() - self._wall_s, time.process_time() - self._cpu_s


def run_until_over(
    simulator: Simulator, schedules: Sequence[Schedule], should_stop: Callable[[], bool | str]
) -> str | None:
    """Simulate until every vehicle's run is over.

    Args:
        simulator: The loop.
        schedules: Schedule of each vehicle.
        should_stop: Called every tick; the run ends when it returns True or the name of a cause.

    Returns:
        The cause that stopped the run before it was over, if any.
    """
    word: bool | str = False

    def is_over() -> bool:
        nonlocal word
        word = word or should_stop()
        # Every schedule is asked at every tick, because its parts follow each other in its own
        # time.
        n_over = sum(schedule.is_over() for schedule in schedules)
        return bool(word) or n_over == len(schedules)

    simulator.run(stop=is_over)
    return (word if isinstance(word, str) else "the caller") if word else None
