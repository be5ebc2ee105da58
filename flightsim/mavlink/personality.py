"""Personality of a flight stack: its identity, mode numbers and encodings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flightsim.autopilot.modes import Mode


@dataclass(frozen=True, kw_only=True)
class ModeEntry:
    """Numbers of one flight mode in a flight stack."""

    mode: Mode
    custom_mode: int
    base_mode: int
    """MAV_MODE_FLAG bits without "armed"."""
    standard_mode: int = 0
    """MAV_STANDARD_MODE; 0 is non-standard."""
    is_selectable: bool = True
    """Whether a client may select the mode."""


@dataclass(frozen=True, kw_only=True)
class Personality:
    """Identity, mode table and encodings of a flight stack."""

    name: str
    autopilot: int
    """Value of MAV_AUTOPILOT."""
    modes: tuple[ModeEntry, ...]
    mode_shift: Mapping[str, int]
    """Bits by which DO_SET_MODE's "main" and "sub" are shifted into the custom mode."""
    flight_sw_version: int
    flight_custom_version: bytes
    capabilities: int
    """Bits of MAV_PROTOCOL_CAPABILITY."""

    def entry(self, mode: Mode) -> ModeEntry:
        """Entry that reports a mode."""
        return next(entry for entry in self.modes if entry.mode is mode)

    def selectable(self, custom_mode: int) -> Mode | None:
        """Selectable mode with a custom mode number; None if there is none."""
        for entry in self.modes:
            if entry.custom_mode == custom_mode and entry.is_selectable:
                return entry.mode
        return None

    def standard(self, standard_mode: int) -> Mode | None:
        """Selectable mode with a MAV_STANDARD_MODE; None if there is none."""
        for entry in self.modes:
            if standard_mode and entry.standard_mode == standard_mode and entry.is_selectable:
                return entry.mode
        return None

    def custom_mode(self, main: int, sub: int) -> int:
        """Custom mode number of a DO_SET_MODE."""
        return main << self.mode_shift["main"] | sub << self.mode_shift["sub"]
