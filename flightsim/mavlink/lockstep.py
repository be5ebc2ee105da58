"""Lockstep with a client outside this process: simulated time waits for the ticks that it grants.

The client sends MAV_CMD_USER_1 with a number of ticks in parameter 1. They run at once. No message
of that client is read in between, and the acknowledgement follows the last of their telemetry.
Whatever the client sends therefore takes effect at the same tick in each run, which makes the
flight repeatable.
"""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.results import ACCEPTED, Reply, denied, rejected
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import Command, Executor, acknowledge, choice
from flightsim.mavlink.dialect import dialect as mav

MAX_TICKS = 50_000
"""Most ticks of one grant, 1,000 s."""


class Lockstep:
    """Ticks that the client who keeps time has granted; the first who grants any is that client.

    Attributes:
        is_over: True if that client has left, so that time stands still for good.
    """

    def __init__(self) -> None:
        self.is_over = False
        self._keeper: Channel | None = None
        self._grant: Command | None = None
        self._n_left = 0
        self._is_released = False
        self.executors: Mapping[int, Executor] = {mav.MAV_CMD_USER_1: self._on_grant}

    @property
    def has_ticks(self) -> bool:
        """True if a tick may run now."""
        return self._n_left > 0 or self._is_released

    @property
    def has_keeper(self) -> bool:
        """True if a client keeps the time at present."""
        return self._keeper is not None

    def release(self) -> None:
        """Let time pass by itself from now on; no client is heard any more."""
        self._is_released, self.is_over = True, False

    def holds_back(self, channel: Channel) -> bool:
        """Return true if a partner's messages wait until the ticks that it granted have run."""
        return self._is_released or (self.has_ticks and channel is self._keeper)

    def end_tick(self) -> None:
        """Count a tick, and acknowledge the grant after its last one."""
        self._n_left = max(0, self._n_left - 1)
        if self._n_left == 0 and self._grant is not None:
            grant, self._grant = self._grant, None
            acknowledge(grant, ACCEPTED)

    def forget(self, channel: Channel) -> None:
        """End the lockstep if the partner that left kept the time; the run then ends.

        A client that had released the time before it left does not end the run.
        """
        if channel is self._keeper:
            self._keeper = self._grant = None
            self._n_left = 0
            self.is_over = not self._is_released

    def _on_grant(self, c: Command) -> Reply | None:
        n_ticks = choice(c.param1)
        if n_ticks is None or not 1 <= n_ticks <= MAX_TICKS:
            return denied(f"param1 = {c.param1:g} ticks; valid are 1 to {MAX_TICKS}")
        if self._keeper not in {None, c.channel}:
            return rejected("another client keeps the time")
        self._keeper, self._grant, self._n_left = c.channel, c, n_ticks
        # No reply yet: `end_tick` acknowledges, after the telemetry of the last tick.
        return None
