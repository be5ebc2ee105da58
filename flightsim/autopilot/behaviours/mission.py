"""Mission: one item after the other, legs flown, settings applied, jumps counted."""

from __future__ import annotations

from collections.abc import Callable
from math import copysign, inf, isnan, radians

from autonomy.types import IDLE, Setpoint
from flightsim.autopilot.behaviours import Behaviour
from flightsim.autopilot.behaviours.hold import Hold
from flightsim.autopilot.behaviours.land import Land
from flightsim.autopilot.behaviours.orbit import Orbit
from flightsim.autopilot.behaviours.takeoff import Takeoff
from flightsim.autopilot.behaviours.waypoint import WaypointLeg
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight import Flight
from flightsim.autopilot.heading import wrap_angle
from flightsim.autopilot.mission import PLACE_COMMANDS, Cmd, MissionItem
from flightsim.autopilot.mission_places import place_after, place_of, yaw_of
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S

_MAX_INSTANT_ITEMS = 50
"""Items without duration in a row; more can only be a ring of jumps."""
_WAITS = frozenset({Cmd.DELAY, Cmd.CONDITION_DELAY})
_LEG_COMMANDS = PLACE_COMMANDS | _WAITS | {Cmd.CONDITION_YAW}


class MissionFlight:
    """Works off `flight.mission`, from its current item on."""

    def __init__(self, flight: Flight, *, last_index: int | None = None) -> None:
        """Prepare.

        Args:
            flight: Shared state with the mission.
            last_index: Item after which to stop; None flies all.
        """
        self._flight = flight
        self._last_index = last_index
        self._followed = (-1, -1)
        self._index: int | None = None
        self._leg: Behaviour | None = None
        self._is_leg_done: Callable[[], bool] = bool
        self._passed_enu_m: tuple[float, float, float] | None = None
        self._waited_s = 0.0
        self._jumps: dict[int, int] = {}
        self.next_mode: Mode | None = None

    @property
    def is_landing(self) -> bool:
        """Whether the present leg is a landing."""
        return self._leg is not None and self._leg.is_landing

    def ready_to_lift(self) -> bool:
        """Work off what can be done on the ground; whether the present item flies."""
        self._synchronise()
        item = self._item()
        if item is None or self._flight.mission.is_finished:
            return False
        if item.command in _WAITS:
            self._waited_s += TICK_S
            if self._waited_s >= _seconds(item.param1):
                self._complete()
            return False
        if item.command in {Cmd.LAND, Cmd.CONDITION_YAW}:
            self._complete()
            return False
        return item.command in _LEG_COMMANDS

    def start(self) -> None:
        """Begin the leg of the present item here."""
        self._synchronise()
        self._passed_enu_m = None
        self._begin_leg()

    def update(self) -> Setpoint:
        """Fly the present leg, go on to the next item at its end."""
        if self._synchronise() or self._leg is None:
            self._begin_leg()
        leg = self._leg
        if leg is None:
            return IDLE
        setpoint = leg.update()
        if self._is_leg_done():
            if isinstance(leg, Takeoff) and not self._is_takeoff_item():
                self._begin_leg()
            else:
                self._complete()
        return setpoint

    def _item(self) -> MissionItem | None:
        items = self._flight.mission.items
        return items[self._index] if self._index is not None and self._index < len(items) else None

    def _is_takeoff_item(self) -> bool:
        item = self._item()
        return item is not None and item.command == Cmd.TAKEOFF

    def _synchronise(self) -> bool:
        """Follow changes that clients made to the mission; whether there were any."""
        mission = self._flight.mission
        present = (mission.revision, mission.n_selections)
        if present == self._followed:
            return False
        if self._index is None and mission.is_finished:
            mission.rewind()
        if present[0] != self._followed[0]:
            self._jumps.clear()
        self._followed = (mission.revision, mission.n_selections)
        self._passed_enu_m = None
        self._go_to(mission.current_index)
        return True

    def _go_to(self, index: int) -> None:
        """Make an item the present one, or the first after it that takes time."""
        mission = self._flight.mission
        self._leg = None
        self._waited_s = 0.0
        for _ in range(_MAX_INSTANT_ITEMS):
            if index >= len(mission.items):
                self._finish()
                return
            self._index = index
            mission.current_index = index
            item = mission.items[index]
            if item.command in _LEG_COMMANDS:
                return
            index = self._apply(index, item)
            self._report_reached(self._index)
            if self._ends_after(self._index) or self.next_mode is not None:
                self._finish()
                return
        self._flight.events.say(Severity.WARNING, "Mission stopped: its items only jump")
        self._finish()

    def _complete(self) -> None:
        """Leave the present item for the next."""
        index, item = self._index, self._item()
        if index is None or item is None:
            return
        self._report_reached(index)
        if self._ends_after(index):
            self._finish()
        else:
            self._go_to(index + 1)
        if not item.is_autocontinue and not self._flight.mission.is_finished:
            self.next_mode = Mode.HOLD
        if not self._flight.vehicle.is_landed:
            self._begin_leg()

    def _finish(self) -> None:
        flight = self._flight
        flight.mission.is_finished = True
        self._index = flight.mission.current_index
        self._leg = None
        if self.next_mode is None:
            ending = "" if flight.vehicle.is_landed else ", loitering"
            flight.events.say(Severity.INFO, f"Mission finished{ending}")

    def _report_reached(self, index: int) -> None:
        self._flight.mission.last_reached_index = index
        self._flight.events.mission_item_reached(index)

    def _ends_after(self, index: int) -> bool:
        return self._last_index is not None and index >= self._last_index

    def _apply(self, index: int, item: MissionItem) -> int:
        """Carry out an item without duration, and return the index that follows it."""
        flight = self._flight
        match item.command:
            case Cmd.JUMP:
                n_jumps = self._jumps.get(index, 0)
                if item.param2 < 0.0 or n_jumps < item.param2:
                    self._jumps[index] = n_jumps + 1
                    return int(item.param1)
                self._jumps.pop(index, None)
            case Cmd.CHANGE_SPEED:
                self._change_speed(item)
            case Cmd.RETURN:
                self.next_mode = Mode.RETURN
            case Cmd.SET_HOME:
                flight.move_home(None if item.param1 == 1.0 else place_of(item, flight))
        return index + 1

    def _change_speed(self, item: MissionItem) -> None:
        speed_mps = item.param2 if item.param2 > 0.0 else None
        if speed_mps is None and item.param2 != -2.0:
            return
        limits = self._flight.limits
        match item.param1:
            case 2.0:
                limits.change_speeds(climb_mps=speed_mps)
            case 3.0:
                limits.change_speeds(descent_mps=speed_mps)
            case _:
                limits.change_speeds(cruise_mps=speed_mps)

    def _begin_leg(self) -> None:
        """Make and start the leg of the present item."""
        flight = self._flight
        item = self._item()
        leg: Behaviour
        if item is None or flight.mission.is_finished:
            leg, self._is_leg_done = Hold(flight), bool
        elif flight.vehicle.is_landed and item.command != Cmd.TAKEOFF:
            leg = Takeoff(flight, self._first_height(item))
            self._is_leg_done = self._has_leg_ended
        else:
            leg = self._leg_of(item)
        self._leg = leg
        leg.start()

    def _first_height(self, item: MissionItem) -> float:
        """Height to climb to before a mission that begins without a takeoff."""
        flight = self._flight
        least_m = flight.path.position_enu_m[2] + flight.parameters["MIS_TAKEOFF_ALT"]
        return max(least_m, place_of(item, flight)[2])

    def _leg_of(self, item: MissionItem) -> Behaviour:
        flight = self._flight
        yaw_rad = yaw_of(item.param4) if item.command in PLACE_COMMANDS else None
        match item.command:
            case Cmd.TAKEOFF:
                self._is_leg_done = self._has_leg_ended
                return Takeoff(flight, place_of(item, flight)[2], yaw_rad)
            case Cmd.LAND:
                self._is_leg_done = bool
                x, y, _ = place_of(item, flight)
                return Land(flight, None if item.is_here else (x, y), yaw_rad)
            case Cmd.LOITER_TURNS:
                return self._circle_of(item)
            case _:
                return self._waypoint_of(item, yaw_rad)

    def _has_leg_ended(self) -> bool:
        return self._leg is not None and self._leg.next_mode is not None

    def _circle_of(self, item: MissionItem) -> Orbit:
        flight = self._flight
        radius_m = abs(item.param3) if item.param3 and not isnan(item.param3) else 0.0
        orbit = Orbit(
            flight,
            place_of(item, flight),
            max(radius_m or flight.parameters["NAV_LOITER_RAD"], 1.0),
            inf,
            is_clockwise=not copysign(1.0, item.param3) < 0.0,
        )
        self._is_leg_done = lambda: orbit.turns >= item.param1
        return orbit

    def _waypoint_of(self, item: MissionItem, yaw_rad: float | None) -> WaypointLeg:
        flight = self._flight
        index = self._index
        assert index is not None
        radius_m, hold_s, next_goal = flight.parameters["NAV_ACC_RAD"], 0.0, None
        if item.command in _WAITS or item.command == Cmd.CONDITION_YAW:
            goal = flight.path.stopping_point(flight.limits.automatic)
            radius_m = inf
            hold_s = _seconds(item.param1) if item.command in _WAITS else 0.0
            yaw_rad = self._turn_of(item)
        else:
            goal = place_of(item, flight)
        match item.command:
            case Cmd.WAYPOINT:
                hold_s = _seconds(item.param1)
                radius_m = item.param2 if item.param2 > 0.0 else radius_m
                if hold_s == 0.0 and item.is_autocontinue and not self._ends_after(index):
                    next_goal = place_after(index, flight, goal[2])
            case Cmd.LOITER_TIME:
                hold_s = _seconds(item.param1)
            case Cmd.LOITER_UNLIMITED:
                hold_s = inf
        leg = WaypointLeg(
            flight,
            goal,
            radius_m=radius_m,
            hold_s=hold_s,
            yaw_rad=yaw_rad,
            line_start_enu_m=self._passed_enu_m,
            next_goal_enu_m=next_goal,
        )
        self._passed_enu_m = goal if next_goal is not None else None
        self._is_leg_done = lambda: leg.is_done
        return leg

    def _turn_of(self, item: MissionItem) -> float | None:
        """ENU heading of a yaw item: absolute by compass, or relative to the present one."""
        if item.command != Cmd.CONDITION_YAW:
            return None
        if item.param4 != 1.0:
            return yaw_of(item.param1)
        side = -1.0 if item.param3 < 0.0 else 1.0
        return wrap_angle(self._flight.heading.yaw_rad - side * radians(item.param1))


def _seconds(value: float) -> float:
    return 0.0 if isnan(value) else max(value, 0.0)
