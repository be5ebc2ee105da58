"""Mission mode: flies legs, applies settings and counts jumps, item by item."""

from __future__ import annotations

from dataclasses import replace

from autonomy.types import IDLE, Setpoint, Vector3
from flightsim.autopilot.behaviours.mission_legs import (
    LEG_COMMANDS,
    WAITS,
    MissionLeg,
    climb_leg,
    leg_of,
    loiter_leg,
    seconds,
)
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_item import PAYLOAD_COMMANDS, Cmd, MissionItem
from flightsim.autopilot.mission_places import place_of
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S

_MAX_INSTANT_ITEMS = 50
"""Most consecutive items without duration; more can only be a ring of jumps."""
_DEFAULT_SPEED = -2.0  # value of DO_CHANGE_SPEED that restores the default; -1 changes nothing


class MissionFlight:
    """Executes `flight.mission` from its current item.

    Some items are flown as legs, others take no time and are applied on the way. Clients may upload
    or select items at any time, so each tick first compares the counters of the mission with those
    seen last.
    """

    def __init__(self, flight: FlightContext, *, last_index: int | None = None) -> None:
        """Prepare to fly the mission.

        Args:
            flight: Shared state with the mission.
            last_index: Item after which to stop; None flies all.
        """
        self._flight = flight
        self._last_index = last_index
        self._followed = (-1, -1)
        self._index: int | None = None
        self._leg: MissionLeg | None = None
        self._is_climbing_first = False
        self._passed_enu_m: Vector3 | None = None
        self._waited_s = 0.0
        self.next_mode: Mode | None = None

    @property
    def is_landing(self) -> bool:
        """True if the present leg is a landing that descends."""
        return self._leg is not None and self._leg.behaviour.is_landing

    @property
    def may_rest(self) -> bool:
        """True while it lands, so that the rotors may idle at contact."""
        return self.is_landing

    def ready_to_lift(self) -> bool:
        """Execute items that need no flight; return true if the present item flies."""
        self._synchronise()
        item = self._item()
        if item is None or self._flight.mission.is_finished:
            return False
        if item.command in WAITS:
            self._waited_s += TICK_S
            if self._waited_s >= seconds(item.param1):
                self._complete()
            return False
        # On the ground a landing is over, and a vehicle cannot turn.
        if item.command in {Cmd.LAND, Cmd.CONDITION_YAW}:
            self._complete()
            return False
        return True

    def start(self) -> None:
        """Begin the leg of the present item from here."""
        self._synchronise()
        self._passed_enu_m = None
        self._begin_leg()

    def update(self) -> Setpoint:
        """Fly the present leg; continue with the next item at its end.

        The rotors idle if there is no item left to fly.
        """
        if self._synchronise() or self._leg is None:
            self._begin_leg()
        leg = self._leg
        if leg is None:
            return IDLE
        setpoint = leg.behaviour.update()
        if leg.is_done():
            # The climb came first; the item itself is flown now.
            if self._is_climbing_first:
                self._begin_leg()
            else:
                self._complete()
        return setpoint

    def _item(self) -> MissionItem | None:
        items = self._flight.mission.items
        return items[self._index] if self._index is not None and self._index < len(items) else None

    def _synchronise(self) -> bool:
        """Follow changes that clients made to the mission; return true if there were any."""
        mission = self._flight.mission
        if (mission.revision, mission.n_selections) == self._followed:
            return False
        if self._index is None and mission.is_finished:
            mission.rewind()
        self._followed = (mission.revision, mission.n_selections)
        self._passed_enu_m = None
        self._go_to(mission.current_index)
        return True

    def _go_to(self, index: int) -> None:
        """Make an item the present one, or the first item after it that takes time."""
        mission = self._flight.mission
        self._leg = None
        self._waited_s = 0.0
        for _ in range(_MAX_INSTANT_ITEMS):
            if index >= len(mission.items):
                self._finish()
                return
            self._index = mission.current_index = index
            item = mission.items[index]
            if item.command in LEG_COMMANDS:
                return
            index = self._apply(index, item)
            self._report_reached(self._index)
            if self._ends_after(self._index) or self.next_mode is not None:
                self._finish()
                return
        self._flight.events.report(Severity.WARNING, "Mission stopped: its items only jump")
        self._finish()

    def _complete(self) -> None:
        """Finish the present item and go to the next."""
        # `_apply` may have finished the mission or chosen another mode.
        index, item = self._index, self._item()
        if index is None or item is None:
            return
        self._report_reached(index)
        if self._ends_after(index):
            self._finish()
        else:
            self._go_to(index + 1)
        # An item without autocontinue stops the mission: hold follows until a client goes on.
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
            flight.events.report(Severity.INFO, f"Mission finished{ending}")

    def _report_reached(self, index: int) -> None:
        self._flight.mission.last_reached_index = index
        self._flight.events.mission_item_reached(index)

    def _ends_after(self, index: int) -> bool:
        return self._last_index is not None and index >= self._last_index

    def _begin_leg(self) -> None:
        """Create and start the leg of the present item."""
        flight = self._flight
        index, item = self._index, self._item()
        self._is_climbing_first = False
        if index is None or item is None or flight.mission.is_finished:
            leg = loiter_leg(flight)
        # A mission without a takeoff item climbs first: a leg from the ground would drag along it.
        elif flight.vehicle.is_landed and item.command != Cmd.TAKEOFF:
            self._is_climbing_first = True
            leg = climb_leg(flight, item)
        else:
            may_pass = item.is_autocontinue and not self._ends_after(index)
            leg = leg_of(
                index, item, flight, line_start_enu_m=self._passed_enu_m, may_pass=may_pass
            )
            self._passed_enu_m = leg.passed_enu_m
        self._leg = leg
        leg.behaviour.start()

    def _apply(self, index: int, item: MissionItem) -> int:
        """Execute an item without duration; return the index of the next item."""
        flight = self._flight
        match item.command:
            case Cmd.JUMP:
                # A negative count repeats for ever. A jump that is used up counts anew when it is
                # met again.
                n_jumps = flight.mission.n_jumps
                if item.param2 < 0.0 or n_jumps.get(index, 0) < item.param2:
                    n_jumps[index] = n_jumps.get(index, 0) + 1
                    return int(item.param1)
                n_jumps.pop(index, None)
            case Cmd.CHANGE_SPEED:
                self._change_speed(item)
            case Cmd.RETURN:
                self.next_mode = Mode.RETURN
            case Cmd.SET_HOME:
                flight.move_home(None if item.param1 == 1.0 else place_of(item, flight))
            case Cmd.FENCE_ENABLE:
                flight.fence.switch = item.param1 == 1.0
                is_on = "enabled" if flight.fence.switch else "disabled"
                flight.events.report(Severity.NOTICE, f"Fence {is_on} by mission")
            case command if command in PAYLOAD_COMMANDS:
                flight.events.payload_order(item)
        return index + 1

    def _change_speed(self, item: MissionItem) -> None:
        speed_mps = item.param2 if item.param2 > 0.0 else None
        if speed_mps is None and item.param2 != _DEFAULT_SPEED:
            return
        limits = self._flight.limits
        match item.param1:
            case 2.0:
                limits.speeds = replace(limits.speeds, climb_mps=speed_mps)
            case 3.0:
                limits.speeds = replace(limits.speeds, descent_mps=speed_mps)
            case _:
                limits.speeds = replace(limits.speeds, cruise_mps=speed_mps)
