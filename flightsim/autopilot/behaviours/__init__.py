"""Flight behaviours: one per mode, from the vehicle's state to a setpoint each tick."""

from __future__ import annotations

from typing import Protocol

from autonomy.types import Setpoint
from flightsim.autopilot.modes import Mode


class Behaviour(Protocol):
    """One manner of flight: created when its mode begins, started when the vehicle flies in it.

    The two moments differ, because a mode can be chosen on the ground long before the takeoff. The
    commander calls `ready_to_lift` in each tick on the ground, then `start` once, then `update` in
    each tick of flight.
    """

    next_mode: Mode | None
    """Mode that should follow; set when this behaviour is done."""

    @property
    def is_landing(self) -> bool:
        """True if the behaviour intends to touch the ground now."""
        ...

    @property
    def may_rest(self) -> bool:
        """True if it leads down, so that the rotors may idle once something carries the vehicle."""
        ...

    def ready_to_lift(self) -> bool:
        """Run one tick on the ground with idle rotors; return true to take off now."""
        ...

    def start(self) -> None:
        """Begin to fly, from the references in `FlightContext`."""
        ...

    def update(self) -> Setpoint:
        """Run one tick of flight and return its setpoint."""
        ...
