"""Every threshold of the verdict, in this one place; docs/verdict.md gives the reason for each.

A recording keeps the limits that it was judged by.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Thresholds by which a flight is measured and judged."""

    trial_s: float = 240.0
    """Simulated time after which a trial is over."""
    settle_s: float = 1.0
    """Least time that is watched after the pilot is done."""
    longest_settle_s: float = 5.0
    """Time within which vehicle and rotors must have come to rest after that."""
    longest_fall_s: float = 120.0
    """Longest time that is watched until a vehicle is down that its pilot left in the air."""

    lift_off_s: float = 0.5
    """A vehicle without contact for this long has left the ground."""
    contact_gap_s: float = 0.2
    """Contacts with one object that are closer in time count as one."""
    above_m: float = 5.0
    """Height over an area within which a flight has come to it."""
    surface_tolerance_m: float = 0.15
    """Height from an area's plane within which a sole stands on the area."""

    touchdown_error_m: float = 0.5
    """Greatest distance of the resting place from the chosen point."""
    touchdown_speed_mps: float = 1.0
    """Greatest speed at the first contact."""
    slide_m: float = 0.3
    """Greatest distance from the place of the first contact, afterwards."""
    tilt_deg: float = 20.0
    """Greatest tilt at rest."""
    mover_m: float = 0.3
    """Least distance between the hulls of the vehicle and of any mover."""

    rest_s: float = 0.5
    """Last part of the flight, in which the vehicle must be at rest."""
    rest_mps: float = 0.05
    """Greatest speed at rest."""
    rest_radps: float = 0.1
    """Greatest angular rate at rest."""
    rotor_share: float = 0.1
    """Share of the speed of hover below which rotors stand still."""
    unloaded_share: float = 0.3
    """Share of the weight below which rotors no longer carry the vehicle after a touchdown."""
    loaded_share: float = 0.5
    """Share of the weight above which rotors that no longer carried it have spun up again."""

    def to_plain(self) -> dict[str, float]:
        """Return the thresholds as plain data."""
        return asdict(self)


LIMITS = Limits()
"""The limits of every flight."""
