"""Guard of the phases in the air: conditions that end or change any of them, checked first.

A phase should only care for its own task. Conditions that may arise in any phase, such as a low
battery or a lost position, are therefore checked here before each action. The checks are ordered by
urgency: the first one that demands an action decides.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.planning import PlanningError, Trajectory
from autonomy.types import Vector3
from scenarios.pilot.en_route_phases import EnRoutePhases
from scenarios.pilot.final_descent import FinalDescent
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.lookout import Lookout
from scenarios.pilot.phases import IN_THE_AIR, ON_THE_WAY, TIME_LIMIT_S, Phase, Step
from scenarios.pilot.take_over import state_at_take_over
from scenarios.pilot.tracking_statistics import MOST_STRAY_M, USUAL_STRAY_M

SILENCE_S = 0.5
"""Time without a new position after which the position is unknown."""
PATIENCE_S = 3.0
"""Longest hold with unknown position before the autopilot must take over."""
LOST_M = 0.5
"""Standard deviation of the position in the map beyond which the vehicle lands at once, while
neither satellites nor odometry measure it. It is the distance that plans keep from obstacles."""
LEAST_BATTERY = 0.2
"""Charge at which the vehicle returns home; common autopilots warn at 15 to 25%."""
LEAST_DEVIATION_M, MOST_DEVIATION_M = USUAL_STRAY_M, MOST_STRAY_M
"""Bounds of the allowed deviation from the plan. Between them, it is the plan's clearance, or the
distance that the vehicle is known to stray."""
DEVIATION_PERIOD_S = 1.0
"""Time between two plans from a deviating state."""
CARRIED_S = 60.0
"""Total time of one flight in which gusts carry the vehicle off and no phase's clock runs."""
_PULL_STEP_M = 0.1
"""Step of the check along the straight line back to the course."""
# A hold would end the last stretch, so the vehicle goes on sinking there.
_NEVER_HOLD = frozenset({Phase.TOUCHDOWN, Phase.LAND_HOME})
_AT_THE_GROUND = frozenset({Phase.TOUCHDOWN, Phase.LAND_HOME})
"""Phases whose last stretch an autopilot may fly by itself."""
_RISING = frozenset({Phase.TAKEOFF, Phase.CLIMB})
_GOING_DOWN = frozenset({Phase.DESCEND, Phase.TOUCHDOWN, Phase.RETURN, Phase.LAND_HOME})
"""Phases that reach the ground sooner than a return would."""


