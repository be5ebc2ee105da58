"""Physics protocol of an external flight stack: motor outputs in, sensors or truth out.

Both stacks run in lockstep with the physics, once for every control tick, but the one asks and the
other is asked. `Bridge` hides that: whoever flies the plant calls `tell` and then `receive` before
every tick. `Exchanges` counts what has passed, so that a run can show that no step was lost or made
twice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flightsim.plant import Plant

MotorOutputs = tuple[float, float, float, float]
"""Outputs of the motors 1 to 4, each 0 (off) to 1 (full)."""


class BridgeError(ValueError):
    """An external flight stack cannot be waited for, started or understood."""


@dataclass(slots=True)
class Exchanges:
    """Counts of the messages that have passed between our physics and a flight stack.

    In lockstep each state is answered once, so `told` is `answered` plus `unanswered`, but for one
    at an end of the run. PX4 holds the last state then; ArduPilot asks before it gets the first.
    """

    told: int = 0
    """States sent to the stack."""
    answered: int = 0
    """Steps made by the stack's answer to the state before them."""
    unanswered: int = 0
    """Steps made without an answer, while the stack started."""
    repeated: int = 0
    """Requests and answers for a step that had been made already; they made none."""
    left_out: int = 0
    """Steps that the stack's own count or clock passes over."""

    @property
    def is_whole(self) -> bool:
        """True if no step was lost or made twice."""
        return abs(self.told - self.answered - self.unanswered) <= 1 and not self.left_out


class Bridge(Protocol):
    """One exchange per control tick: send the state, then wait for the outputs of the next tick.

    Attributes:
        address: Words that say where the flight stack finds the physics.
        notices: Lines for the user; the reader removes them.
        n_restarts: Number of times that the flight stack has begun anew.
        exchanges: Counts of what has passed.
    """

    address: str
    notices: list[str]
    n_restarts: int
    exchanges: Exchanges

    def connect(self, timeout_s: float) -> bool:
        """Return True if a flight stack is there; wait for one at most this wall time."""
        ...

    def send_state(self, plant: Plant) -> None:
        """Send the present state, unless nobody waits for it."""
        ...

    def receive(self, timeout_s: float) -> MotorOutputs | None:
        """Return the outputs for the next control tick; None if none come within this wall time."""
        ...

    def close(self) -> None:
        """Release the port."""
        ...
