"""Terminal output during a run: a status line, and events above it."""

from __future__ import annotations

import time
from typing import Self

from rich.status import Status

from scenarios.cli.terminal import Terminal, styled
from scenarios.run.flight import Flight

PERIOD_S = 0.25
"""Wall time between two updates."""


class StatusLine:
    """Prints messages of autopilot and pilot, and on a terminal the state of the flight below.

    It is a context manager: the line appears at its start and is removed at its end.
    """

    def __init__(self, console: Terminal, flight: Flight) -> None:
        """Follow a vehicle's flight. Among several vehicles, only the first has the status line.

        Args:
            console: Terminal of standard error.
            flight: Flight whose messages are printed.
        """
        self._console = console
        world = flight.vehicle.plant.world
        self._who = f"vehicle {world.number + 1}: " if world.n_vehicles > 1 else ""
        self._flight = flight
        self._n_transitions = 0
        flight.vehicle.stack.listen(lambda _, text: self._say(text))
        has_line = console.is_terminal and world.number == 0
        self._status = Status("starting", console=console) if has_line else None
        self._due_s = 0.0
        self._last: tuple[float, float] | None = None  # wall and simulated time of the last text

    def refresh(self) -> None:
        """Print new transitions of the pilot, and update the line every `PERIOD_S`.

        The call is cheap, so that the loop may make it after each of its ticks.
        """
        pilot = self._flight.pilot
        if pilot is not None and len(pilot.transitions) > self._n_transitions:
            for transition in pilot.transitions[self._n_transitions :]:
                self._say(f"pilot: {transition.target.value}: {transition.reason}")
            self._n_transitions = len(pilot.transitions)
        if self._status is None or time.monotonic() < self._due_s:
            return
        now_s = time.monotonic()
        self._due_s = now_s + PERIOD_S
        self._status.update(styled(self._text(now_s)))

    def _say(self, text: str) -> None:
        sim_s = self._flight.vehicle.plant.time_us * 1e-6
        # Unbroken lines, so that a log of them can be searched.
        self._console.print(f"{sim_s:8.2f} s  {self._who}{text}", highlight=False, soft_wrap=True)

    def _text(self, now_s: float) -> str:
        plant, autopilot = self._flight.vehicle.plant, self._flight.vehicle.stack.reports
        sim_s = plant.time_us * 1e-6
        factor = ""
        if self._last is not None:
            wall_before_s, sim_before_s = self._last
            factor = f" at {(sim_s - sim_before_s) / (now_s - wall_before_s):.1f}x"
        self._last = (now_s, sim_s)
        words = [
            f"{sim_s:.1f} s{factor}",
            f"{autopilot.mode.value}, {'armed' if autopilot.is_armed else 'disarmed'}",
            f"height {plant.estimate.position_enu_m[2]:.1f} m",
            f"battery {100 * plant.battery.remaining:.0f}%",
        ]
        if self._flight.pilot is not None:
            words.append(f"pilot: {self._flight.pilot.phase.value}")
        return "  ".join(words)

    def __enter__(self) -> Self:
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(self, *exception: object) -> None:
        if self._status is not None:
            self._status.stop()
