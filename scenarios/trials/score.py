"""Figures of a flight by the truth: errors, contacts, touchdown, resting place, rotors.

This is the complete set for a result or a row of a table; `figures` measures single ones on demand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from flightsim.vehicles.airframe import Airframe
from scenarios.trials.bounds import Touched
from scenarios.trials.contacts import Contact
from scenarios.trials.figures import Figures, Goal
from scenarios.trials.measures.effort import Effort
from scenarios.trials.measures.estimation import EstimationErrors


@dataclass(frozen=True, kw_only=True, slots=True)
class FlightScore:
    """Figures of one flight; the defaults are of a run that was stopped before its first step."""

    position_rmse_m: float = math.nan
    """Estimated against true position from arming on, root mean square of the 3-D distance."""
    attitude_rmse_deg: float = math.nan
    """Estimated against true attitude from arming on, root mean square of the angle between."""
    lift_off_s: float | None = None
    """Time at which the vehicle left the ground; None if it never did."""
    reached_s: float | None = None
    """Time at which it was first in flight above the assigned area; None if it never was."""
    touchdown_s: float | None = None
    """Time of the first contact with the assigned area, else of the last time on the ground; None
    if it ended in the air."""
    contacts_before_touchdown: int = 0
    """Separate contacts between lift-off and touchdown."""
    touched_before: tuple[Contact, ...] = ()
    """The contacts between lift-off and touchdown."""
    contacts: tuple[Contact, ...] = ()
    """All contacts after lift-off."""
    landed_area: int | None = None
    """Area that all soles ended on, the assigned one or another; None if there is none."""
    n_soles: int = 4
    n_soles_inside: int = 0
    """Soles that ended on the assigned area."""
    touchdown_error_m: float | None = None
    """Horizontal distance of the resting place from the chosen point of the assigned area."""
    touchdown_speed_mps: float | None = None
    """Speed at touchdown."""
    slide_m: float | None = None
    """Greatest horizontal distance, after the touchdown, from the place of the touchdown."""
    tilt_at_rest_deg: float = 0.0
    is_at_rest: bool = False
    stopped_after_s: float | None = None
    """Time from the touchdown until the rotors stood still for good; None if they still turn."""
    rotor_spin_ups: int = 0
    """Times that the rotors took the weight again after the touchdown had taken it from them."""
    least_clearance_m: float | None = None
    """Least distance of the vehicle's sphere from static obstacles, away from both ends of the
    path."""
    nearest_mover_m: float | None = None
    """Least distance in flight between the hulls of the vehicle and of movers."""
    effort: Effort = field(default_factory=Effort)
    """Time, energy and jerk from lift-off on."""

    @property
    def has_flown(self) -> bool:
        """True if the vehicle left the ground."""
        return self.lift_off_s is not None

    @property
    def is_down(self) -> bool:
        """True if the flight ended on the ground, or on something else."""
        return self.touchdown_s is not None


AnyScore = FlightScore | Figures
"""Figures of a flight, measured already or when asked for."""

# Names that `Figures` and `FlightScore` share.
_MEASURED = (
    *("lift_off_s", "reached_s", "touchdown_s", "contacts_before_touchdown", "touched_before"),
    *("contacts", "landed_area", "n_soles", "n_soles_inside", "touchdown_error_m"),
    *("touchdown_speed_mps", "slide_m", "tilt_at_rest_deg", "is_at_rest", "stopped_after_s"),
    "rotor_spin_ups",
)


def score_flight(
    history: np.ndarray, airframe: Airframe, goal: Goal, touched: Touched | None = None
) -> FlightScore:
    """Measure a flight.

    Args:
        history: Row for each control tick (`flightsim.plant.record`).
        airframe: Vehicle that flew.
        goal: Place where it should have ended.
        touched: Contacts of the flight; None if only their times are known.
    """
    # All figures at once: a result lists them all, while a verdict alone asks for few.
    figures = Figures(history, airframe, goal, touched)
    errors = EstimationErrors()
    errors.add(history)
    return FlightScore(
        position_rmse_m=errors.position_rmse_m,
        attitude_rmse_deg=errors.attitude_rmse_deg,
        **{name: getattr(figures, name) for name in _MEASURED},
    )
