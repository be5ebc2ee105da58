"""Phases on the way: take off, navigate, hold, and return home when no area is left.

Each method is the action of one phase. It is called every tick and returns the next phase with a
reason, or None to stay. A failed plan is no error here: each action has a next best one, down to
handing over to the autopilot.
"""

from __future__ import annotations

import logging
import math

from autonomy.planning import BlockedError, PlanningError, UnreachableError
from autonomy.types import FlatReference, Vector3
from flightsim.mavlink.client.telemetry import LANDED_ON_GROUND
from scenarios.pilot.final_descent import COMMIT_HEIGHTS_M, LAST_HEIGHT_M
from scenarios.pilot.flight_state import SET_OUT_M, FlightState
from scenarios.pilot.gaze import Gaze
from scenarios.pilot.landing_phases import LandingPhases
from scenarios.pilot.phases import Phase, Replan, Step
from scenarios.pilot.return_path import is_return_path_free
from scenarios.pilot.take_over import state_at_take_over

_LOG = logging.getLogger(__name__)

MAX_HOLDS = 6
"""Number of holds in one flight; with one more the vehicle goes home."""
MOST_RISE_M = 8.0
"""Greatest initial climb; the rest of the climb is part of the plan."""
RISE_SPEED_MPS = 1.5
LOOK_AHEAD_S = 1.0
"""Time before the end of the plan from which the area is looked at."""
RETRY_PERIOD_S = 1.0
"""Time between two attempts to continue from a hold."""


