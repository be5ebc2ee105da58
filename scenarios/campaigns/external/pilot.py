"""A pilot outside this process, which keeps the time over MAVLink; see docs/lockstep.md.

The flight begins with the first tick that the pilot grants. It is over when the vehicle was armed,
has been disarmed for two seconds, and the granted ticks have passed. From then on, or once the
pilot has left, time passes by itself and no client is heard. A flight therefore depends only on
what the pilot sends and when, in ticks, and not on the speed of the machine.
"""

from __future__ import annotations

import time

from aeroscene.scene import InteractionArea
from autonomy.types import Vector3
from flightsim.testbench import Testbench
from scenarios.campaigns.external.program import Program
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Verdict

_HEARTBEAT_S = 60.0
"""Wall time within which a program must have sent its first message."""
_DISARMED_US = 2_000_000
"""Time for the pilot to see that the vehicle is disarmed; heartbeats report it once a second."""
_FAREWELL_S = 2.0
"""Time for a program to end after it has left: its exit status shows whether it crashed."""


class CrashedError(RuntimeError):
    """The program ended with an error; the message is its last line of output."""


class SilentError(RuntimeError):
    """The pilot did not answer for too long."""


class ExternalPilot:
    """A `scenarios.Companion` for a client that keeps the time over MAVLink.

    Attributes:
        area: The assigned area.
        is_done: True if the flight is over.
    """

    def __init__(self, aboard: Aboard) -> None:
        self.area: InteractionArea | None = aboard.area
        self.is_done = False
        self._bench: Testbench | None = None
        self._program: Program | None = None
        self._patience_s = 0.0
        self._began_s = 0.0
        self._armed_us: int | None = None
        """Time at which the vehicle was last armed."""
        self._has_left = False

    def begin(self, bench: Testbench, program: Program | None, patience_s: float) -> None:
        """Wait for the pilot from now on.

        Args:
            bench: Testbench in lockstep.
            program: The program that flies; None waits for any client.
            patience_s: Wall time for the whole trial.
        """
        self._bench, self._program = bench, program
        self._patience_s, self._began_s = patience_s, time.monotonic()

    @property
    def verdict(self) -> Verdict:
        """Statement on the flight besides the truth: whether the program disarmed or left."""
        reason = "the program has left" if self._has_left else "the program did not disarm"
        return Verdict(success=self.is_done, reason=reason)

    @property
    def touchdown_enu_m(self) -> Vector3 | None:
        """Point that it chose to land on: the one of its latest LANDING_TARGET."""
        if self._bench is None or self._bench.external is not None:
            return None
        return self._bench.autopilot.landing_target.latest_enu_m

    def update(self, time_us: int) -> None:
        """Notice the end of the flight."""
        assert self._bench is not None
        lockstep = self._bench.server.lockstep
        assert lockstep is not None
        # A flight is over only after it was armed: a program may take its time before.
        if self._bench.autopilot.is_armed:
            self._armed_us = time_us
        elif self._has_left:
            self.is_done = True
        elif self._armed_us is not None and not lockstep.has_ticks:
            # Only when no granted tick is left.
            self.is_done = time_us - self._armed_us >= _DISARMED_US
        if self.is_done:
            lockstep.release()

    def look(self) -> bool:
        """Check the pilot; called again and again, even while time stands still.

        Returns:
            False: the run goes on.

        Raises:
            CrashedError: If its program has ended with an error.
            SilentError: If it does not answer.
        """
        if self.is_done or self._has_left or self._bench is None:
            return False
        status = None if self._program is None else self._program.status
        # The connection broke: wait a moment for the exit status, which says why.
        if self._bench.fault and self._program is not None and status is None:
            status = self._program.wait(_FAREWELL_S)
        if status:
            raise CrashedError(self._last_words(status))
        if self._bench.fault or status == 0:
            self._has_left = True
            lockstep = self._bench.server.lockstep
            assert lockstep is not None
            lockstep.release()
        else:
            self._mind_the_time()
        return False

    def _last_words(self, status: int) -> str:
        assert self._program is not None
        return self._program.last_line() or f"the program ended with status {status}"

    def _mind_the_time(self) -> None:
        assert self._bench is not None
        waited_s = time.monotonic() - self._began_s
        is_heard = any(channel.is_heard for channel in self._bench.server.channels)
        # A client that connects by itself may come at any time; a program has just been started.
        limit_s = min(_HEARTBEAT_S, self._patience_s)
        if self._program is not None and not is_heard and waited_s > limit_s:
            raise SilentError(f"no heartbeat within {limit_s:g} s")
        if waited_s > self._patience_s:
            lockstep = self._bench.server.lockstep
            has_begun = lockstep is not None and lockstep.has_keeper
            # A pilot that grants no time never moves the vehicle.
            why = "" if has_begun else ": it grants no time, see docs/lockstep.md"
            raise SilentError(f"no end in {self._patience_s:g} s{why}")
