"""Mode entry: the modes that may be entered now, and the behaviour of each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from flightsim.autopilot.behaviours import Behaviour
from flightsim.autopilot.behaviours.follow import Follow
from flightsim.autopilot.behaviours.hold import Hold
from flightsim.autopilot.behaviours.land import Descend, Land
from flightsim.autopilot.behaviours.manual import Manual, StickGuided
from flightsim.autopilot.behaviours.mission import MissionFlight
from flightsim.autopilot.behaviours.offboard import Offboard
from flightsim.autopilot.behaviours.precision_land import PrecisionLand
from flightsim.autopilot.behaviours.return_home import ReturnHome
from flightsim.autopilot.behaviours.takeoff import Takeoff
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_obstacle import mission_obstacle
from flightsim.autopilot.modes import POSITION_MODES, THRUST_MODES, Mode
from flightsim.autopilot.results import ACCEPTED, Reply, denied, rejected

_BEHAVIOURS: dict[Mode, Callable[[FlightContext], Behaviour]] = {
    Mode.TAKEOFF: Takeoff,
    Mode.LAND: Land,
    Mode.PRECISION_LAND: PrecisionLand,
    Mode.RETURN: ReturnHome,
    Mode.MISSION: MissionFlight,
    Mode.OFFBOARD: Offboard,
    Mode.FOLLOW: Follow,
    Mode.DESCEND: Descend,
    # Nothing flies in termination, because the commander stops the rotors; it needs some behaviour.
    Mode.TERMINATION: Descend,
    Mode.ALTITUDE: partial(StickGuided, holds_position=False),
    Mode.POSITION: partial(StickGuided, holds_position=True),
    Mode.MANUAL: partial(Manual, is_acro=False),
    Mode.STABILIZED: partial(Manual, is_acro=False),
    Mode.ACRO: partial(Manual, is_acro=True),
}
"""Behaviour of each mode, unless a request demands another one; hold for the modes that are
missing."""


def behaviour_of(mode: Mode, flight: FlightContext) -> Behaviour:
    """Return a new behaviour for a mode, which is not started yet.

    Args:
        mode: Mode; one without a behaviour of its own holds the place.
        flight: State and limits that the behaviour flies by.
    """
    return _BEHAVIOURS.get(mode, Hold)(flight)


def may_enter(mode: Mode, flight: FlightContext, *, is_armed: bool, is_bare: bool) -> Reply:
    """Reply to a client that wants to change to a mode: accepted, or the reason why not.

    Args:
        mode: The mode.
        flight: Shared state.
        is_armed: True if the vehicle is armed.
        is_bare: True if the request has only a mode, without place or circle.

    Returns:
        Denied if the mode can never be entered so, rejected if it may be entered later.
    """
    now_us = flight.vehicle.time_us
    if mode in {Mode.DESCEND, Mode.TERMINATION} or (mode is Mode.ORBIT and is_bare):
        return denied(f"{mode.value} is no mode to switch to")
    if mode in POSITION_MODES and not flight.vehicle.is_position_ok:
        return rejected("no valid position estimate")
    if mode is Mode.MISSION and (obstacle := mission_obstacle(flight)):
        return denied(obstacle)
    if mode is Mode.OFFBOARD and not flight.offboard.is_alive(now_us):
        return rejected("no offboard setpoints arrive")
    # On the ground sticks may come later: arming asks for them.
    if mode in THRUST_MODES and is_armed and not flight.sticks.is_alive(now_us):
        return rejected("no manual control")
    return ACCEPTED
