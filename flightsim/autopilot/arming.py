"""May the vehicle be armed: what works, and what speaks against it."""

from __future__ import annotations

from math import isnan

from flightsim.autopilot.battery_monitor import BatteryMonitor
from flightsim.autopilot.flight import Flight
from flightsim.autopilot.mission_places import fence_breach, mission_obstacle
from flightsim.autopilot.modes import POSITION_MODES, BatteryWarning, Mode
from flightsim.autopilot.plant_like import PlantLike
from flightsim.autopilot.status import Health, PrearmReport

_STALE_US = 1_000_000
_MAX_TILT_COSINE = 0.5
_LOW_THROTTLE = 0.1
_NOT_FOR_TAKEOFF = frozenset({Mode.LAND, Mode.RETURN, Mode.DESCEND, Mode.TERMINATION, Mode.ORBIT})
_THRUST_MODES = frozenset({Mode.MANUAL, Mode.STABILIZED, Mode.ACRO})
_GNSS_FIX_3D = 3


class ArmingChecks:
    """Health and arming report, refreshed on demand."""

    def __init__(self, plant: PlantLike, flight: Flight, battery: BatteryMonitor) -> None:
        self._plant = plant
        self._flight = flight
        self._battery = battery
        self.health = Health()
        self.report = PrearmReport(is_ok=False, reasons=("starting up",))

    def refresh(self, mode: Mode, *, is_armed: bool) -> PrearmReport:
        """Look at everything again.

        Args:
            mode: Mode in which the vehicle would be armed.
            is_armed: Whether it already is, so that flying speaks against nothing.
        """
        sensors = self._plant.sensors
        vehicle, now_us = self._flight.vehicle, self._flight.vehicle.time_us
        fix_type = sensors.gnss.fix_type
        health = Health(
            is_imu_ok=_is_fresh(sensors.imu.time_us, now_us),
            is_mag_ok=_is_fresh(sensors.mag.time_us, now_us),
            is_baro_ok=_is_fresh(sensors.baro.time_us, now_us),
            is_gnss_ok=_is_fresh(sensors.gnss.time_us, now_us) and fix_type >= _GNSS_FIX_3D,
            is_rangefinder_ok=not isnan(sensors.range_m),
            is_attitude_ok=vehicle.is_attitude_ok,
            is_position_ok=vehicle.is_position_ok,
            is_home_set=self._flight.home is not None,
            is_battery_ok=self._battery.warning < BatteryWarning.CRITICAL,
            is_geofence_ok=fence_breach(self._flight, vehicle.position_enu_m) is None,
        )
        reasons = tuple(self._reasons(health, mode))
        is_armable = is_armed or not reasons
        if (health, is_armable) != (self.health, self.report.is_ok):
            self.health = _with_armable(health, is_armable=is_armable)
        if reasons != self.report.reasons or is_armable != self.report.is_ok:
            self.report = PrearmReport(is_ok=is_armable, reasons=reasons)
        return self.report

    def _reasons(self, health: Health, mode: Mode) -> list[str]:
        flight = self._flight
        reasons: list[str] = []
        if not health.is_imu_ok:
            reasons.append("no data from the IMU")
        if not health.is_attitude_ok:
            reasons.append("attitude estimate not valid")
        elif flight.vehicle.cos_tilt < _MAX_TILT_COSINE:
            reasons.append("vehicle is tilted by more than 60 degrees")
        if not health.is_position_ok and (mode in POSITION_MODES or mode is Mode.OFFBOARD):
            reasons.append("position estimate not valid")
        if not health.is_gnss_ok and flight.parameters["COM_ARM_WO_GPS"] == 0:
            reasons.append("no satellite fix")
        if not health.is_battery_ok:
            reasons.append("battery too low")
        if not health.is_geofence_ok and flight.parameters["GF_ACTION"] > 1:
            reasons.append("outside the geofence")
        if mode in _NOT_FOR_TAKEOFF:
            reasons.append(f"mode {mode.value} is not suitable for takeoff")
        if mode is Mode.MISSION and (obstacle := mission_obstacle(flight)):
            reasons.append(obstacle)
        if mode in _THRUST_MODES:
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


def _with_armable(health: Health, *, is_armable: bool) -> Health:
    values = {name: getattr(health, name) for name in Health.__dataclass_fields__}
    return Health(**{**values, "is_armable": is_armable})
