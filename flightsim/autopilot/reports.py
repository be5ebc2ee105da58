"""Reports that are shown and recorded of any flight stack, our autopilot or another one."""

from __future__ import annotations

from typing import Protocol


class Named(Protocol):
    """A state that has a name for people, such as a mode."""

    @property
    def value(self) -> str:
        """Name for people."""
        ...


class FlightReports(Protocol):
    """Reports of a flight stack, as recorders and displays need them."""

    @property
    def mode(self) -> Named:
        """Present mode."""
        ...

    @property
    def is_armed(self) -> bool:
        """True if the rotors may turn."""
        ...

    @property
    def landed_state(self) -> Named:
        """Phase between ground and air."""
        ...

    @property
    def failsafe(self) -> Named | None:
        """Reason of a failsafe; None if there is none, or the stack names none."""
        ...
