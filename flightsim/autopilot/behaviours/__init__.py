"""Flight behaviours: one per mode, from the vehicle's state to a setpoint each tick."""

from __future__ import annotations

from typing import Protocol

from autonomy.types import Setpoint
from flightsim.autopilot.modes import Mode


class Behaviour(Protocol):
    """A way to fly: created when its mode begins, started when the vehicle flies in it."""

    next_mode: Mode | None
    """Mode that should follow; set when this behaviour is done."""

    @property
    def is_landing(self) -> bool:
        """Whether the behaviour intends to touch the ground now."""
        ...

    @property
    def may_rest(self) -> bool:
        """Whether it leads down, so that the rotors may idle once something carries the vehicle."""
        ...

    def ready_to_lift(self) -> bool:
        """Run one tick on the ground with idle rotors; return whether to take off now."""
        ...

    def start(self) -> None:
        """Begin to fly, from the references in `FlightContext`."""
        ...

    def update(self) -> Setpoint:
        """Run one tick of flight."""
        ...
