"""Reasons that forbid a mission from here: no items, a first one too far away, or the geofence.

Every item is checked, and every straight leg between two of them. The first leg to be flown begins
at the vehicle. A mission that breaches the fence is refused as a whole, because its legs are the
client's to choose: flying around a corner of the fence would be another mission.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, hypot, isnan, pi, sin

from autonomy.types import Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_item import PLACE_COMMANDS, Cmd, MissionItem
from flightsim.autopilot.mission_places import fence_breach, place_of

_CIRCLE_POINTS = 16  # points of a circle that are checked against the geofence


@dataclass(frozen=True, kw_only=True, slots=True)
class _Leg:
    """Straight flight to the place of an item, while the mission has the fence on.

    Attributes:
        index: Index of the item.
        start_enu_m: Start of the leg.
        goal_enu_m: Place of the item.
    """

    index: int
    start_enu_m: Vector3
    goal_enu_m: Vector3
    radius_m: float = 0.0
    """Radius of a circle that is flown there."""


def mission_obstacle(flight: FlightContext) -> str | None:
    """Return the reason why the mission cannot be flown from here, or None if it can."""
    if not flight.mission.items:
        return "no valid mission uploaded"
    p = flight.parameters
    home = flight.vehicle.position_enu_m if flight.home is None else flight.home.position_enu_m
    for item in flight.mission.items:
        if item.command not in PLACE_COMMANDS or item.is_here:
            continue
        place = place_of(item, flight)
        distance_m = hypot(place[0] - home[0], place[1] - home[1])
        # A negative MIS_DIST_1WP switches the check off.
        if 0.0 <= p["MIS_DIST_1WP"] < distance_m:
            return f"first waypoint too far away: {distance_m:.0f} m"
        # Only the first item with a place counts: the vehicle sets out for it.
        break
    return _breach(flight) if p["GF_ACTION"] > 0 and flight.fence.is_enabled else None


def _breach(flight: FlightContext) -> str | None:
    """Return the first breach: an item outside the geofence, or a leg that leaves it."""
    legs = list(_legs(flight))
    for leg in legs:
        for place in _places(leg):
            if reason := fence_breach(flight, place):
                return f"item {leg.index} is outside the geofence ({reason})"
    # All lines in one call: shapely is much faster on arrays than line by line.
    free = flight.fence.allows_lines([(leg.start_enu_m, leg.goal_enu_m) for leg in legs])
    for leg, is_free in zip(legs, free, strict=True):
        # A vehicle outside flies back in.
        if not is_free and fence_breach(flight, leg.start_enu_m) is None:
            return f"the way to item {leg.index} leaves the geofence"
    return None


def _places(leg: _Leg) -> Iterator[Vector3]:
    """Yield the goal, and points of the circle around it."""
    yield leg.goal_enu_m
    x, y, z = leg.goal_enu_m
    for k in range(_CIRCLE_POINTS if leg.radius_m > 0.0 else 0):
        angle_rad = 2.0 * pi * k / _CIRCLE_POINTS
        yield (x + leg.radius_m * cos(angle_rad), y + leg.radius_m * sin(angle_rad), z)


def _legs(flight: FlightContext) -> Iterator[_Leg]:
    """Yield the legs of the mission in its order, and those of its jumps."""
    mission, is_fenced = flight.mission, True
    before: Vector3 | None = None
    for index, item in enumerate(mission.items):
        # The mission continues here, from wherever the vehicle is.
        if index == mission.current_index:
            before = flight.vehicle.position_enu_m
        if item.command == Cmd.FENCE_ENABLE:
            is_fenced = item.param1 == 1.0
        elif item.command == Cmd.RETURN:
            before = None  # a return flies a route of its own, within the fence
        elif item.command == Cmd.JUMP:
            goal = _first_place(flight, int(item.param1))
            # The leg of a jump leads from before it to where the mission goes on.
            if is_fenced and before is not None and goal is not None:
                yield _Leg(index=index, start_enu_m=before, goal_enu_m=goal)
        elif item.command in PLACE_COMMANDS and not item.is_here:
            place = place_of(item, flight)
            # A takeoff rises where the vehicle is.
            is_level = before is not None and item.command != Cmd.TAKEOFF
            start = before if before is not None and is_level else place
            if is_fenced:
                radius_m = _radius_m(item, flight)
                yield _Leg(index=index, start_enu_m=start, goal_enu_m=place, radius_m=radius_m)
            before = place if is_level or before is None else before


def _first_place(flight: FlightContext, index: int) -> Vector3 | None:
    """Return the place of the first item from an index on that flies to one, or None."""
    for item in flight.mission.items[index:]:
        if item.command in PLACE_COMMANDS and item.command != Cmd.TAKEOFF:
            return None if item.is_here else place_of(item, flight)
    return None


def _radius_m(item: MissionItem, flight: FlightContext) -> float:
    """Radius of the circle that an item flies, m; 0 for none."""
    if item.command != Cmd.LOITER_TURNS:
        return 0.0
    radius_m = 0.0 if isnan(item.param3) else abs(item.param3)
    return radius_m or flight.parameters["NAV_LOITER_RAD"]
