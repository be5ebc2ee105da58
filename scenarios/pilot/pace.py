"""How fast the pilot flies: as usual, among movers, and in wind."""

from __future__ import annotations

from dataclasses import dataclass, replace

from autonomy.planning import FlightLimits

WINDY_MPS = 5.0
"""Wind that the autopilot reports, from which on the pilot goes carefully."""


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
        """The slower of two paces in all things."""
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
"""Slow enough to stop short of what is seen 10 m off, and so little tilted that what flies at the
vehicle's height stays in the forward camera, which sees up to 15 degrees above the body's level."""

IN_WIND = Pace(
    limits=FlightLimits(speed_horizontal_mps=5.0, acceleration_mps2=3.0),
    descent_mps=1.5,
    touchdown_mps=0.4,
)
"""Gusts add to what the vehicle does by itself: off its way, and as it meets the ground."""
