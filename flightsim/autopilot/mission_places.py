"""Positions of mission items in local metres, and their breaches of the geofence."""

from __future__ import annotations

from math import isnan, radians

from autonomy.types import Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_item import (
    FRAME_GLOBAL,
    FRAME_LOCAL_NED,
    FRAME_TERRAIN,
    PAYLOAD_COMMANDS,
    PLACE_COMMANDS,
    Cmd,
    MissionItem,
)
from flightsim.frames import Geodetic, swap_enu_ned, swap_yaw_enu_ned

# Items that take no time: the vehicle need not stop for them.
_PASSED_OVER = PAYLOAD_COMMANDS | {
    *(Cmd.CHANGE_SPEED, Cmd.LAND_START, Cmd.SET_HOME, Cmd.FENCE_ENABLE)
}


def place_of(item: MissionItem, flight: FlightContext) -> Vector3:
    """Return the ENU position of an item that flies somewhere, m.

    Args:
        item: An item of `PLACE_COMMANDS`, or one that sets home.
        flight: Shared state. Missing horizontal coordinates are the path's, a missing height is
            home's.
    """
    here = flight.path.position_enu_m
    home_m, above_m = flight.home_m, flight.home_m
    if item.is_geodetic:
        origin_m = flight.frame.origin.altitude_m
        # Converted at the origin's altitude: east and north then do not depend on the item's
        # height.
        east_m, north_m, _ = flight.frame.enu_from_geodetic(Geodetic(item.x, item.y, origin_m))
        if item.frame in FRAME_TERRAIN:
            x, y = (here[0], here[1]) if item.is_here else (east_m, north_m)
            above_m = flight.terrain_m(x, y)
        up_m = item.z - origin_m if item.frame in FRAME_GLOBAL else above_m + item.z
    elif item.frame == FRAME_LOCAL_NED:
        east_m, north_m, up_m = swap_enu_ned((item.x, item.y, item.z))
    else:
        east_m, north_m, up_m = item.x, item.y, item.z
    if item.is_here:
        east_m, north_m = here[0], here[1]
    return (east_m, north_m, home_m if isnan(up_m) else up_m)


def yaw_of(compass_deg: float) -> float | None:
    """Return the ENU yaw of a compass heading, rad; None if it is NaN."""
    return None if isnan(compass_deg) else swap_yaw_enu_ned(radians(compass_deg))


def place_after(index: int, flight: FlightContext, height_enu_m: float) -> Vector3 | None:
    """Return the next position after an item; None if the mission must stop there first.

    Args:
        index: Index of the item.
        flight: Shared state with the mission.
        height_enu_m: Height at which a landing is approached.
    """
    for item in flight.mission.items[index + 1 :]:
        if item.command in _PASSED_OVER:
            continue
        # A takeoff, a circle and every item that takes time begin from rest.
        is_flown_to = item.command in PLACE_COMMANDS and item.command != Cmd.TAKEOFF
        if not is_flown_to or item.is_here or item.command == Cmd.LOITER_TURNS:
            return None
        east_m, north_m, up_m = place_of(item, flight)
        if item.command == Cmd.LAND:
            up_m = height_enu_m
        return (east_m, north_m, up_m)
    return None


def fence_breach(flight: FlightContext, position_enu_m: Vector3) -> str | None:
    """Return the description of a position outside the geofence; None if it is inside, or off.

    Args:
        flight: Shared state with fence, home and parameters.
        position_enu_m: The position.
    """
    if not flight.fence.is_enabled:
        return None
    p = flight.parameters
    farthest_m, highest_m = p["GF_MAX_HOR_DIST"], p["GF_MAX_VER_DIST"]
    home = flight.home
    if home is not None and (farthest_m > 0.0 or highest_m > 0.0):
        x, y, z = position_enu_m
        hx, hy, hz = home.position_enu_m
        # Squares are compared: this runs in every failsafe check.
        if farthest_m > 0.0 and (x - hx) ** 2 + (y - hy) ** 2 > farthest_m * farthest_m:
            return f"more than {farthest_m:g} m from home"
        if highest_m > 0.0 and z - hz > highest_m:
            return f"more than {highest_m:g} m above home"
    if not flight.fence.allows(position_enu_m):
        return "outside the uploaded fence"
    return None


def leg_breach(flight: FlightContext, start_enu_m: Vector3, goal_enu_m: Vector3) -> str | None:
    """Return the description of a straight leg that leaves the geofence on its way, or None.

    The limits of the parameters are convex: with both ends within, so is the leg. A leg that begins
    outside leads back in, and is no breach.
    """
    is_free = (
        not flight.fence.is_enabled or flight.fence.allows_lines([(start_enu_m, goal_enu_m)])[0]
    )
    if is_free or fence_breach(flight, start_enu_m) is not None:
        return None
    return "the way there leaves the uploaded fence"
