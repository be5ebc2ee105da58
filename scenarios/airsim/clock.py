"""Pause and continue: who holds the simulated time, and until when it passes."""

from __future__ import annotations

import math

from scenarios.airsim.methods import Later, RpcError

TICK_US = 20_000
_LONGEST_S = 1e6


class Clock:
    """Lets time pass or not; ask `may_pass` before a tick, call `on_tick` after it."""

    def __init__(self) -> None:
        self.is_paused = False
        self._until_us = math.inf
        self._now_us = 0
        self._answer: Later | None = None

    @property
    def may_pass(self) -> bool:
        """Return True if the next tick may come."""
        return not self.is_paused

    def on_tick(self, now_us: int) -> None:
        """Pause when the time is up."""
        self._now_us = now_us
        if now_us >= self._until_us:
            self.pause(is_paused=True)

    def pause(self, *, is_paused: bool) -> None:
        """Stop time, or let it pass until further notice."""
        self.is_paused = is_paused
        self._until_us = math.inf
        if self._answer is not None:
            self._answer.finish(None)
            self._answer = None

    def go_on(self, seconds: float) -> Later:
        """Let time pass for so long, then pause; the answer comes with the pause.

        Raises:
            RpcError: If it is no time.
        """
        if not 0.0 <= seconds <= _LONGEST_S:
            raise RpcError(f"seconds {seconds} is not valid; valid: 0 to {_LONGEST_S:g}")
        self.pause(is_paused=False)
        self._until_us = self._now_us + round(1e6 * seconds)
        self._answer = answer = Later()
        if seconds == 0.0:
            self.pause(is_paused=True)
        return answer

    def go_on_for(self, frames: int) -> Later:
        """The same for a number of ticks of 20 ms.

        Raises:
            RpcError: If it is no number of them.
        """
        return self.go_on(frames * 1e-6 * TICK_US)
