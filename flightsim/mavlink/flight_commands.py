"""Flight commands: arming, modes, takeoff, landing, places, speed, home and missions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.behaviours.precision_land import Precision
from flightsim.autopilot.mission_item import Cmd
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.results import ACCEPTED, CommandResult, Reply, denied, rejected
from flightsim.frames import Geodetic, swap_yaw_enu_ned
from flightsim.mavlink.commands import UNSUPPORTED, Command, Executor, choice, given
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.mode_report import ModeReport
from flightsim.mavlink.personalities import Personality
from flightsim.mavlink.view import VehicleView

# Bits of the base mode, and of parameter 2 of DO_REPOSITION.
_CUSTOM_MODE_FLAG = 1
_CHANGE_MODE_FLAG = 1
_FORCE = 21196
"""Value of parameter 2 of arm/disarm that skips the checks."""
_AIR_SPEED, _GROUND_SPEED = 0, 1
_NO_CHANGE, _DEFAULT_SPEED = -1.0, -2.0
_RESET_PARAMETERS = 2  # parameter 1 of PREFLIGHT_STORAGE
_MAX_MODE_PART = 0xFF
_PRECISIONS = frozenset(Precision)


def _yaw_of_degrees(heading_deg: float) -> float | None:
    """Return the ENU yaw of a heading in degrees; None for NaN."""
    return None if math.isnan(heading_deg) else swap_yaw_enu_ned(math.radians(heading_deg))


class FlightCommands:
    """Executes flight commands by calling the autopilot.

    Each handler converts units and frames, checks the values that only MAVLink knows, and leaves
    every other decision to the autopilot, so that clients of both personalities meet the same
    vehicle.
    """

    def __init__(self, view: VehicleView, personality: Personality, modes: ModeReport) -> None:
        self._view = view
        self._modes = modes
        self._autopilot: Autopilot = view.autopilot
        self._personality = personality
        self.executors: Mapping[int, Executor] = {
            mav.MAV_CMD_NAV_LOITER_UNLIM: self._loiter,
            mav.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda _: self._autopilot.return_to_launch(),
            mav.MAV_CMD_NAV_LAND: self._land,
            mav.MAV_CMD_NAV_TAKEOFF: self._takeoff,
            mav.MAV_CMD_DO_ORBIT: self._orbit,
            mav.MAV_CMD_NAV_GUIDED_ENABLE: self._guided_enable,
            mav.MAV_CMD_CONDITION_YAW: self._condition_yaw,
            mav.MAV_CMD_DO_SET_MODE: self._set_mode,
            mav.MAV_CMD_DO_CHANGE_SPEED: self._change_speed,
            mav.MAV_CMD_DO_SET_HOME: self._set_home,
            mav.MAV_CMD_DO_FLIGHTTERMINATION: self._terminate,
            mav.MAV_CMD_DO_CHANGE_ALTITUDE: self._change_altitude,
            mav.MAV_CMD_DO_REPOSITION: self._reposition,
            mav.MAV_CMD_DO_PAUSE_CONTINUE: self._pause_continue,
            mav.MAV_CMD_DO_SET_MISSION_CURRENT: self._set_mission_current,
            mav.MAV_CMD_PREFLIGHT_STORAGE: self._preflight_storage,
            mav.MAV_CMD_DO_SET_STANDARD_MODE: self._set_standard_mode,
            mav.MAV_CMD_MISSION_START: self._start_mission,
            mav.MAV_CMD_DO_LAND_START: self._start_landing,
            mav.MAV_CMD_COMPONENT_ARM_DISARM: self._arm,
            mav.MAV_CMD_RUN_PREARM_CHECKS: self._run_prearm_checks,
        }
        if personality.switches_fence:
            switch = {mav.MAV_CMD_DO_FENCE_ENABLE: self._enable_fence}
            self.executors = {**self.executors, **switch}

    def set_custom_mode(self, base_mode: int, custom_mode: int) -> Reply:
        """Change to the mode with a number of the personality.

        Args:
            base_mode: Base mode of the request; its flag 1 says that the number is a custom mode.
            custom_mode: The number.

        Returns:
            The reply; denied without the flag or if there is no such mode.
        """
        if not base_mode & _CUSTOM_MODE_FLAG:
            return denied(f"base mode {base_mode} has no custom mode flag (1)")
        entry = self._personality.selectable(custom_mode)
        if entry is None:
            reply = denied(f"custom mode {custom_mode:#x} does not exist")
        else:
            reply = self._modes.choose(entry)
        # ArduPilot's refusal of SET_MODE is FAILED, whatever the reason.
        if self._personality.acknowledges_set_mode and not reply.is_accepted:
            return Reply(CommandResult.FAILED, reply.reason)
        return reply

    def set_current_item(self, sequence: int) -> Reply:
        """Continue the mission at an item.

        Args:
            sequence: Number of the item on the wire, which for ArduPilot counts home.

        Returns:
            Acceptance, or a denial if there is no such item.
        """
        return self._autopilot.set_current_mission_item(self._index(sequence))

    # --- arming and modes ---

    def _arm(self, c: Command) -> Reply:
        is_forced = c.param2 == _FORCE
        match choice(c.param1):
            case 1:
                return self._autopilot.arm(is_forced=is_forced)
            case 0:
                return self._autopilot.disarm(is_forced=is_forced)
        return denied(f"param1 = {c.param1:g}; valid are 0 (disarm) and 1 (arm)")

    def _run_prearm_checks(self, _: Command) -> Reply:
        if self._autopilot.is_armed:
            return rejected("the vehicle is armed")
        self._autopilot.run_prearm_checks()
        return ACCEPTED

    def _set_mode(self, c: Command) -> Reply:
        base, main, sub = choice(c.param1), choice(c.param2), choice(c.param3, default=0)
        if base is None or main is None or sub is None:
            return denied(f"custom mode {c.param2:g}, {c.param3:g} does not exist")
        if not (0 <= main <= _MAX_MODE_PART and 0 <= sub <= _MAX_MODE_PART):
            return denied(f"custom mode {c.param2:g}, {c.param3:g} does not exist")
        return self.set_custom_mode(base, self._personality.custom_mode(main, sub))

    def _set_standard_mode(self, c: Command) -> Reply:
        standard = choice(c.param1)
        entry = None if standard is None else self._personality.standard(standard)
        if entry is None:
            return denied(f"standard mode {c.param1:g} does not exist here")
        return self._modes.choose(entry)

    def _guided_enable(self, c: Command) -> Reply:
        return self._autopilot.set_mode(Mode.OFFBOARD if c.param1 > 0.5 else Mode.HOLD)

    def _enable_fence(self, c: Command) -> Reply:
        match choice(c.param1):
            case 0 | 1 as is_enabled:
                self._autopilot.fence.switch = is_enabled == 1
            case _:
                # ArduPilot's 2 turns off a floor, which this fence does not have.
                reason = f"param1 = {c.param1:g}; valid are 0 (disable) and 1 (enable)"
                return Reply(CommandResult.FAILED, reason)
        return ACCEPTED

    def _terminate(self, c: Command) -> Reply:
        if c.param1 > 0.5:
            return self._autopilot.terminate()
        return denied("termination cannot be taken back")

    # --- places ---

    def _takeoff(self, c: Command) -> Reply:
        fault = c.place_fault()
        if fault:
            return denied(fault)
        altitude_m = c.altitude_amsl_m(self._view.home_altitude_m)
        # ArduPilot's takeoff counts from home whatever the frame says, and needs an armed vehicle.
        if self._personality.takes_off_above_home:
            if not self._autopilot.is_armed:
                return Reply(CommandResult.FAILED, "takeoff denied: not armed")
            altitude_m = c.z + self._view.home_altitude_m
        return self._autopilot.takeoff(given(altitude_m), yaw_rad=self._commanded_yaw(c))

    def _land(self, c: Command) -> Reply:
        fault = c.place_fault()
        if fault:
            return denied(fault)
        precision = choice(c.param2, default=Precision.NONE)
        if precision is None or precision not in _PRECISIONS:
            return denied(f"precision {c.param2:g}; valid are 0, 1 and 2")
        return self._autopilot.land(
            latitude_deg=None if c.is_here else c.x,
            longitude_deg=None if c.is_here else c.y,
            yaw_rad=self._commanded_yaw(c),
            precision=Precision(precision),
        )

    def _loiter(self, c: Command) -> Reply:
        if c.is_here:
            return self._autopilot.set_mode(Mode.HOLD)
        fault = c.place_fault()
        if fault:
            return denied(fault)
        return self._autopilot.goto(self._place(c), yaw_rad=_yaw_of_degrees(c.param4))

    def _reposition(self, c: Command) -> Reply:
        fault = c.place_fault()
        if fault:
            return denied(fault)
        flags = choice(c.param2) or 0
        if not flags & _CHANGE_MODE_FLAG and self._autopilot.mode is not Mode.HOLD:
            return rejected("not in hold, and param2 does not ask to change the mode (1)")
        return self._autopilot.goto(
            self._place(c),
            # In radians, unlike all other commands: https://mavlink.io/en/messages/common.html
            yaw_rad=None if math.isnan(c.param4) else swap_yaw_enu_ned(c.param4),
            speed_mps=c.param1 if c.param1 > 0.0 else None,
        )

    def _change_altitude(self, c: Command) -> Reply:
        frame = choice(c.param2)
        if frame not in {0, 3, 5, 6}:
            return denied(f"frame {c.param2:g}; valid are 0, 3, 5, 6")
        if not abs(c.param1) <= 1e5:
            return denied(f"altitude {c.param1:g} m; valid are -100000 to 100000")
        # Frames 5 and 6 are the integer variants of 0 (above the sea) and 3 (above home).
        is_amsl = frame in {0, 5}
        altitude_m = c.param1 + (0.0 if is_amsl else self._view.home_altitude_m)
        return self._autopilot.goto(Geodetic(math.nan, math.nan, altitude_m))

    def _orbit(self, c: Command) -> Reply:
        fault = c.place_fault()
        if fault:
            return denied(fault)
        radius_m = 10.0 if math.isnan(c.param1) else c.param1
        speed_mps = 2.0 if math.isnan(c.param2) else c.param2
        # As in PX4 above the sea whatever the frame: MAVSDK sends that in a frame above home.
        centre = replace(self._place(c), altitude_m=c.z)
        return self._autopilot.orbit(centre, radius_m=radius_m, speed_mps=speed_mps)

    def _set_home(self, c: Command) -> Reply:
        if c.param1 == 1.0:
            return self._autopilot.set_home(None)
        fault = c.place_fault()
        if fault or c.is_here or math.isnan(c.z):
            return denied(fault or "no place; param1 = 1 means here")
        return self._autopilot.set_home(self._place(c))

    def _commanded_yaw(self, c: Command) -> float | None:
        """Heading of a takeoff or landing, rad ENU; None keeps the present one."""
        return _yaw_of_degrees(c.param4) if self._personality.turns_to_commanded_heading else None

    def _place(self, c: Command) -> Geodetic:
        """Place of a command; NaN keeps the vehicle's coordinate."""
        altitude_m = c.altitude_amsl_m(self._view.home_altitude_m)
        if c.is_here:
            return Geodetic(math.nan, math.nan, altitude_m)
        return Geodetic(c.x, c.y, altitude_m)

    # --- underway ---

    def _condition_yaw(self, c: Command) -> Reply:
        if math.isnan(c.param1):
            return denied("param1 = nan; valid are degrees")
        heading_deg = c.param1
        if c.param4 == 1.0:  # relative
            heading_deg = self._view.heading_deg + (-c.param1 if c.param3 < 0 else c.param1)
        rate = None if not c.param2 > 0.0 else math.radians(c.param2)
        yaw_rad = swap_yaw_enu_ned(math.radians(heading_deg))
        return self._autopilot.set_yaw(yaw_rad, rate_radps=rate)

    def _change_speed(self, c: Command) -> Reply:
        if choice(c.param1) not in {_AIR_SPEED, _GROUND_SPEED}:
            # Air speed is flown as ground speed: the vehicle has no use for the difference.
            return denied(f"speed type {c.param1:g}; valid are 0 and 1")
        if math.isnan(c.param2) or c.param2 == _NO_CHANGE:
            return ACCEPTED
        return self._autopilot.set_speed(None if c.param2 == _DEFAULT_SPEED else c.param2)

    def _pause_continue(self, c: Command) -> Reply:
        match choice(c.param1):
            case 0:
                return self._autopilot.pause()
            case 1:
                return self._autopilot.resume()
        return denied(f"param1 = {c.param1:g}; valid are 0 (pause) and 1 (continue)")

    def _start_mission(self, c: Command) -> Reply:
        first, last = choice(c.param1, default=0), choice(c.param2, default=0)
        n_items = len(self._autopilot.mission)
        if first is not None and last is not None:
            first, last = self._index(first), self._index(last)
        if first is None or last is None or not 0 <= first < max(1, n_items):
            return denied(f"items {c.param1:g} to {c.param2:g}; there are {n_items}")
        # A last item that does not follow the first means none, as 0 does.
        return self._autopilot.start_mission(first, last if last > first else None)

    def _start_landing(self, _: Command) -> Reply:
        """Continue the mission at its first DO_LAND_START."""
        items = self._autopilot.mission.items
        starts = [index for index, item in enumerate(items) if item.command == Cmd.LAND_START]
        if not starts:
            return rejected("the mission has no DO_LAND_START")
        return self._autopilot.start_mission(starts[0])

    def _set_mission_current(self, c: Command) -> Reply:
        index = choice(c.param1)
        if index is None:
            return denied(f"item {c.param1:g} does not exist")
        return self.set_current_item(index)

    def _index(self, sequence: int) -> int:
        """Return the mission's index of an item's number on the wire; home means the first."""
        n_home_items = self._personality.n_home_items
        return max(0, sequence - n_home_items) if sequence >= 0 else sequence

    def _preflight_storage(self, c: Command) -> Reply:
        if choice(c.param1) != _RESET_PARAMETERS:
            return UNSUPPORTED  # parameters last as long as the simulation
        if self._autopilot.is_armed:
            return rejected("the vehicle is armed")
        self._autopilot.parameters.reset()
        return ACCEPTED
