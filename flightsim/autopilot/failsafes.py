"""Failsafe conditions, and the action that each one demands.

Each condition is checked by itself. A new condition demands its action once, and so does one that
has become worse. The commander decides what follows, and a client may overrule it. Demanding an
action in every check would fight a client that has chosen another mode on purpose.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum, unique
from math import cos, radians

from autonomy.types import ControlLevel
from flightsim.autopilot.battery_monitor import BatteryMonitor
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_places import fence_breach
from flightsim.autopilot.modes import (
    POSITION_MODES,
    STICK_MODES,
    BatteryWarning,
    FailsafeReason,
    Mode,
)
from flightsim.autopilot.streams import DatalinkWatch


@unique
class Action(IntEnum):
    """Action that a failsafe demands; a greater number is stronger."""

    WARN = 0
    HOLD = 1
    STICKS = 2
    """Return control to the pilot: position mode, or hold while there are no sticks."""
    RETURN = 3
    LAND = 4
    DESCEND = 5
    DISARM = 6
    TERMINATE = 7


ACTION_MODES = {
    Action.HOLD: Mode.HOLD,
    Action.RETURN: Mode.RETURN,
    Action.LAND: Mode.LAND,
    Action.DESCEND: Mode.DESCEND,
    Action.TERMINATE: Mode.TERMINATION,
}
MEASURES = {
    Mode.RETURN: Action.RETURN,
    Mode.LAND: Action.LAND,
    Mode.PRECISION_LAND: Action.LAND,
    Mode.DESCEND: Action.DESCEND,
}
"""Modes that already are as strong as a failsafe action, so that a weaker one does not replace
them."""
_LINK_ACTIONS = {
    0: None,
    1: Action.HOLD,
    2: Action.RETURN,
    3: Action.LAND,
    4: Action.LAND,
    5: Action.TERMINATE,
    6: Action.DISARM,
}
"""Actions of NAV_DLL_ACT and NAV_RCL_ACT."""
# Values of COM_OBL_RC_ACT. 0 to 2 name a stick mode, which `Commander` chooses.
_OFFBOARD_ACTIONS = {
    0: Action.STICKS,
    1: Action.STICKS,
    2: Action.STICKS,
    3: Action.RETURN,
    4: Action.LAND,
    5: Action.HOLD,
    6: Action.TERMINATE,
    7: Action.DISARM,
}
_FENCE_ACTIONS = {
    1: Action.WARN,
    2: Action.HOLD,
    3: Action.RETURN,
    4: Action.TERMINATE,
    5: Action.LAND,
}
"""Actions of GF_ACTION and COM_WIND_MAX_ACT."""
# Values of COM_ACT_FAIL_ACT.
_MOTOR_ACTIONS = {
    0: Action.WARN,
    1: Action.HOLD,
    2: Action.LAND,
    3: Action.RETURN,
    4: Action.TERMINATE,
}
BATTERY_REASONS = frozenset(
    {FailsafeReason.BATTERY_LOW, FailsafeReason.BATTERY_CRITICAL, FailsafeReason.BATTERY_EMERGENCY}
)
"""Reasons that the battery monitor announces in its own words."""
_GOING_DOWN = frozenset(
    {Mode.RETURN, Mode.LAND, Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION}
)
_POSITION_GRACE_S = 0.5  # an estimate that returns within it interrupts nothing
_SHORTEST_GAP_S = 0.1  # lower bound of COM_OF_LOSS_T, so that 0 does not fail between two setpoints


class Failsafes:
    """Present failsafe conditions, and the actions that new ones demand."""

    def __init__(
        self, flight: FlightContext, battery: BatteryMonitor, datalink: DatalinkWatch
    ) -> None:
        self._flight = flight
        self._battery = battery
        self._datalink = datalink
        self._present: dict[FailsafeReason, Action] = {}
        self._had_sticks = False
        self._was_link_lost = False
        self._position_lost_us: int | None = None
        self._toppled_us: int | None = None
        # The order decides between actions of equal strength: the sort of `update` is stable.
        self._checks: tuple[tuple[FailsafeReason, Callable[[Mode], Action | None]], ...] = (
            (FailsafeReason.IMU_LOST, self._imu),
            (FailsafeReason.CRASHED, self._toppled),
            (FailsafeReason.MOTOR_LOST, self._motors),
            (FailsafeReason.POSITION_LOST, self._position),
            (FailsafeReason.BATTERY_EMERGENCY, self._battery_emergency),
            (FailsafeReason.BATTERY_CRITICAL, self._battery_critical),
            (FailsafeReason.BATTERY_LOW, self._battery_low),
            (FailsafeReason.OFFBOARD_LOST, self._offboard),
            (FailsafeReason.MANUAL_CONTROL_LOST, self._manual_control),
            (FailsafeReason.DATALINK_LOST, self._datalink_lost),
            (FailsafeReason.GEOFENCE, self._geofence),
            (FailsafeReason.WIND, self._wind),
        )

    @property
    def reason(self) -> FailsafeReason | None:
        """Present condition with the strongest action; None if none demands more than a warning."""
        if not self._present:
            return None
        worst = max(self._present, key=lambda reason: self._present[reason])
        return None if self._present[worst] is Action.WARN else worst

    def clear(self) -> None:
        """Forget all conditions, as at arming and disarming."""
        self._present.clear()
        self._had_sticks = False
        self._position_lost_us = self._toppled_us = None

    def watch_links(self) -> None:
        """Announce when ground stations fall silent or return, armed or not."""
        is_lost = self._datalink.is_lost(self._flight.vehicle.time_us)
        if is_lost != self._was_link_lost:
            self._was_link_lost = is_lost
            severity = Severity.WARNING if is_lost else Severity.INFO
            text = "lost" if is_lost else "regained"
            self._flight.events.report(severity, f"Connection to ground station {text}")

    def update(self, mode: Mode) -> list[tuple[FailsafeReason, Action]]:
        """Check all conditions of an armed vehicle.

        Args:
            mode: Present mode; some conditions count in some modes only.

        Returns:
            Conditions that are new or worse than before and their actions, strongest first.
        """
        now_us = self._flight.vehicle.time_us
        # Sticks that never were present cannot be lost.
        self._had_sticks = self._had_sticks or self._flight.sticks.is_alive(now_us)
        news: list[tuple[FailsafeReason, Action]] = []
        for reason, check in self._checks:
            action = check(mode)
            if action is None:
                self._present.pop(reason, None)
                continue
            before = self._present.get(reason)
            if before is None or action > before:
                self._present[reason] = action
                news.append((reason, action))
        if len(news) > 1:
            news.sort(key=lambda pair: -pair[1])
        return news

    def _imu(self, _mode: Mode) -> Action | None:
        # Without an inertial sensor there is no attitude, so nothing can be flown any more.
        return None if self._flight.vehicle.is_imu_ok else Action.TERMINATE

    def _motors(self, _mode: Mode) -> Action | None:
        """Demand the action of COM_ACT_FAIL_ACT for one lost motor; two end the flight."""
        n_lost = len(self._flight.vehicle.lost_rotors)
        if n_lost > 1:
            return Action.TERMINATE
        return _MOTOR_ACTIONS[int(self._flight.parameters["COM_ACT_FAIL_ACT"])] if n_lost else None

    def _toppled(self, mode: Mode) -> Action | None:
        vehicle, p = self._flight.vehicle, self._flight.parameters
        limit_rad = radians(p["FD_FAIL_R"])
        # Acro may be flown upside down on purpose; 0 switches the check off.
        if mode is Mode.ACRO or limit_rad == 0.0 or vehicle.cos_tilt > cos(limit_rad):
            self._toppled_us = None
            return None
        if self._toppled_us is None:
            self._toppled_us = vehicle.time_us
        toppled_s = 1e-6 * (vehicle.time_us - self._toppled_us)
        return Action.DISARM if toppled_s >= p["FD_FAIL_R_TTRI"] else None

    def _position(self, mode: Mode) -> Action | None:
        vehicle = self._flight.vehicle
        if vehicle.is_position_ok or not self._needs_position(mode):
            self._position_lost_us = None
            return None
        if self._position_lost_us is None:
            self._position_lost_us = vehicle.time_us
        lost_s = 1e-6 * (vehicle.time_us - self._position_lost_us)
        return Action.DESCEND if lost_s >= _POSITION_GRACE_S else None

    def _needs_position(self, mode: Mode) -> bool:
        # Attitudes and rates can be followed without a position, trajectories cannot.
        if mode is Mode.OFFBOARD:
            setpoint = self._flight.offboard.setpoint
            return setpoint is not None and setpoint.level == ControlLevel.TRAJECTORY
        return mode in POSITION_MODES

    def _battery_low(self, _mode: Mode) -> Action | None:
        return Action.WARN if self._battery.warning is BatteryWarning.LOW else None

    def _battery_critical(self, _mode: Mode) -> Action | None:
        if self._battery.warning is not BatteryWarning.CRITICAL:
            return None
        measures = {2: Action.LAND, 3: Action.RETURN}
        return measures.get(int(self._flight.parameters["COM_LOW_BAT_ACT"]), Action.WARN)

    def _battery_emergency(self, _mode: Mode) -> Action | None:
        if self._battery.warning is not BatteryWarning.EMERGENCY:
            return None
        return Action.LAND if self._flight.parameters["COM_LOW_BAT_ACT"] >= 2 else Action.WARN

    def _offboard(self, mode: Mode) -> Action | None:
        if mode is not Mode.OFFBOARD:
            return None
        p = self._flight.parameters
        limit_us = 1e6 * max(p["COM_OF_LOSS_T"], _SHORTEST_GAP_S)
        if self._flight.offboard.is_alive(self._flight.vehicle.time_us, limit_us):
            return None
        return _OFFBOARD_ACTIONS[int(p["COM_OBL_RC_ACT"])]

    def _manual_control(self, mode: Mode) -> Action | None:
        if not self._had_sticks or mode in _GOING_DOWN:
            return None
        if self._flight.sticks.is_alive(self._flight.vehicle.time_us):
            return None
        excepted = int(self._flight.parameters["COM_RCL_EXCEPT"])
        # Bits of COM_RCL_EXCEPT: 1 mission, 2 other automatic modes, 4 offboard.
        bit = {Mode.MISSION: 1, Mode.OFFBOARD: 4}.get(mode, 2)
        if mode not in STICK_MODES and excepted & bit:
            return None
        return _LINK_ACTIONS[int(self._flight.parameters["NAV_RCL_ACT"])]

    def _datalink_lost(self, mode: Mode) -> Action | None:
        if mode in _GOING_DOWN or not self._datalink.is_lost(self._flight.vehicle.time_us):
            return None
        return _LINK_ACTIONS[int(self._flight.parameters["NAV_DLL_ACT"])]

    def _geofence(self, _mode: Mode) -> Action | None:
        flight = self._flight
        measure = int(flight.parameters["GF_ACTION"])
        if measure == 0 or fence_breach(flight, flight.vehicle.position_enu_m) is None:
            return None
        return _FENCE_ACTIONS[measure]

    def _wind(self, _mode: Mode) -> Action | None:
        p = self._flight.parameters
        measure = int(p["COM_WIND_MAX_ACT"])
        if measure == 0 or not 0.0 <= p["COM_WIND_MAX"] < self._flight.vehicle.wind_mps:
            return None
        return _FENCE_ACTIONS[measure]
