"""Second looks at an area that shows no place to land on: from nearer, or from under a cover."""

from __future__ import annotations

import logging

from autonomy.planning import PlanningError
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.phases import Phase, Step

_LOG = logging.getLogger(__name__)

LEAST_LOOK_M = 1.2
"""Least height from which an area is looked at again."""
LEAST_LOWER_M = 0.3
"""Least difference in height between two looks, if a cover is passed under."""


def look_nearer(flight: FlightState, reason: str) -> Step:
    """Look again from half the height: the errors of depth grow with the square of it."""
    (x, y, z), surface_m = flight.hover_enu_m, flight.area.centroid[2]
    nearer = (x, y, (z + surface_m) / 2)
    if nearer[2] - surface_m < LEAST_LOOK_M:
        return None
    try:
        flight.begin_with(flight.leg(nearer, flight.pace.descent_mps))
    except PlanningError:
        return None
    flight.hover_enu_m = nearer
    return Phase.NAVIGATE, f"{reason}; looks from {nearer[2] - surface_m:.1f} m"


def look_from_below(flight: FlightState, reason: str) -> Step:
    """Look for a path under whatever covers the area, such as a roof that no map has.

    Only a growing map learns of covers in flight; in a given one, this returns None.
    """
    world = flight.mission.surroundings
    hover = None if world.is_known else world.hover_point(flight.area)
    if hover is None or hover[2] > flight.hover_enu_m[2] - LEAST_LOWER_M:
        return None
    try:
        flight.plan_to(hover)
    except PlanningError as error:
        _LOG.info("area %d from below: %s", flight.area.id, error)
        return None
    flight.hover_enu_m = hover
    above_m = hover[2] - flight.area.centroid[2]
    return Phase.NAVIGATE, f"{reason}; looks from {above_m:.1f} m, under what covers it"
