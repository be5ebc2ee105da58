"""Legs of a mission: how each kind of item is flown and when it is complete."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, inf, isnan, radians

from autonomy.types import Vector3
from flightsim.autopilot.behaviours import Behaviour
from flightsim.autopilot.behaviours.hold import Hold
from flightsim.autopilot.behaviours.land import Land
from flightsim.autopilot.behaviours.orbit import Orbit
from flightsim.autopilot.behaviours.precision_land import Precision, PrecisionLand
from flightsim.autopilot.behaviours.takeoff import Takeoff
from flightsim.autopilot.behaviours.waypoint import WaypointLeg
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.heading import wrap_angle
from flightsim.autopilot.mission_item import PLACE_COMMANDS, Cmd, MissionItem
from flightsim.autopilot.mission_places import place_after, place_of, yaw_of

WAITS = frozenset({Cmd.DELAY, Cmd.CONDITION_DELAY})
"""Items that only wait, in the air or on the ground."""
LEG_COMMANDS = PLACE_COMMANDS | WAITS | {Cmd.CONDITION_YAW}
"""Items that take time; all others are executed at once."""

_LEAST_TURN_RADIUS_M = 1.0


@dataclass(frozen=True, slots=True)
class MissionLeg:
    """A behaviour that flies an item, and the test that it is complete."""

    behaviour: Behaviour
    is_done: Callable[[], bool]
    passed_enu_m: Vector3 | None = None
    """Waypoint that the leg passes without a stop; the next line starts there."""


def seconds(value: float) -> float:
    """Duration of an item in seconds; NaN and negative values are 0."""
    return 0.0 if isnan(value) else max(value, 0.0)


def loiter_leg(flight: FlightContext) -> MissionLeg:
    """Leg that stays here when the mission is complete."""
    return MissionLeg(Hold(flight), _never)


def climb_leg(flight: FlightContext, item: MissionItem) -> MissionLeg:
    """Leg that climbs from the ground to an item's height, for missions without a takeoff.

    Args:
        flight: Shared state.
        item: The item that is flown afterwards. The climb is by MIS_TAKEOFF_ALT at least.
    """
    least_m = flight.path.position_enu_m[2] + flight.parameters["MIS_TAKEOFF_ALT"]
    return _takeoff_leg(Takeoff(flight, max(least_m, place_of(item, flight)[2])))


def leg_of(
    index: int,
    item: MissionItem,
    flight: FlightContext,
    *,
    line_start_enu_m: Vector3 | None,
    may_pass: bool,
) -> MissionLeg:
    """Return the leg that flies an item.

    Args:
        index: Index of the item in the mission.
        item: An item of `LEG_COMMANDS`.
        flight: Shared state.
        line_start_enu_m: Previous waypoint, if it was passed without a stop.
        may_pass: True if the mission continues after this item, so that it need not stop.
    """
    yaw_rad = yaw_of(item.param4) if item.command in PLACE_COMMANDS else None
    match item.command:
        case Cmd.TAKEOFF:
            return _takeoff_leg(Takeoff(flight, place_of(item, flight)[2], yaw_rad))
        case Cmd.LAND:
            x, y, _ = place_of(item, flight)
            place = None if item.is_here else (x, y)
            if item.param2 in {Precision.OPPORTUNISTIC, Precision.REQUIRED}:
                is_required = item.param2 == Precision.REQUIRED
                # A landing never completes in the air: on the ground `ready_to_lift` completes it.
                return MissionLeg(PrecisionLand(flight, place, is_required=is_required), _never)
            return MissionLeg(Land(flight, place, yaw_rad), _never)
        case Cmd.LOITER_TURNS:
            return _circle_leg(item, flight)
        case Cmd.DELAY | Cmd.CONDITION_DELAY | Cmd.CONDITION_YAW:
            return _pause_leg(item, flight)
    radius_m, hold_s, next_goal = flight.parameters["NAV_ACC_RAD"], 0.0, None
    goal = place_of(item, flight)
    match item.command:
        case Cmd.WAYPOINT:
            hold_s = seconds(item.param1)
            radius_m = item.param2 if item.param2 > 0.0 else radius_m
            # Without a hold time the vehicle rounds the corner towards the next place.
            if hold_s == 0.0 and may_pass:
                next_goal = place_after(index, flight, goal[2])
        case Cmd.LOITER_TIME:
            hold_s = seconds(item.param1)
        case Cmd.LOITER_UNLIMITED:
            hold_s = inf
    leg = WaypointLeg(
        flight,
        goal,
        radius_m=radius_m,
        hold_s=hold_s,
        yaw_rad=yaw_rad,
        line_start_enu_m=line_start_enu_m,
        next_goal_enu_m=next_goal,
    )
    # Only a waypoint that is passed leaves its line's end to the next leg.
    return MissionLeg(leg, lambda: leg.is_done, None if next_goal is None else goal)


def _never() -> bool:
    return False


def _takeoff_leg(takeoff: Takeoff) -> MissionLeg:
    return MissionLeg(takeoff, lambda: takeoff.next_mode is not None)


def _circle_leg(item: MissionItem, flight: FlightContext) -> MissionLeg:
    radius_m = 0.0 if isnan(item.param3) else abs(item.param3)
    orbit = Orbit(
        flight,
        place_of(item, flight),
        max(radius_m or flight.parameters["NAV_LOITER_RAD"], _LEAST_TURN_RADIUS_M),
        inf,
        # The sign decides, so that -0.0 and negative radii turn counter-clockwise.
        is_clockwise=copysign(1.0, item.param3) > 0.0,
    )
    return MissionLeg(orbit, lambda: orbit.turns >= item.param1)


def _pause_leg(item: MissionItem, flight: FlightContext) -> MissionLeg:
    leg = WaypointLeg(
        flight,
        flight.path.stopping_point(flight.limits.automatic),
        radius_m=inf,  # it is reached wherever the vehicle stops
        hold_s=seconds(item.param1) if item.command in WAITS else 0.0,
        yaw_rad=_turn_of(item, flight),
    )
    return MissionLeg(leg, lambda: leg.is_done)


def _turn_of(item: MissionItem, flight: FlightContext) -> float | None:
    """ENU heading of a yaw item: absolute by compass, or relative to the present heading."""
    if item.command != Cmd.CONDITION_YAW:
        return None
    if item.param4 != 1.0:
        return yaw_of(item.param1)
    # param3 is 1 clockwise, -1 counter-clockwise; ENU yaw counts counter-clockwise.
    side = -1.0 if item.param3 < 0.0 else 1.0
    return wrap_angle(flight.heading.yaw_rad - side * radians(item.param1))
