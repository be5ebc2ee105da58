"""Follow mode: keep a distance, a height and an angle to a target that reports its position.

The angle counts from the target's course, as in PX4: 180 degrees are behind it. While the target
has not moved yet, the vehicle stays on the side where it is.
"""

from __future__ import annotations

from math import atan2, cos, hypot, radians, sin

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.heading import wrap_angle
from flightsim.autopilot.mission_places import fence_breach, leg_breach
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S

_LEAST_SPEED_MPS = 0.5
"""Speed of the target above which its velocity shows its course."""
_SMOOTHING_S = 10.0
"""Time constant of the target's smoothing at a responsiveness of 1."""
_ABOVE_TERRAIN, _ABOVE_TARGET = 1, 2
"""Values of FLW_TGT_ALT_M; the height counts from home otherwise."""


class Follow:
    """Fly where the target's reports and the FLW_TGT parameters lead; hold while none come.

    The vehicle waits within the geofence if the place or the straight way to it is outside.
    """

    is_landing = False
    may_rest = False

    def __init__(self, flight: FlightContext) -> None:
        self._flight = flight
        self._goal_enu_m: Vector3 | None = None
        self._target_enu_m: Vector3 | None = None
        self._bearing_rad: float | None = None
        self._course_rad: float | None = None
        self._is_waiting = False
        self.next_mode: Mode | None = None

    def ready_to_lift(self) -> bool:
        """Stay on the ground: a flight begins with a takeoff."""
        return False

    def start(self) -> None:
        """Hold where the vehicle can stop, until the target is known."""
        flight = self._flight
        self._goal_enu_m = flight.path.stopping_point(flight.limits.automatic)
        self._target_enu_m = self._bearing_rad = self._course_rad = None
        flight.heading.goal_yaw_rad = flight.heading.yaw_rad

    def update(self) -> Setpoint:
        """Fly on towards the place from which the target is followed.

        Reports are smoothed by FLW_TGT_RS; without a report the last place stays the goal.
        """
        flight = self._flight
        reported = flight.follow_target.at(flight.vehicle.time_us)
        if reported is not None:
            self._smooth(reported)
            place = self._place()
            if self._is_allowed(place):
                self._goal_enu_m = place
        assert self._goal_enu_m is not None
        flight.target_enu_m = self._goal_enu_m
        flight.path.fly_to(self._goal_enu_m, flight.limits.automatic)
        return flight.follow_path()

    def _is_allowed(self, place_enu_m: Vector3) -> bool:
        """Return true if the geofence allows straight flight to a place.

        The fence counts unless GF_ACTION ignores it. If the vehicle is outside already, that
        parameter decides what happens.
        """
        flight = self._flight
        here = flight.path.position_enu_m
        if flight.parameters["GF_ACTION"] == 0 or fence_breach(flight, here) is not None:
            return True
        breach = fence_breach(flight, place_enu_m) or leg_breach(flight, here, place_enu_m)
        # Announced once, when the waiting begins.
        if breach is not None and not self._is_waiting:
            flight.events.report(
                Severity.WARNING, f"Follow: waiting within the geofence ({breach})"
            )
        self._is_waiting = breach is not None
        return breach is None

    def _smooth(self, reported_enu_m: Vector3) -> None:
        """Move the target's estimate towards the reported position."""
        if self._target_enu_m is None:
            self._target_enu_m = reported_enu_m
            return
        constant_s = _SMOOTHING_S * self._flight.parameters["FLW_TGT_RS"]
        share = TICK_S / (constant_s + TICK_S)
        x, y, z = (
            old + share * (new - old)
            for old, new in zip(self._target_enu_m, reported_enu_m, strict=True)
        )
        self._target_enu_m = (x, y, z)

    def _place(self) -> Vector3:
        """Return the place beside the target, on the side that the angle asks for."""
        flight, p = self._flight, self._flight.parameters
        assert self._target_enu_m is not None
        tx, ty, tz = self._target_enu_m
        x, y, _ = flight.path.position_enu_m
        if self._bearing_rad is None:
            self._bearing_rad = atan2(y - ty, x - tx)
        vx, vy, _ = flight.follow_target.velocity_enu_mps
        if hypot(vx, vy) > _LEAST_SPEED_MPS:
            self._course_rad = atan2(vy, vx)
        distance_m = p["FLW_TGT_DST"]
        if self._course_rad is not None:
            # The angle counts clockwise from above, as headings do.
            # The vehicle flies around the target at FLW_TGT_MAX_VEL at most, instead of cutting
            # across it.
            wanted_rad = self._course_rad - radians(p["FLW_TGT_FA"])
            most_rad = p["FLW_TGT_MAX_VEL"] * TICK_S / distance_m
            off_rad = wrap_angle(wanted_rad - self._bearing_rad)
            self._bearing_rad += min(max(off_rad, -most_rad), most_rad)
        # Right above the target the direction to it is noise.
        if hypot(tx - x, ty - y) > 0.5:
            flight.heading.goal_yaw_rad = atan2(ty - y, tx - x)
        return (
            tx + distance_m * cos(self._bearing_rad),
            ty + distance_m * sin(self._bearing_rad),
            self._floor_m(tz) + p["FLW_TGT_HT"],
        )

    def _floor_m(self, target_up_m: float) -> float:
        """ENU height above which FLW_TGT_HT counts, m."""
        flight = self._flight
        if flight.parameters["FLW_TGT_ALT_M"] == _ABOVE_TARGET:
            return target_up_m
        if flight.parameters["FLW_TGT_ALT_M"] == _ABOVE_TERRAIN:
            east_m, north_m, _ = flight.vehicle.position_enu_m
            return flight.terrain_m(east_m, north_m)
        return flight.home_m
