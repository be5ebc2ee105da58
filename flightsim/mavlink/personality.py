"""How the autopilot presents itself: numbers that differ between flight stacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flightsim.autopilot.modes import Mode


@dataclass(frozen=True, kw_only=True)
class ModeEntry:
    """One flight mode in a stack's numbers."""

    mode: Mode
    custom_mode: int
    base_mode: int
    """MAV_MODE_FLAG bits without "armed"."""
    standard_mode: int = 0
    """MAV_STANDARD_MODE; 0 is non-standard."""
    is_selectable: bool = True
    """Whether a client may ask for it."""


@dataclass(frozen=True, kw_only=True)
class Personality:
    """Identity, mode table and encodings of a flight stack."""

    name: str
    autopilot: int
    """MAV_AUTOPILOT."""
    modes: tuple[ModeEntry, ...]
    mode_shift: Mapping[str, int]
    """Bits by which DO_SET_MODE's "main" and "sub" are shifted into the custom mode."""
    flight_sw_version: int
    flight_custom_version: bytes
    capabilities: int
    """MAV_PROTOCOL_CAPABILITY bits."""

    def entry(self, mode: Mode) -> ModeEntry:
        """How a mode is reported."""
        return next(entry for entry in self.modes if entry.mode is mode)

    def selectable(self, custom_mode: int) -> Mode | None:
        """The mode a client asks for by a custom mode; None if there is none."""
        for entry in self.modes:
            if entry.custom_mode == custom_mode and entry.is_selectable:
                return entry.mode
        return None

    def standard(self, standard_mode: int) -> Mode | None:
        """The mode a client asks for by MAV_STANDARD_MODE; None if there is none."""
        for entry in self.modes:
            if standard_mode and entry.standard_mode == standard_mode and entry.is_selectable:
                return entry.mode
        return None

    def custom_mode(self, main: int, sub: int) -> int:
        """The custom mode of a DO_SET_MODE."""
        return main << self.mode_shift["main"] | sub << self.mode_shift["sub"]