class Guard:
    """Checks the conditions of every phase in the air."""

    def __init__(self, flight: FlightState, en_route: EnRoutePhases, descent: FinalDescent) -> None:
        self._flight, self._en_route, self._descent = flight, en_route, descent
        self._lookout = Lookout(flight, en_route)
        self._position_ms = -1
        self._heard_us = 0
        self._deviation_due_us = 0
        self._checked_us = 0
        self._carried_us = 0

    def check(self, phase: Phase) -> Step:
        """Return the action needed before anything else, None if all is well."""
        step = self._check(phase)
        self._checked_us = self._flight.time_us
        return step

    def _check(self, phase: Phase) -> Step:
        if phase in IN_THE_AIR:
            checks = (
                self._control,
                self._whereabouts,
                self._trust,
                self._battery,
                self._deviation,
                self._lookout.check,
            )
            for check in checks:
                if step := check(phase):
                    return step
        return self._clock(phase)

    def _control(self, phase: Phase) -> Step:
        """Check that the vehicle is armed and in offboard mode.

        If not, somebody else has taken over, and the flight ends for this pilot.
        """
        flight = self._flight
        mode, habits = flight.telemetry.custom_mode, flight.client.habits
        if phase in _AT_THE_GROUND and mode == habits.land:
            return None if flight.telemetry.is_armed else (Phase.DISARM, "landed by itself")
        if not flight.telemetry.is_armed:
            return Phase.FAILED, f"disarmed in phase {phase.value}{flight.last_words()}"
        if mode != habits.offboard:
            return Phase.FAILED, f"the autopilot left offboard mode{flight.last_words()}"
        return None

    def _whereabouts(self, phase: Phase) -> Step:
        """Check that the position is known."""
        flight = self._flight
        flight.complaint = self._complaint()
        if flight.complaint is None or phase in _NEVER_HOLD:
            return None
        if phase is not Phase.HOLD:
            return self._en_route.hold(flight.complaint)
        if flight.elapsed_s > PATIENCE_S:
            flight.given_up = flight.given_up or flight.complaint
            return Phase.HAND_OVER, flight.complaint
        return None

    def _trust(self, phase: Phase) -> Step:
        """Check that the images give the position, if nothing else does."""
        flight = self._flight
        senses = flight.senses
        if not senses.is_adrift or phase in _AT_THE_GROUND or senses.place_sigma_m <= LOST_M:
            return None
        reason = (
            "nothing measures the position any more, and the images do not tell it to better "
            f"than {senses.place_sigma_m:.1f} m"
        )
        flight.given_up = flight.given_up or reason
        return Phase.HAND_OVER, reason

    def _complaint(self) -> str | None:
        flight = self._flight
        telemetry = flight.telemetry
        if telemetry.position_time_ms != self._position_ms:
            self._position_ms, self._heard_us = telemetry.position_time_ms, flight.time_us
        if flight.time_us - self._heard_us > 1e6 * SILENCE_S:
            return f"no position from the autopilot for {SILENCE_S} s"
        if not telemetry.is_navigating:
            return "the autopilot's estimator does not know the position"
        return None

    def _battery(self, phase: Phase) -> Step:
        flight = self._flight
        # Going down already lands sooner than a return would.
        left = flight.telemetry.battery_remaining
        # The battery is NaN before the first report.
        if phase in _GOING_DOWN or flight.given_up is not None or not left < LEAST_BATTERY:
            return None
        return self._go_home(phase, f"the battery is down to {100 * left:.0f}%")

    def _deviation(self, phase: Phase) -> Step:
        """Check that the vehicle is on its course; else plan from its state.

        While it hovers or sinks at the area, the autopilot may pull it straight back instead.
        """
        flight = self._flight
        if flight.course.is_touching_down or flight.time_us < self._deviation_due_us:
            return None
        if phase in _RISING and self._still_rises():
            # Nothing is won by a stop: the higher, the less stands around.
            return None
        # Distance from the set point, not from the path: the plan's times are guarded too.
        here, should = flight.telemetry.position_enu_m, flight.setpoint.position_enu_m
        # The rotors spin up while the plan already rises: a vertical lag is harmless.
        n = 2 if phase is Phase.TAKEOFF else 3
        away_m = math.dist(here[:n], should[:n])
        limit_m = deviation_limit_m(flight.course.trajectory, flight.tracking.stray_m)
        if away_m <= limit_m:
            return None
        if phase not in ON_THE_WAY and self._is_free_between(here, should):
            self._grant_time()
            return None
        self._deviation_due_us = flight.time_us + round(1e6 * DEVIATION_PERIOD_S)
        reason = f"{away_m:.2f} m from the plan, {limit_m:.2f} m are allowed"
        start = state_at_take_over(flight)
        if phase is Phase.HOLD:
            return self._en_route.stop_elsewhere(reason, start)
        if phase not in ON_THE_WAY:
            return self._en_route.hold(reason, start)
        try:
            flight.go_on_from(start, self._en_route.goal_enu_m, reason)
        except PlanningError as error:
            return self._en_route.hold(f"{reason}; {error}", start)
        return None

    def _still_rises(self) -> bool:
        """Return whether the climb goes on, for the plan or for a vehicle that lifted off late."""
        flight = self._flight
        below_m = flight.setpoint.position_enu_m[2] - flight.telemetry.position_enu_m[2]
        return flight.course.is_under_way(flight.time_us) or below_m > LEAST_DEVIATION_M

    def _grant_time(self) -> None:
        """Do not count the present tick of a phase, because a gust carries the vehicle off."""
        flight = self._flight
        # Limited, so that a storm without end does not keep the vehicle in the air for ever.
        if self._carried_us < 1e6 * CARRIED_S:
            tick_us = flight.time_us - self._checked_us
            self._carried_us += tick_us
            flight.since_us += tick_us

    def _is_free_between(self, here_enu_m: Vector3, there_enu_m: Vector3) -> bool:
        """Return whether the autopilot can pull the vehicle straight back to its course."""
        n = 2 + math.ceil(math.dist(here_enu_m, there_enu_m) / _PULL_STEP_M)
        line = np.linspace(here_enu_m, there_enu_m, n)
        return bool(np.all(self._flight.mission.surroundings.clearance_m(line) > 0.0))

    def _clock(self, phase: Phase) -> Step:
        """End a phase that takes too long."""
        flight = self._flight
        limit_s = TIME_LIMIT_S.get(phase, math.inf)
        if flight.elapsed_s <= limit_s:
            return None
        reason = f"phase {phase.value} took more than {limit_s:.0f} s"
        if phase is Phase.TOUCHDOWN:
            return self._descent.leave(reason)
        if phase not in IN_THE_AIR:
            return Phase.FAILED, reason + flight.last_words()
        if flight.given_up is not None:
            return Phase.HAND_OVER, reason
        return self._go_home(phase, reason)

    def _go_home(self, phase: Phase, reason: str) -> Step:
        """Give up; a hold that is not at rest yet goes on, once more as long, and leads home."""
        flight = self._flight
        step = self._en_route.go_home(reason)
        if phase is Phase.HOLD and step is not None and step[0] is Phase.HOLD:
            flight.since_us = flight.time_us
            return None
        return step


def deviation_limit_m(trajectory: Trajectory, stray_m: float = 0.0) -> float:
    """Return the allowed distance from a plan: its certified clearance, or an unavoidable stray.

    Args:
        trajectory: The plan.
        stray_m: Distance to which the vehicle is known to stray from any plan.
    """
    clearance_m = trajectory.min_clearance_m
    if math.isnan(clearance_m):
        return MOST_DEVIATION_M
    return min(max(clearance_m, stray_m, LEAST_DEVIATION_M), MOST_DEVIATION_M)
