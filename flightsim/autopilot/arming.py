"""Arming checks: health of the vehicle and reasons that forbid arming."""

from __future__ import annotations

from math import isnan

from flightsim.autopilot.battery_monitor import BatteryMonitor
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_places import fence_breach, mission_obstacle
from flightsim.autopilot.modes import POSITION_MODES, THRUST_MODES, BatteryWarning, Mode
from flightsim.autopilot.status import Health, PrearmReport
from flightsim.plant import Plant

_STALE_US = 1_000_000
_MAX_TILT_COSINE = 0.5
_LOW_THROTTLE = 0.1
_NOT_FOR_TAKEOFF = frozenset(
    {Mode.LAND, Mode.RETURN, Mode.DESCEND, Mode.TERMINATION, Mode.ORBIT, Mode.FOLLOW}
)
_GNSS_FIX_3D = 3


class ArmingChecks:
    """Health and arming report, updated by `refresh`."""

    def __init__(self, plant: Plant, flight: FlightContext, battery: BatteryMonitor) -> None:
        self._plant = plant
        self._flight = flight
        self._battery = battery
        self.health = Health()
        self.report = PrearmReport(is_ok=False, reasons=("starting up",))

    def refresh(self, mode: Mode, *, is_armed: bool) -> PrearmReport:
        """Run all checks.

        Args:
            mode: Mode in which the vehicle would be armed.
            is_armed: Whether it is armed already, so that being in the air is no reason against it.
        """
        reasons = tuple(self._reasons(mode))
        is_ok = is_armed or not reasons
        self.report = PrearmReport(is_ok=is_ok, reasons=reasons)
        self.health = self._health(is_armable=is_ok)
        return self.report

    def _health(self, *, is_armable: bool) -> Health:
        flight, vehicle = self._flight, self._flight.vehicle
        sensors, now_us = self._plant.sensors, vehicle.time_us
        return Health(
            is_imu_ok=_is_fresh(sensors.imu.time_us, now_us),
            is_mag_ok=_is_fresh(sensors.mag.time_us, now_us),
            is_baro_ok=_is_fresh(sensors.baro.time_us, now_us),
            is_gnss_ok=self._has_fix(),
            is_rangefinder_ok=not isnan(sensors.range_m),
            is_attitude_ok=vehicle.is_attitude_ok,
            is_position_ok=vehicle.is_position_ok,
            is_battery_ok=self._battery.warning < BatteryWarning.CRITICAL,
            is_geofence_ok=fence_breach(flight, vehicle.position_enu_m) is None,
            is_armable=is_armable,
        )

    def _has_fix(self) -> bool:
        gnss = self._plant.sensors.gnss
        is_fresh = _is_fresh(gnss.time_us, self._flight.vehicle.time_us)
        return is_fresh and gnss.fix_type >= _GNSS_FIX_3D

    def _reasons(self, mode: Mode) -> list[str]:
        flight, vehicle, p = self._flight, self._flight.vehicle, self._flight.parameters
        reasons: list[str] = []
        if not vehicle.is_attitude_ok:
            reasons.append("attitude estimate not valid")
        elif vehicle.cos_tilt < _MAX_TILT_COSINE:
            reasons.append("vehicle is tilted by more than 60 degrees")
        if not vehicle.is_position_ok and (mode in POSITION_MODES or mode is Mode.OFFBOARD):
            reasons.append("position estimate not valid")
        if p["COM_ARM_WO_GPS"] == 0 and not self._has_fix():
            reasons.append("no satellite fix")
        if self._battery.warning >= BatteryWarning.CRITICAL:
            reasons.append("battery too low")
        if p["GF_ACTION"] > 1 and fence_breach(flight, vehicle.position_enu_m):
            reasons.append("outside the geofence")
        if mode in _NOT_FOR_TAKEOFF:
            reasons.append(f"mode {mode.value} is not suitable for takeoff")
        if mode is Mode.MISSION and (obstacle := mission_obstacle(flight)):
            reasons.append(obstacle)
        if mode in THRUST_MODES:
            reasons.extend(self._stick_reasons())
        return reasons

    def _stick_reasons(self) -> list[str]:
        sticks, now_us = self._flight.sticks, self._flight.vehicle.time_us
        if not sticks.is_alive(now_us):
            return ["no manual control"]
        if sticks.current(now_us).throttle > _LOW_THROTTLE:
            return ["throttle is not down"]
        return []


def _is_fresh(time_us: int, now_us: int) -> bool:
    return now_us - time_us < _STALE_US
