"""Lookout for changes since the plan was made: movers, and new parts of a growing map.

The last frames decide whether the present plan still holds. If it does not, the least change that
helps is made: a new plan, else a stop.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.planning import PlanningError
from scenarios.pilot.en_route_phases import EnRoutePhases
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.movers import KEEP_FROM_MOVERS_M, first_to_come
from scenarios.pilot.phases import ON_THE_WAY, Phase, Step

UNSEEN_AHEAD_S = 4.0
"""Remaining flight time at which a plan that ends short of the goal is replaced."""
KEEP_IN_VIEW_M = 1.5
"""Predicted distance within which a mover is kept in view until it has passed."""
_STEP_S = 0.1  # between the samples of a plan that are checked


class Lookout:
    """Looks ahead, and changes the course if necessary."""

    def __init__(self, flight: FlightState, en_route: EnRoutePhases) -> None:
        self._flight, self._en_route = flight, en_route

    def check(self, phase: Phase) -> Step:
        """Return the action demanded by the latest images, None if the plan still holds."""
        flight = self._flight
        # In the last stretch the vehicle goes down in any case.
        if not flight.senses.look_about() or phase is Phase.TOUCHDOWN:
            return None
        self._keep_in_view()
        return self._movers(phase) or self._unseen(phase)

    def _keep_in_view(self) -> None:
        """Aim the gaze at the mover that comes near soonest, else at an uncertain one."""
        flight = self._flight
        if flight.gaze is None:
            return
        place = first_to_come(
            flight.course.trajectory,
            flight.course.elapsed_s(flight.time_us),
            flight.senses.moving(flight.time_us),
            flight.mission.surroundings.radius_m + KEEP_IN_VIEW_M,
        )
        here = np.array(flight.telemetry.position_enu_m)
        doubtful = flight.senses.in_question()
        if place is None and len(doubtful):
            nearest = np.argmin(np.linalg.norm(doubtful - here, axis=1))
            place = tuple(doubtful[nearest].tolist())
        away = np.subtract(place, here) if place is not None else None
        flight.gaze.kept_rad = None if away is None else math.atan2(away[1], away[0])

    def _movers(self, phase: Phase) -> Step:
        """Check whether movers come too near to the course or to its end."""
        flight = self._flight
        room_m = flight.room_to_movers_m()
        if room_m >= KEEP_FROM_MOVERS_M:
            return None
        reason = f"something that moves would come within {max(room_m, 0.0):.2f} m"
        if phase is Phase.HOLD:
            return self._en_route.stop_elsewhere(reason)
        if phase in ON_THE_WAY:
            try:
                flight.replan(reason)
            except PlanningError as error:
                return self._en_route.hold(f"{reason}; {error}")
            if flight.room_to_movers_m() < KEEP_FROM_MOVERS_M:
                # No path to the plan's end helps if the mover comes there afterwards.
                return self._en_route.hold(f"{reason} where the plan ends")
            return None
        return self._en_route.hold(reason)

    def _unseen(self, phase: Phase) -> Step:
        """Check, in a growing map, that the plan is still free and reaches as far as possible."""
        flight = self._flight
        world = flight.mission.surroundings
        if world.is_known or phase not in ON_THE_WAY:
            return None
        since_s = flight.course.elapsed_s(flight.take_over_us)
        is_free = self._is_free(since_s)
        left_s = flight.course.trajectory.duration_s - since_s
        is_short = left_s < UNSEEN_AHEAD_S and not flight.is_at_end(self._en_route.goal_enu_m)
        if is_free and not is_short:
            return None
        reason = "more of the map was seen" if is_free else "something stands in the way"
        try:
            start = flight.course.reference(flight.take_over_us)
            flight.go_on_from(start, self._en_route.goal_enu_m, reason)
        except PlanningError as error:
            # The present plan ends at rest within the known free space.
            return None if is_free else self._en_route.hold(f"{reason}; {error}")
        return None

    def _is_free(self, since_s: float) -> bool:
        flight = self._flight
        plan = flight.course.trajectory
        times = np.arange(max(since_s, 0.0), plan.duration_s + _STEP_S, _STEP_S)
        return bool(np.all(flight.mission.surroundings.clearance_m(plan.positions(times)) > 0.0))
