"""Ground phases: connect, wait for health, arm, and disarm at the end.

Autopilots differ in what they demand before they arm and in who takes off. The differences are in
the client's `habits`, so that one sequence serves all.
"""

from __future__ import annotations

import math

from autonomy.planning import PlanningError, prepare
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.movers import room_in_column_m
from scenarios.pilot.phases import Phase, PilotVerdict, Step

MAX_ARMING_TRIES = 10
LIFT_OFF_M = 1.0
"""Height above the resting place up to which the map is not checked, because the vehicle stood
there."""
LIFTED_OFF_M = 0.8
"""Height above the resting place at which the pilot takes over from an autopilot that took off by
itself."""
WATCH_S = 1.0
"""Time for which the air above the start is watched before the rotors turn, if movers may come:
five images of each camera, of which three confirm a mover."""
CLEAR_M = 0.5
"""Least room that movers leave to the climb."""
_STREAM_BEFORE_ARMING_S = 0.2  # offboard mode is refused before a stream of set points is known


class GroundPhases:
    """Flies the phases before take-off and after landing."""

    def __init__(self, flight: FlightState) -> None:
        self._flight = flight
        self._patience_s = 0.0
        """Time in the phase of arming until the effect of the last request must have been reported.
        """

    def connect(self) -> Step:
        """Wait until the vehicle answers and sends the telemetry needed."""
        flight = self._flight
        if flight.telemetry.system_id and not flight.commands:
            flight.commands = flight.client.request_streams()
        if flight.commands and all(command.is_done for command in flight.commands):
            return Phase.PREPARE, f"system {flight.telemetry.system_id} answers"
        return None

    def prepare(self) -> Step:
        """Wait until arming is allowed.

        The wait may take up to two minutes while a poor receiver finds its position.
        """
        flight = self._flight
        telemetry = flight.telemetry
        if not (telemetry.has_state and telemetry.is_armable and telemetry.is_navigating):
            return None
        if flight.senses.looks_ahead:
            # Building the solvers for plans made in flight takes seconds.
            prepare()
        self._stand()
        here = flight.telemetry.position_enu_m
        # Setpoints at the resting place: offboard mode requires a stream.
        flight.begin_with(flight.mission.surroundings.leg(here, here, telemetry.yaw_rad))
        return Phase.ARM, "estimator and arming checks are ready"

    def arm(self) -> Step:
        """Request offboard mode, then arm, while set points are streamed."""
        flight = self._flight
        telemetry, offboard = flight.telemetry, flight.client.habits.offboard
        if telemetry.is_armed and telemetry.custom_mode == offboard:
            if not flight.mission.surroundings.is_known:
                # Its map begins here, and the receiver has wandered since.
                self._stand()
            return self._lift_off() if flight.client.habits.takes_off_by_itself else self._rise()
        is_waiting = not all(command.is_done for command in flight.commands)
        if is_waiting or flight.elapsed_s < max(_STREAM_BEFORE_ARMING_S, self._patience_s):
            return None
        if len(flight.commands) >= MAX_ARMING_TRIES:
            outcome = flight.commands[-1].outcome()
            return Phase.FAILED, f"mode or arming: {outcome}{flight.last_words()}"
        if telemetry.custom_mode != offboard:
            flight.commands.append(flight.client.set_mode(offboard))
        elif not self._is_clear_above():
            return None
        else:
            flight.commands.append(flight.client.arm())
        self._patience_s = flight.elapsed_s + flight.client.habits.report_delay_s
        return None

    def _stand(self) -> None:
        flight = self._flight
        x, y, _ = flight.mission.takeoff_enu_m
        flight.senses.stand_at((x, y, flight.home_resting_height_m))

    def _is_clear_above(self) -> bool:
        """Return whether no mover would come into the climb; a growing map cannot know yet."""
        flight = self._flight
        if flight.gaze is None or not flight.mission.surroundings.is_known:
            return True
        flight.senses.look_about()
        if flight.elapsed_s < WATCH_S or len(flight.senses.in_question()):
            return False
        here, top_m = flight.telemetry.position_enu_m, flight.hover_enu_m[2]
        moving, radius_m = (
            flight.senses.moving(flight.time_us),
            flight.mission.surroundings.radius_m,
        )
        return room_in_column_m(here, top_m, moving, radius_m) > CLEAR_M

    def _lift_off(self) -> Step:
        """Let the autopilot take off by itself, and rise from there."""
        flight = self._flight
        here, yaw_rad = flight.telemetry.position_enu_m, flight.telemetry.yaw_rad
        if not flight.is_silent:
            flight.is_silent = True  # A setpoint would end its take-off.
            flight.commands = [flight.client.take_off(LIFT_OFF_M)]
        if here[2] - flight.home_resting_height_m < LIFTED_OFF_M:
            return None
        flight.is_silent = False
        flight.begin_with(flight.mission.surroundings.leg(here, here, yaw_rad))
        return self._rise()

    def _rise(self) -> Step:
        flight = self._flight
        try:
            leg = flight.leg(flight.mission.takeoff_enu_m, exempt_m=LIFT_OFF_M)
        except PlanningError as error:
            flight.given_up = f"no certified way up from the start: {error}"
            return Phase.DISARM, flight.given_up
        flight.begin_with(leg)
        return Phase.TAKEOFF, "armed in offboard mode"

    def disarm(self) -> Step:
        """Wait until the rotors stand still."""
        flight = self._flight
        if flight.telemetry.is_armed:
            if all(command.is_done for command in flight.commands):
                flight.commands = [flight.client.disarm()]
            return None
        if flight.given_up is not None:
            return Phase.FAILED, flight.given_up
        return Phase.DONE, self.success().reason

    def success(self) -> PilotVerdict:
        """Return the verdict on a landing on the chosen place.

        The error is by the estimate; the true one is judged elsewhere (`scenarios/trials`).
        """
        flight = self._flight
        rest_enu_m = flight.telemetry.position_enu_m
        error_m = math.dist(rest_enu_m[:2], flight.chosen.position_enu_m[:2])
        return PilotVerdict(success=True, reason="landed and disarmed", touchdown_error_m=error_m)
