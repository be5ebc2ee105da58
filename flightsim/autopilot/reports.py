"""What is shown and recorded of whoever flies, our autopilot or another flight stack."""

from __future__ import annotations

from typing import Protocol


class Named(Protocol):
    """A state that has a name for people."""

    @property
    def value(self) -> str:
        """The name."""
        ...


class FlightReports(Protocol):
    """Reports of a flight stack."""

    @property
    def mode(self) -> Named:
        """Present mode."""
        ...

    @property
    def is_armed(self) -> bool:
        """Whether the rotors may turn."""
        ...

    @property
    def landed_state(self) -> Named:
        """Phase between ground and air."""
        ...

    @property
    def failsafe(self) -> Named | None:
        """Reason for a failsafe, if there is one that it names."""
        ...
