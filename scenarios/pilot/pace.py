"""Speeds of the pilot: as usual, among movers, and in wind.

Every stage takes its speeds from one `Pace`, and paces combine by the slower value. So "windy and
among movers" needs no case of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from autonomy.planning import FlightLimits

WINDY_MPS = 5.0
"""Wind, as the autopilot reports it, from which on the pilot flies more slowly."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pace:
    """Greatest speeds of the stages of a flight."""

    limits: FlightLimits
    """Limits of plans."""
    descent_mps: float
    """Greatest speed of a straight descent."""
    touchdown_mps: float
    """Speed at which the last stretch begins, before it slows down."""

    def slowed(self, other: Pace) -> Pace:
        """Return the slower of two paces in each limit."""
        mine, theirs = self.limits, other.limits
        limits = replace(
            mine,
            speed_horizontal_mps=min(mine.speed_horizontal_mps, theirs.speed_horizontal_mps),
            acceleration_mps2=min(mine.acceleration_mps2, theirs.acceleration_mps2),
        )
        return Pace(
            limits=limits,
            descent_mps=min(self.descent_mps, other.descent_mps),
            touchdown_mps=min(self.touchdown_mps, other.touchdown_mps),
        )


USUAL = Pace(limits=FlightLimits(), descent_mps=2.0, touchdown_mps=0.8)

AMONG_MOVERS = replace(USUAL, limits=FlightLimits(speed_horizontal_mps=4.0, acceleration_mps2=2.0))
"""Slow enough to stop short of anything seen 10 m off, and so little tilted that a drone at the
vehicle's height stays in the forward camera, which sees up to 15 degrees above the body's level."""

IN_WIND = Pace(
    limits=FlightLimits(speed_horizontal_mps=5.0, acceleration_mps2=3.0),
    descent_mps=1.5,
    touchdown_mps=0.4,
)
"""Gusts add to the vehicle's own deviation from its path, and to its speed as it meets the ground.
"""
