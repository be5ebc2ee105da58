"""Return mode: climb, fly to home or the nearest rally point within the fence, descend, land."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import hypot, radians, tan

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.behaviours.land import Land
from flightsim.autopilot.events import Severity
from flightsim.autopilot.fence import Point2
from flightsim.autopilot.fence_route import fence_routes
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_places import fence_breach
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S

_FENCE_MARGIN_M = 1.0  # the return stays this far below a fence's ceiling


class ReturnHome:
    """Fly the legs of a return, one after the other.

    The vehicle climbs, follows a route that the geofence allows, waits above the place for
    RTL_LAND_DELAY, and lands there: at home, or at a rally point that is nearer.
    """

    def __init__(self, flight: FlightContext) -> None:
        self._flight = flight
        self._land: Land | None = None
        self._legs: list[tuple[Vector3, Callable[[], None]]] = []
        self._waited_s = 0.0
        self._place: tuple[float, float] = (0.0, 0.0)
        self.next_mode: Mode | None = None

    @property
    def is_landing(self) -> bool:
        """True if the return is in its last, vertical part."""
        return self._land is not None and self._land.is_landing

    @property
    def may_rest(self) -> bool:
        """True while it lands, so that the rotors may idle at contact."""
        return self.is_landing

    def ready_to_lift(self) -> bool:
        """Never take off."""
        return False

    def start(self) -> None:
        """Plan the legs from here: climb, route, descent above the place.

        The vehicle lands where it can stop if there is no home, or if the fence allows no way to
        any place.
        """
        flight = self._flight
        self._land = None
        self._waited_s = 0.0
        x, y, z = flight.path.stopping_point(flight.limits.automatic)
        # Without a home there is nothing to return to: land where the vehicle can stop.
        if flight.home is None:
            self._begin_landing((x, y))
            return
        ground_m = flight.home.position_enu_m[2]
        route = self._route((x, y))
        if not route:
            flight.events.report(
                Severity.CRITICAL, "RTL: no place within the geofence, landing here"
            )
            self._begin_landing((x, y))
            return
        self._place = east_m, north_m = route[-1]
        height_m = return_height(flight, hypot(east_m - x, north_m - y), z)
        descend_m = min(height_m, ground_m + flight.parameters["RTL_DESCEND_ALT"])
        heading = flight.heading
        heading.goal_yaw_rad = heading.yaw_rad
        yaw_rad = flight.home.yaw_rad
        corners = [(east_m, north_m, height_m) for east_m, north_m in route]
        self._legs = [
            # No turn during the climb, towards the place on the route, then as home was left.
            ((x, y, height_m), lambda: None),
            *((corner, partial(flight.face, corner)) for corner in corners),
            ((east_m, north_m, descend_m), lambda: setattr(heading, "goal_yaw_rad", yaw_rad)),
        ]
        flight.events.report(
            Severity.INFO,
            f"RTL: climb to {height_m + flight.frame.origin.altitude_m:.0f} m "
            f"({height_m - ground_m:.0f} m above destination)",
        )

    def update(self) -> Setpoint:
        """Fly the present leg; at the end of the last one wait, then land."""
        flight = self._flight
        if self._land is not None:
            return self._land.update()
        goal, turn = self._legs[0]
        flight.target_enu_m = goal
        flight.path.fly_to(goal, flight.limits.automatic)
        turn()
        if flight.path.is_at_rest:
            self._finish_leg()
        return flight.follow_path()

    def _finish_leg(self) -> None:
        if len(self._legs) > 1:
            self._legs.pop(0)
            return
        delay_s = self._flight.parameters["RTL_LAND_DELAY"]
        self._waited_s += TICK_S
        # A negative RTL_LAND_DELAY loiters above the place for ever.
        if 0.0 <= delay_s <= self._waited_s:
            self._begin_landing(self._place)

    def _begin_landing(self, place_enu_m: tuple[float, float]) -> None:
        self._flight.events.report(Severity.INFO, "RTL: landing")
        self._land = Land(self._flight, place_enu_m, self._flight.heading.goal_yaw_rad)
        self._land.start()

    def _route(self, here_enu_m: Point2) -> list[Point2]:
        """Return the points to fly over up to the place to land: home or a nearer rally point.

        Neither place nor route is outside a geofence that counts. The route is empty if the fence
        allows the vehicle's own place and no other.
        """
        flight = self._flight
        assert flight.home is not None
        x, y = here_enu_m
        home = flight.home.position_enu_m
        places = [(home[0], home[1]), *flight.rally.points_enu_m]
        nearest = min(places, key=lambda place: hypot(place[0] - x, place[1] - y))
        routes = fence_routes(flight)
        if routes is None:
            return [nearest]
        found = [routes.length_and_route(here_enu_m, place) for place in places]
        reachable = [each for each in found if each is not None]
        if reachable:
            return min(reachable, key=lambda each: each[0])[1]
        # A vehicle outside that finds no route flies straight home, across the fence if it must.
        is_inside = fence_breach(flight, flight.vehicle.position_enu_m) is None
        return [] if is_inside else [(home[0], home[1])]


def return_height(flight: FlightContext, distance_m: float, height_enu_m: float) -> float:
    """ENU height for a return from a distance, m; never below the present height.

    Near home (RTL_MIN_DIST) there is no climb; inside the cone RTL_CONE_ANG the climb is
    proportional to the distance; it stays below a fence's ceiling.

    Args:
        flight: Shared state with home and parameters.
        distance_m: Horizontal distance of the place to land.
        height_enu_m: Present height.
    """
    assert flight.home is not None
    p = flight.parameters
    if distance_m < p["RTL_MIN_DIST"]:
        return height_enu_m
    climb_m = p["RTL_RETURN_ALT"]
    if p["GF_MAX_VER_DIST"] > 0.0:
        climb_m = min(climb_m, max(p["GF_MAX_VER_DIST"] - _FENCE_MARGIN_M, 0.0))
    if p["RTL_CONE_ANG"] > 0:
        cone_m = distance_m / tan(radians(min(p["RTL_CONE_ANG"], 89.9)))
        climb_m = min(climb_m, max(cone_m, min(climb_m, p["RTL_DESCEND_ALT"])))
    return max(height_enu_m, flight.home.position_enu_m[2] + climb_m)
