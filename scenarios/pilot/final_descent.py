"""Last stretch of a landing: down onto the place, or onto the one to which wind carries it.

Below 0.7 m the camera no longer shows the place well and a gust can push the vehicle off it.
Waiting helps in calm air and exposes it to more gusts in wind. So the limits for sinking, and the
answer to a gust, differ between the two.
"""

from __future__ import annotations

import logging
import math

from autonomy.planning import PlanningError
from autonomy.types import Vector3
from flightsim.mavlink.client.telemetry import LANDED_ON_GROUND
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.phases import Phase, Step
from scenarios.pilot.tracking_statistics import TrackingStatistics

_LOG = logging.getLogger(__name__)

COMMIT_HEIGHTS_M = (0.7, 1.0)
"""Heights of the soles above the surface below which the landing is no longer aborted: the first
one if the path down to it can be certified, else the second."""
LAST_HEIGHT_M = 0.15
"""Height of the soles above the surface below which the vehicle sinks in any case."""
STEADY_M, STEADY_MPS = 0.15, 0.3
"""Distance from the vertical above the place, and level speed, beyond which it sinks no further."""
STEADY_IN_WIND_M, STEADY_IN_WIND_MPS = 0.3, 0.5
"""The same limits in wind: the longer it waits there, the more gusts find it in the air."""
CARRIED_OFF_M = 0.5
"""Distance from that vertical beyond which it climbs back: as far off as a landing may end."""
MOST_WIND_MPS = 12.0
"""Wind, as the autopilot reports it, beyond which the vehicle waits higher up. At 16 m/s legs that
slide as they meet the ground trip, and it tips over."""
MOST_TILT_RAD = math.radians(40.0)
"""Tilt beyond which it waits there as well. The tilt reveals a gust before the wind's estimate
does."""
LEAVE_M = 1.0
"""Height above a touched place up to which the map is not checked."""


def steady_within(tracking: TrackingStatistics) -> tuple[float, float]:
    """Return the distance and speed within which the vehicle sinks.

    A vehicle that hovers less well gets wider limits, up to those of wind. If it cannot keep even
    those, waiting longer would not help.
    """
    away_m, drift_mps = tracking.keeps
    return (
        min(max(STEADY_M, away_m), STEADY_IN_WIND_M),
        min(max(STEADY_MPS, drift_mps), STEADY_IN_WIND_MPS),
    )


class FinalDescent:
    """Flies the phase of the touchdown."""

    def __init__(self, flight: FlightState) -> None:
        self._flight = flight
        self._has_committed = False

    def touch_down(self) -> Step:
        """Sink through the last stretch."""
        flight = self._flight
        if flight.telemetry.landed_state == LANDED_ON_GROUND:
            return Phase.DISARM, "on the ground"
        if not self._is_committed():
            return self._keep_above()
        flight.let_land()
        return None

    def _is_committed(self) -> bool:
        """Return whether the vehicle is so low that it sinks in any case.

        The first time, it settles where it comes down.
        """
        flight = self._flight
        x, y, z = flight.setpoint.position_enu_m
        last_m = flight.resting_height_m + LAST_HEIGHT_M
        lowest_m = min(z, flight.telemetry.position_enu_m[2])
        if self._has_committed or lowest_m >= last_m:
            return self._has_committed
        self._has_committed = True
        if z >= last_m:
            # The air has pushed it down to the ground: rotors that turn would now drag a vehicle
            # that waits above over it.
            flight.course.sink_from(flight.time_us, (x, y, lowest_m), flight.resting_height_m)
        if flight.is_windy and flight.level_deviation_m > STEADY_M:
            self._settle_below(flight.level_deviation_m)
        return True

    def _keep_above(self) -> Step:
        """Sink only above the place: wait while a gust pushes, climb back if it is carried off."""
        flight = self._flight
        away_m = flight.level_deviation_m
        speed_mps = math.hypot(*flight.telemetry.velocity_enu_mps[:2])
        most_m, most_mps = steady_within(flight.tracking)
        if flight.is_windy:
            most_m, most_mps = STEADY_IN_WIND_M, STEADY_IN_WIND_MPS
            if away_m > (most_m if speed_mps <= most_mps else CARRIED_OFF_M):
                away_m = self._settle_below(away_m)
        if away_m > CARRIED_OFF_M:
            try:
                x, y, _ = flight.setpoint.position_enu_m
                up = flight.leg((x, y, flight.hover_enu_m[2]), exempt_m=LEAVE_M)
            except PlanningError as error:
                _LOG.info("%s", error)
            else:
                flight.begin_with(up)
                return Phase.CLIMB, f"carried {away_m:.2f} m off above the touchdown point"
        if flight.is_windy and self._is_blowing():
            flight.course.pause(flight.time_us, flight.resting_height_m + COMMIT_HEIGHTS_M[0])
        elif away_m > most_m or speed_mps > most_mps:
            flight.course.pause(flight.time_us)
        return None

    def _is_blowing(self) -> bool:
        """Return whether the wind is too strong now to meet the ground in."""
        telemetry = self._flight.telemetry
        # Third element of the rotation matrix's last column: the cosine of the tilt.
        _, x, y, _ = telemetry.quat_wxyz
        tilt_rad = math.acos(max(1.0 - 2.0 * (x * x + y * y), -1.0))
        return telemetry.wind_mps > MOST_WIND_MPS or tilt_rad > MOST_TILT_RAD

    def _settle_below(self, away_m: float) -> float:
        """Choose the place right below, if it is safe; return the distance from the chosen place.

        Wind does less on the ground than in the air, so down here is better than up and back again.
        """
        flight = self._flight
        x, y, _ = flight.telemetry.position_enu_m
        site = None if flight.watch is None else flight.watch.site_below((x, y, 0.0))
        if site is None:
            return away_m
        flight.site = site
        here: Vector3 = (x, y, flight.setpoint.position_enu_m[2])
        flight.course.sink_from(flight.time_us, here, flight.resting_height_m)
        return 0.0

    def leave(self, reason: str) -> Step:
        """Climb from a place that does not allow a landing, or hand over to the autopilot."""
        flight = self._flight
        self._has_committed = False
        here, now = flight.telemetry.position_enu_m, flight.setpoint
        x, y, _ = here
        world = flight.mission.surroundings
        try:
            up = world.certified_leg(
                here, (x, y, flight.hover_enu_m[2]), now.yaw_rad, exempt_m=LEAVE_M
            )
        except PlanningError as error:
            flight.given_up = reason
            return Phase.HAND_OVER, f"{reason}; no certified way up: {error}"
        flight.begin_with(up)
        return Phase.CLIMB, reason
