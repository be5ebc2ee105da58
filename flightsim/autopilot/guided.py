"""Guided requests: takeoff, landing, reposition, orbit, heading, speed and home.

Clients give places in degrees and altitudes above the sea. This module converts them to the local
frame, checks range and geofence, and hands a behaviour to the commander. A refusal comes before
anything changes.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, isfinite, isnan, pi, sin

from autonomy.types import Vector3
from flightsim.autopilot.behaviours.hold import Hold
from flightsim.autopilot.behaviours.land import Land
from flightsim.autopilot.behaviours.offboard import Offboard
from flightsim.autopilot.behaviours.orbit import Orbit
from flightsim.autopilot.behaviours.precision_land import Precision, PrecisionLand
from flightsim.autopilot.behaviours.takeoff import Takeoff
from flightsim.autopilot.commander import Commander
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.flight_limits import SpeedRequests
from flightsim.autopilot.mission_places import fence_breach, leg_breach
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.results import ACCEPTED, Reply, denied, rejected
from flightsim.frames import Geodetic

_FARTHEST_M = 1e5  # beyond 100 km from the origin a place is a client's mistake
_LEAST_CLIMB_M = 0.3  # a takeoff to less above the ground is one by MIS_TAKEOFF_ALT
_ORBIT_POINTS = 36
"""Number of points of an orbit that are checked against the geofence, with the lines between them.
"""


class GuidedRequests:
    """Requests with places, converted into behaviours; requests that make no sense are refused."""

    def __init__(self, flight: FlightContext, commander: Commander) -> None:
        self._flight = flight
        self._commander = commander

    def takeoff(
        self,
        altitude_amsl_m: float | None = None,
        *,
        yaw_rad: float | None = None,
        latitude_deg: float | None = None,
        longitude_deg: float | None = None,
    ) -> Reply:
        """Climb, once armed, then fly to a place if one is given.

        Args:
            altitude_amsl_m: Altitude above mean sea level; None climbs by MIS_TAKEOFF_ALT, and so
                does an altitude below the vehicle.
            yaw_rad: ENU heading; None keeps the present one.
            latitude_deg: Latitude of the place; None stays above the start.
            longitude_deg: Longitude of the place; None stays above the start.

        Returns:
            The reply; denied if height or place are out of range or beyond the geofence.
        """
        height_m = None
        if altitude_amsl_m is not None:
            height_m = altitude_amsl_m - self._flight.frame.origin.altitude_m
            # Written so that NaN is out of range too.
            if not abs(height_m) <= _FARTHEST_M:
                return denied(f"takeoff altitude {altitude_amsl_m} m is out of range")
            lowest_m = self._flight.vehicle.position_enu_m[2] + _LEAST_CLIMB_M
            if self._flight.vehicle.is_landed and height_m < lowest_m:
                height_m = None
        place = self._place(latitude_deg, longitude_deg)
        if place is not None and not hypot(*place) <= _FARTHEST_M:
            return denied("takeoff place is out of range")
        if place is not None and (refusal := self._beyond_fence("Takeoff", place)):
            return refusal
        behaviour = Takeoff(self._flight, height_m, yaw_rad, place)
        return self._commander.request(Mode.TAKEOFF, behaviour)

    def land(
        self,
        *,
        latitude_deg: float | None = None,
        longitude_deg: float | None = None,
        yaw_rad: float | None = None,
        precision: Precision = Precision.NONE,
    ) -> Reply:
        """Land at a place, or at the present position; with `precision` on the landing target.

        Args:
            latitude_deg: Latitude of the place; None lands here.
            longitude_deg: Longitude of the place; None lands here.
            yaw_rad: ENU heading; None keeps the present one.
            precision: How much the landing depends on the landing target.

        Returns:
            The reply; denied if the place is out of range or beyond the geofence.
        """
        place = self._place(latitude_deg, longitude_deg)
        if place is not None and not hypot(*place) <= _FARTHEST_M:
            return denied("landing place is out of range")
        if place is not None and (refusal := self._beyond_fence("Landing", place)):
            return refusal
        if precision is not Precision.NONE:
            is_required = precision is Precision.REQUIRED
            landing = PrecisionLand(self._flight, place, is_required=is_required)
            return self._commander.request(Mode.PRECISION_LAND, landing)
        return self._commander.request(Mode.LAND, Land(self._flight, place, yaw_rad))

    def goto(
        self, place: Geodetic, *, yaw_rad: float | None = None, speed_mps: float | None = None
    ) -> Reply:
        """Fly to a place and hold there.

        Args:
            place: The place; NaN keeps that coordinate.
            yaw_rad: ENU heading; None faces the place.
            speed_mps: Speed of this and later automatic flight; None or 0 keep the present one.

        Returns:
            The reply; rejected while disarmed, denied if the place is out of range or beyond the
            geofence.
        """
        flight = self._flight
        if not self._commander.is_armed:
            return rejected("reposition denied: not armed")
        target = flight.frame.enu_from_geodetic(place)
        filled = self._filled(target)
        if not _is_near(filled):
            return denied("reposition denied: place is out of range")
        if refusal := self._beyond_fence("Reposition", filled[:2], filled[2]):
            return refusal
        reply = self._commander.request(Mode.HOLD, Hold(flight, target, yaw_rad))
        if reply.is_accepted and speed_mps is not None and speed_mps > 0.0:
            flight.limits.speeds = replace(flight.limits.speeds, cruise_mps=speed_mps)
        return reply

    def orbit(self, centre: Geodetic, *, radius_m: float, speed_mps: float) -> Reply:
        """Circle a centre.

        Args:
            centre: The centre; NaN means the vehicle's coordinate.
            radius_m: Radius, 1 to 1000; negative circles counter-clockwise.
            speed_mps: Speed, up to 100; negative reverses the direction.

        Returns:
            The reply; rejected while disarmed, denied if a value is out of range or the circle
            leaves the geofence.
        """
        flight = self._flight
        if not self._commander.is_armed:
            return rejected("orbit denied: not armed")
        if not (1.0 <= abs(radius_m) <= 1000.0 and 0.0 < abs(speed_mps) <= 100.0):
            return denied(f"orbit of {radius_m} m at {speed_mps} m/s; radius is 1 to 1000 m")
        filled = self._filled(flight.frame.enu_from_geodetic(centre))
        if not _is_near(filled):
            return denied("orbit denied: centre is out of range")
        x, y, z = filled
        # Points and the chords between them: a fence may cut the circle between two points.
        before: Vector3 | None = None
        for turn_rad in (i * pi / _ORBIT_POINTS * 2 for i in range(_ORBIT_POINTS + 1)):
            point = (x + abs(radius_m) * cos(turn_rad), y + abs(radius_m) * sin(turn_rad))
            if refusal := self._beyond_fence("Orbit", point, z, before or (*point, z)):
                return refusal
            before = (*point, z)
        is_clockwise = (radius_m > 0.0) == (speed_mps > 0.0)
        orbit = Orbit(flight, filled, abs(radius_m), abs(speed_mps), is_clockwise=is_clockwise)
        return self._commander.request(Mode.ORBIT, orbit)

    def circle_ahead(self, turn_rate_radps: float) -> Reply:
        """Circle the point that lies NAV_LOITER_RAD ahead of the nose, at a turn rate.

        A positive rate circles clockwise. A vehicle on the ground does not take off for it.
        """
        vehicle, radius_m = self._flight.vehicle, self._flight.parameters["NAV_LOITER_RAD"]
        if vehicle.is_landed:
            return rejected("circle denied: not flying")
        x, y, z = vehicle.position_enu_m
        yaw_rad = vehicle.yaw_rad
        centre = (x + radius_m * cos(yaw_rad), y + radius_m * sin(yaw_rad), z)
        place = self._flight.frame.geodetic_from_enu(centre)
        return self.orbit(place, radius_m=radius_m, speed_mps=radius_m * turn_rate_radps)

    def set_yaw(self, yaw_rad: float, *, rate_radps: float | None = None) -> Reply:
        """Turn to a heading while holding, or while setpoints leave the heading free.

        Args:
            yaw_rad: ENU heading.
            rate_radps: Greatest rate of the turn; None uses the parameter.
        """
        behaviour = self._commander.behaviour
        is_able = self._commander.is_armed and isfinite(yaw_rad)
        if not isinstance(behaviour, (Hold, Offboard)) or not is_able:
            return rejected("a heading can only be set while holding or offboard")
        behaviour.start_turn()
        self._flight.heading.ask(yaw_rad, rate_radps)
        return ACCEPTED

    def set_speed(self, speed_mps: float | None) -> Reply:
        """Set the speed of automatic flight, above 0 to 100 m/s; None restores MPC_XY_CRUISE."""
        if speed_mps is not None and not 0.0 < speed_mps <= 100.0:
            return denied(f"speed {speed_mps} m/s is out of range; valid are 0 to 100")
        self._flight.limits.speeds = SpeedRequests(cruise_mps=speed_mps)
        return ACCEPTED

    def set_home(self, place: Geodetic | None) -> Reply:
        """Set home to a place, or to the present position if it is None."""
        if place is None and not self._flight.vehicle.is_position_ok:
            return rejected("no valid position estimate")
        position = None if place is None else self._flight.frame.enu_from_geodetic(place)
        if position is not None and not _is_near(position):
            return denied("home is out of range")
        self._flight.move_home(position)
        return ACCEPTED

    def restart(self) -> Reply:
        """Begin again as after a reboot: parameters, mission, fence and rally points stay."""
        flight = self._flight
        if self._commander.is_armed:
            return rejected("the vehicle is armed")
        flight.home = None
        flight.mission.rewind()
        self._commander.request(Mode.HOLD)
        flight.events.report(Severity.INFO, "Restarted")
        return ACCEPTED

    def _beyond_fence(
        self,
        request: str,
        place_enu_m: tuple[float, float],
        height_enu_m: float | None = None,
        start_enu_m: Vector3 | None = None,
    ) -> Reply | None:
        """Return the refusal of a place, or of the line there, that the geofence does not allow.

        Args:
            request: Name of the request in the text.
            place_enu_m: East and north of the place.
            height_enu_m: Its height; None is the vehicle's.
            start_enu_m: Start of the line; None is the vehicle.

        Returns:
            None if the geofence allows both, or if GF_ACTION only warns.
        """
        flight = self._flight
        here = flight.vehicle.position_enu_m
        place = (*place_enu_m, here[2] if height_enu_m is None else height_enu_m)
        breach = fence_breach(flight, place)
        breach = breach or leg_breach(flight, start_enu_m or here, place)
        if breach is None or flight.parameters["GF_ACTION"] <= 1:
            return None
        flight.events.report(Severity.CRITICAL, f"{request} denied: {breach}")
        return denied(f"{request.lower()} denied: {breach}")

    def _filled(self, position_enu_m: Vector3) -> Vector3:
        """Return a position with NaN replaced by the vehicle's own coordinates."""
        x, y, z = position_enu_m
        here = self._flight.vehicle.position_enu_m
        return (here[0] if isnan(x) else x, here[1] if isnan(y) else y, here[2] if isnan(z) else z)

    def _place(
        self, latitude_deg: float | None, longitude_deg: float | None
    ) -> tuple[float, float] | None:
        if latitude_deg is None or longitude_deg is None:
            return None
        x, y, _ = self._flight.frame.enu_from_geodetic(Geodetic(latitude_deg, longitude_deg, 0.0))
        return (x, y)


def _is_near(position_enu_m: Vector3) -> bool:
    return all(abs(c) <= _FARTHEST_M for c in position_enu_m)
