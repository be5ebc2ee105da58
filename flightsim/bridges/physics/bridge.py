"""Physics protocol of an external flight stack: motor outputs in, sensors or truth out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flightsim.plant import Plant

MotorOutputs = tuple[float, float, float, float]
"""Outputs of the motors 1 to 4, 0 to 1."""


class BridgeError(ValueError):
    """An external flight stack cannot be waited for, started or understood."""


@dataclass(slots=True)
class Exchanges:
    """Count of what has passed between our physics and a flight stack.

    In lockstep each state is answered once: `told` is `answered` plus `unanswered`, but for one at
    an end of the run. PX4 holds the last state then; ArduPilot asks before it is told the first.
    """

    told: int = 0
    """States that the stack has been told."""
    answered: int = 0
    """Steps by the stack's answer to the state before them."""
    unanswered: int = 0
    """Steps without one, while the stack started."""
    repeated: int = 0
    """Requests and answers for a step that had been made; they made none."""
    left_out: int = 0
    """Steps that the stack's own count or clock passes over."""

    @property
    def is_whole(self) -> bool:
        """Whether no step was lost or doubled."""
        return abs(self.told - self.answered - self.unanswered) <= 1 and not self.left_out


class Bridge(Protocol):
    """One exchange a control tick: tell the state, then wait for the outputs of the next tick.

    Attributes:
        address: Where the flight stack finds the physics, in words.
        notices: A line for each thing worth saying; whoever says them takes them out.
        n_restarts: How many times the flight stack has begun anew.
        exchanges: What has passed.
    """

    address: str
    notices: list[str]
    n_restarts: int
    exchanges: Exchanges

    def connect(self, timeout_s: float) -> bool:
        """Whether a flight stack is there; waits for one at most this wall time."""
        ...

    def tell(self, plant: Plant) -> None:
        """Send the present state, unless nobody waits for it."""
        ...

    def receive(self, timeout_s: float) -> MotorOutputs | None:
        """Outputs for the next control tick; None if they do not come within this wall time."""
        ...

    def close(self) -> None:
        """Release the port."""
        ...
