"""How each mode flies: one behaviour a mode, from the vehicle's state to a setpoint each tick."""

from __future__ import annotations

from typing import Protocol

from autonomy.types import Setpoint
from flightsim.autopilot.modes import Mode


class Behaviour(Protocol):
    """A way to fly. Made when its mode begins, started when the vehicle flies in it."""

    next_mode: Mode | None
    """Set when this behaviour is done and another mode should follow."""

    @property
    def is_landing(self) -> bool:
        """Whether it means to touch the ground now."""
        ...

    @property
    def may_rest(self) -> bool:
        """Whether it leads down, so that rotors may idle once something carries the vehicle."""
        ...

    def ready_to_lift(self) -> bool:
        """One tick on the ground with idle rotors; whether to take off now."""
        ...

    def start(self) -> None:
        """Begin to fly, from the references in `Flight`."""
        ...

    def update(self) -> Setpoint:
        """One tick of flying."""
        ...