class EnRoutePhases:
    """Flies the phases between the start and the area, and back."""

    def __init__(self, flight: FlightState, area: LandingPhases) -> None:
        self._flight = flight
        self._area = area
        self._retry_us = 0
        self._has_risen = False
        self._has_set_out = False

    @property
    def goal_enu_m(self) -> Vector3:
        """Next goal: home after giving up, else above the area."""
        flight = self._flight
        if flight.given_up is not None:
            return flight.mission.takeoff_enu_m
        return flight.hover_enu_m

    def take_off(self) -> Step:
        """Climb to above the start, then navigate.

        On a given map without traffic the climb is left as soon as the vehicle is clear of the
        start.
        """
        flight = self._flight
        if not flight.has_arrived:
            return self._set_out()
        if flight.gaze is not None and not self._has_looked(flight.gaze):
            return None
        try:
            # The mission's trajectory was planned at the usual pace, so in wind a slower one is
            # planned.
            prepared = None if flight.is_windy else flight.mission.trajectory
            flight.plan_to(flight.hover_enu_m, prepared)
        except PlanningError as error:
            return self.hold(f"no way from above the start: {error}")
        return Phase.NAVIGATE, "above the start"

    def _set_out(self) -> Step:
        """Leave the climb once, as soon as the vehicle has room, and fly on from where it is.

        If movers may come, or the map grows, the vehicle looks from above the start first.
        """
        flight = self._flight
        height_m = flight.telemetry.position_enu_m[2] - flight.home_resting_height_m
        looks = flight.gaze is not None or not flight.mission.surroundings.is_known
        if self._has_set_out or looks or height_m < SET_OUT_M:
            return None
        self._has_set_out = True
        try:
            flight.plan_to(flight.hover_enu_m, start=state_at_take_over(flight))
        except PlanningError as error:
            _LOG.info("no way from the climb: %s", error)
            return None
        return Phase.NAVIGATE, "clear of the start"

    def _has_looked(self, gaze: Gaze) -> bool:
        """Climb to the flight height and look all around once; return whether that is done."""
        flight = self._flight
        if not self._has_risen:
            self._has_risen = True
            self._rise(flight.hover_enu_m[2])
            return False
        return gaze.has_looked_round(flight.time_us)

    def _rise(self, height_m: float) -> None:
        """Climb vertically first if that is free: then no mover reaches a level path from above."""
        flight = self._flight
        x, y, z = flight.setpoint.position_enu_m
        if not 0.0 < height_m - z <= MOST_RISE_M:
            return
        try:
            leg = flight.leg((x, y, height_m), RISE_SPEED_MPS)
            # Only if there is a plan from up there, too.
            world = flight.mission.surroundings
            world.plan(leg.sample(leg.duration_s), flight.hover_enu_m)
        except PlanningError:
            return
        flight.begin_with(leg)

    def navigate(self) -> Step:
        """Fly the plan to above the area.

        In a growing map the plan may end short of it; then it is continued.
        """
        flight = self._flight
        if not flight.course.ends_within(flight.time_us, LOOK_AHEAD_S):
            return None
        if flight.is_at_end(flight.hover_enu_m):
            # From here on the gaze is downward.
            is_ready = flight.gaze is None or self._has_looked_above(flight.gaze)
            return self._area.look(f"above area {flight.area.id}") if is_ready else None
        return self._go_on() if flight.has_arrived else None

    def _has_looked_above(self, gaze: Gaze) -> bool:
        """Look all around once above the area; return whether that is done."""
        flight = self._flight
        return flight.has_arrived and gaze.has_looked_round(flight.time_us)

    def go_home(self, reason: str) -> Step:
        """Give up: plan the path home, else hand over to the autopilot."""
        flight = self._flight
        flight.given_up = flight.given_up or reason
        try:
            flight.plan_to(flight.mission.takeoff_enu_m)
        except PlanningError as error:
            # A moving vehicle stops first.
            if not flight.is_resting():
                return self.hold(reason)
            return Phase.HAND_OVER, f"{reason}; no certified way home: {error}"
        return Phase.RETURN, reason

    def hand_over(self) -> Step:
        """Hand over to the autopilot: its own return if the path is free, else it lands here.

        The autopilot has no map, and under a roof its return climbs into that.
        """
        flight = self._flight
        if not flight.commands:
            habits, world = flight.client.habits, flight.mission.surroundings
            here, home = flight.telemetry.position_enu_m, flight.mission.takeoff_enu_m
            # Without a position no return finds home.
            returns = not flight.senses.is_adrift and is_return_path_free(world, here, home)
            mode = habits.return_home if returns else habits.land_here
            _LOG.info("left to the autopilot, to %s", "return" if returns else "land here")
            flight.commands = [flight.client.set_mode(mode)]
        if all(command.is_done for command in flight.commands):
            return Phase.FAILED, flight.given_up or "handed over to the autopilot"
        return None

    def fly_home(self) -> Step:
        """Fly the plan to above the start, then down to where the last stretch begins."""
        flight = self._flight
        if not flight.has_arrived:
            return None
        home = flight.mission.takeoff_enu_m
        if not flight.is_at_end(home):
            return self._go_on()
        # Not above the take-off point, even if that is low.
        commit_m = min(flight.home_resting_height_m + COMMIT_HEIGHTS_M[-1], home[2])
        try:
            flight.begin_with(flight.leg((home[0], home[1], commit_m), flight.pace.descent_mps))
        except PlanningError as error:
            return self.hold(f"no certified way down at home: {error}")
        return Phase.LAND_HOME, "above the start"

    def land_home(self) -> Step:
        """Descend vertically onto the start."""
        flight = self._flight
        if flight.course.is_touching_down:
            if flight.telemetry.landed_state == LANDED_ON_GROUND:
                return Phase.DISARM, "on the ground at home"
            if flight.setpoint.position_enu_m[2] - flight.home_resting_height_m < LAST_HEIGHT_M:
                flight.let_land()
            return None
        if flight.has_arrived:
            flight.touch_down(flight.home_resting_height_m)
        return None

    def hold(self, reason: str, start: FlatReference | None = None) -> Step:
        """Come to rest and wait; after too many holds, go home or hand over.

        Args:
            reason: Reason for the hold.
            start: State of the vehicle when the stop takes over; None for the state on the course.
        """
        flight = self._flight
        flight.n_holds += 1
        is_last = flight.n_holds > MAX_HOLDS
        if step := self._brake(reason, start):
            return step
        # The return has used up its holds as well.
        if flight.n_holds > 2 * MAX_HOLDS:
            return Phase.HAND_OVER, f"{reason}; held {2 * MAX_HOLDS} times"
        if is_last:
            flight.given_up = flight.given_up or f"{reason}; held {MAX_HOLDS} times"
        self._retry_us = flight.time_us + round(1e6 * RETRY_PERIOD_S)
        flight.after_hold = self._resumed()
        return Phase.HOLD, reason

    def stop_elsewhere(self, reason: str, start: FlatReference | None = None) -> Step:
        """Change to another stop: clear of approaching movers, or near the displaced vehicle."""
        if step := self._brake(reason, start):
            return step
        flight = self._flight
        flight.replans.append(Replan(time_us=flight.time_us, reason=reason))
        return None

    def _brake(self, reason: str, start: FlatReference | None) -> Step:
        """Brake, or hand over to the autopilot if no stop can be certified.

        If the vehicle was blown to a place from which no stop leads away, it is pulled back to the
        stop of its course.
        """
        flight = self._flight
        try:
            flight.brake(start)
        except PlanningError as error:
            if start is not None:
                return self._brake(reason, None)
            flight.given_up = flight.given_up or reason
            return Phase.HAND_OVER, f"{reason}; no certified stop: {error}"
        return None

    def _resumed(self) -> Phase:
        """Phase that follows the hold beginning now."""
        if self._flight.given_up is not None:
            return Phase.RETURN
        return Phase.NAVIGATE if self._flight.watch is None else Phase.CLIMB

    def wait(self) -> Step:
        """Hold until there is a certified path on; the guard evades approaching movers."""
        flight = self._flight
        is_ready = flight.complaint is None and flight.has_arrived
        if flight.time_us < self._retry_us or not is_ready:
            return None
        if flight.gaze is not None and not flight.gaze.is_on_it:
            # A mover nearby was lost from view: look at it first.
            return None
        self._retry_us = flight.time_us + round(1e6 * RETRY_PERIOD_S)
        try:
            flight.go(self.goal_enu_m)
        except PlanningError:
            return None
        return flight.after_hold, "there is a way on"

    def _go_on(self) -> Step:
        """Continue from the end of a plan within the known free space."""
        flight = self._flight
        try:
            flight.plan_to(self.goal_enu_m)
        except PlanningError as error:
            reason = f"what was seen shows no way on: {error}"
            # Cut off for good: another goal may help. Any other failure may pass by waiting.
            is_cut_off = isinstance(error, BlockedError | UnreachableError)
            if is_cut_off and flight.given_up is None:
                return self._aim_elsewhere(reason)
            return self.hold(reason)
        return None

    def _aim_elsewhere(self, reason: str) -> Step:
        """Replace a goal that was found blocked: another height above the area, or another area."""
        flight = self._flight
        hover = flight.mission.surroundings.hover_point(flight.area)
        if hover is not None and math.dist(hover, flight.hover_enu_m) > 0.0:
            flight.hover_enu_m = hover
            return None
        step = self._area.give_up(reason)
        if step is None or step[0] is not Phase.NAVIGATE:
            return step
        flight.replans.append(Replan(time_us=flight.time_us, reason=step[1]))
        return None
