"""A line at the bottom of the terminal that says how the flight goes."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.status import Status

from scenarios.sitl import Sitl

PERIOD_S = 0.25
"""Wall time between two updates."""


class StatusLine:
    """Shows time, speed, mode and height while a run goes on; silent where nobody looks."""

    def __init__(self, console: Console, sitl: Sitl) -> None:
        self._sitl = sitl
        self._status = Status("starting", console=console) if console.is_terminal else None
        self._due_s = 0.0
        self._last: tuple[float, float] | None = None

    def refresh(self) -> None:
        """Update the line if it is time to; call as often as you like."""
        if self._status is None or time.monotonic() < self._due_s:
            return
        now_s = time.monotonic()
        self._due_s = now_s + PERIOD_S
        self._status.update(self._text(now_s))

    def _text(self, now_s: float) -> str:
        plant, autopilot = self._sitl.bench.plant, self._sitl.bench.autopilot
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
        if self._sitl.pilot is not None:
            words.append(f"pilot: {self._sitl.pilot.phase.value}")
        return "  ".join(words)

    def __enter__(self) -> Self:
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._status is not None:
            self._status.stop()
