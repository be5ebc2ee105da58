"""Simulation loop: plant, autopilot, MAVLink and observers in lockstep, paced by the wall clock.

All parts run one after the other in one thread, in the same order at every tick, so a flight that
no client disturbs repeats exactly. The wall clock decides only how long the loop sleeps between two
ticks, never how far one goes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

TICK_US = 20_000
"""Simulated time of one step."""

_SHORTEST_SLEEP_S = 1e-3  # shorter waits are left to the next tick
_FORGIVEN_LATENESS_S = 0.1  # lateness that is made up for; more is given up
_LOCKSTEP_WAIT_S = 0.05
"""Time between two looks at other reasons to end a run, while a client keeps the time."""

Observer = Callable[[], object]


class Timed(Protocol):
    """Owner of simulated time: a plant, or all vehicles of a world."""

    @property
    def time_us(self) -> int:
        """Simulated time in microseconds."""
        ...

    def advance(self) -> None:
        """Advance by a step."""
        ...


class Controller(Protocol):
    """Controller of a plant: our autopilot, or a class of a user's own."""

    def update(self) -> None:
        """Read `plant.estimate` and call `plant.apply`; called after each 20 ms."""
        ...


class Server(Protocol):
    """Server of clients outside: our MAVLink, or the bridge to another flight stack."""

    def update(self) -> None:
        """Read, answer and stream; called after the controller."""
        ...

    def wait_for_tick(self, timeout_s: float) -> bool:
        """Return True if time may pass; wait a moment for clients that keep it.

        Args:
            timeout_s: Longest wait, of wall time.
        """
        ...


class Interlude(Protocol):
    """Someone outside who may stop time, and who has work for the time between two ticks."""

    def may_step(self, timeout_s: float) -> bool:
        """Return True if time may pass; otherwise wait a moment."""
        ...

    def idle(self, seconds: float) -> None:
        """Work for so long, where the loop would otherwise sleep."""
        ...


class SpeedError(ValueError):
    """The speed of the loop is invalid."""


@dataclass(slots=True)
class Timing:
    """Wall time in seconds of each part of the steps; `idle_s` is time slept."""

    n_steps: int = 0
    plant_s: float = 0.0
    """Physics, sensors, estimator and controllers."""
    autopilot_s: float = 0.0
    mavlink_s: float = 0.0
    observers_s: float = 0.0
    idle_s: float = 0.0


class Simulator:
    """Loop that steps all parts by 20 ms of simulated time, at the requested speed.

    Attributes:
        interlude: Works between ticks, and may stop time; None sleeps.
    """

    def __init__(
        self,
        plant: Timed,
        autopilot: Controller,
        mavlink_server: Server | None = None,
        *,
        observers: Sequence[Observer] = (),
        speed: float | Literal["max"] = 1.0,
    ) -> None:
        """Prepare a loop.

        Args:
            plant: Plant, or vehicles, that own time.
            autopilot: Autopilot or other controller, updated after the plant with fresh estimates.
            mavlink_server: Server, updated after the autopilot; None flies without clients.
            observers: Called in this order at the end of each step; a list may grow later.
            speed: Simulated seconds per wall second, or "max" for no pacing.

        Raises:
            SpeedError: If the speed is not a positive number or "max".
        """
        self._plant = plant
        self._autopilot = autopilot
        self._mavlink_server = mavlink_server
        self._observers = observers
        self.interlude: Interlude | None = None
        self._is_stopping = False
        self._tick_s = tick_seconds(speed)
        # Nanoseconds as whole numbers: adding them up loses nothing.
        self._ns = [0, 0, 0, 0]
        self._n_steps = 0
        self._idle_s = 0.0

    @property
    def timing(self) -> Timing:
        """Wall time of each part so far."""
        plant_s, autopilot_s, mavlink_s, observers_s = (ns * 1e-9 for ns in self._ns)
        return Timing(
            n_steps=self._n_steps,
            plant_s=plant_s,
            autopilot_s=autopilot_s,
            mavlink_s=mavlink_s,
            observers_s=observers_s,
            idle_s=self._idle_s,
        )

    def step(self) -> None:
        """Advance by one tick.

        The plant comes first, so the autopilot sees fresh estimates, MAVLink reports what the
        autopilot made of them, and observers see all of it.
        """
        clock, ns = time.perf_counter_ns, self._ns
        t0 = clock()
        self._plant.advance()
        t1 = clock()
        self._autopilot.update()
        t2 = clock()
        if self._mavlink_server is not None:
            self._mavlink_server.update()
        t3 = clock()
        for observer in self._observers:
            observer()
        ns[0] += t1 - t0
        ns[1] += t2 - t1
        ns[2] += t3 - t2
        ns[3] += clock() - t3
        self._n_steps += 1

    def run(self, until_us: int | None = None, stop: Callable[[], bool] | None = None) -> None:
        """Step until a simulated time, until `stop()` is true or until `request_stop`.

        A stall of the machine of more than a tenth of a second is not made up for: simulated time
        then lags behind.

        Args:
            until_us: Simulated time to end at; None has no such end.
            stop: Called before each step; the run ends when it returns True.
        """
        self._is_stopping = False
        deadline_s = time.perf_counter()
        while not self._is_stopping:
            if until_us is not None and self._plant.time_us >= until_us:
                return
            if stop is not None and stop():
                return
            if not self._may_step():
                continue
            self.step()
            if self._tick_s > 0.0:
                # Deadlines follow from each other and not from the time, so no error adds up.
                deadline_s = self._wait(deadline_s + self._tick_s)

    def request_stop(self) -> None:
        """Make `run` return after the present step; safe in signal handlers."""
        self._is_stopping = True

    def _may_step(self) -> bool:
        """Return True if time may pass; wait a moment for a client that keeps it."""
        server, interlude = self._mavlink_server, self.interlude
        if interlude is not None and not interlude.may_step(_LOCKSTEP_WAIT_S):
            return False
        return server is None or server.wait_for_tick(_LOCKSTEP_WAIT_S)

    def _wait(self, deadline_s: float) -> float:
        """Sleep until the deadline and return it, or return now if it is long past."""
        now_s = time.perf_counter()
        ahead_s = deadline_s - now_s
        if ahead_s >= _SHORTEST_SLEEP_S:
            if self.interlude is None:
                time.sleep(ahead_s)
            else:
                self.interlude.idle(ahead_s)
            self._idle_s += time.perf_counter() - now_s
        elif ahead_s < -_FORGIVEN_LATENESS_S:
            # To catch up would make simulated time race for as long as the stall took.
            return now_s
        return deadline_s


def tick_seconds(speed: float | Literal["max"]) -> float:
    """Return the wall time of one tick in seconds; 0 for no pacing.

    Args:
        speed: Simulated seconds per wall second, or "max".

    Raises:
        SpeedError: If the speed is not a positive number or "max".
    """
    if speed == "max":
        return 0.0
    if not isinstance(speed, (int, float)) or not 0.0 < speed < math.inf:
        raise SpeedError(f'speed = {speed!r}; valid are positive numbers and "max"')
    return TICK_US * 1e-6 / speed
