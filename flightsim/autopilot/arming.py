"""Arming checks: health of the vehicle, and reasons that forbid arming.

The checks run twice a second and before each arming. They depend on the mode in which the vehicle
would be armed: for example, a mission needs a position and a flyable mission, stick modes need
sticks.
"""

from __future__ import annotations

from math import isnan

from flightsim.autopilot.battery_monitor import BatteryMonitor
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.mission_obstacle import mission_obstacle
from flightsim.autopilot.mission_places import fence_breach
from flightsim.autopilot.modes import POSITION_MODES, THRUST_MODES, BatteryWarning, Mode
from flightsim.autopilot.status import Health, PrearmReport
from flightsim.plant import Plant
from flightsim.sensors.barometer import BAROMETER
from flightsim.sensors.gnss import GNSS
from flightsim.sensors.imu import IMU
from flightsim.sensors.magnetometer import MAGNETOMETER
from flightsim.sensors.rangefinder import RANGEFINDER
from flightsim.sensors.sensor import Sensor

_STALE_US = 1_000_000  # longest silence of a sensor that still delivers
_MAX_TILT_COSINE = 0.5  # cosine of 60 degrees
# Throttle above this would lift the vehicle at once in modes that pass it on.
_LOW_THROTTLE = 0.1
# These modes end a flight or need one that is under way.
_NOT_FOR_TAKEOFF = frozenset(
    {
        *(Mode.LAND, Mode.PRECISION_LAND, Mode.RETURN, Mode.DESCEND, Mode.TERMINATION),
        *(Mode.ORBIT, Mode.FOLLOW),
    }
)
_GNSS_FIX_3D = 3  # fix_type of a receiver that knows its height as well
_TOLD = {
    "is_imu_ok": "Inertial sensor",
    "is_mag_ok": "Magnetometer",
    "is_baro_ok": "Barometer",
    "is_gnss_ok": "Satellite fix",
    "is_rangefinder_ok": "Rangefinder",
}
"""Fields of `Health` whose changes are reported as texts, with the sensor's name in the text."""


class ArmingChecks:
    """Health and arming report; `refresh` updates both."""

    def __init__(self, plant: Plant, flight: FlightContext, battery: BatteryMonitor) -> None:
        self._plant = plant
        self._flight = flight
        self._battery = battery
        self._lost: set[str] = set()
        self.health = Health()
        self.report = PrearmReport(is_ok=False, reasons=("starting up",))

    def refresh(self, mode: Mode, *, is_armed: bool) -> PrearmReport:
        """Run all checks, update `health` and `report`, and return the report.

        Args:
            mode: Mode in which the vehicle would be armed.
            is_armed: True if the vehicle is armed already. Its report is then always positive,
                because being in the air is no reason against arming.
        """
        reasons = tuple(self._reasons(mode))
        is_ok = is_armed or not reasons
        self.report = PrearmReport(is_ok=is_ok, reasons=reasons)
        before, self.health = self.health, self._health(is_armable=is_ok)
        self._tell_changes(before)
        return self.report

    def announce(self) -> None:
        """Queue one warning for each reason that forbids arming."""
        for reason in self.report.reasons:
            self._flight.events.report(Severity.WARNING, f"Preflight fail: {reason}")

    def _tell_changes(self, before: Health) -> None:
        """Report sensors that have fallen silent or repeat themselves, and recovered ones."""
        for name, title in _TOLD.items():
            was_ok, is_ok = getattr(before, name), getattr(self.health, name)
            if was_ok and not is_ok:
                # Only a sensor that was reported as lost is reported as regained: at the start none
                # is.
                self._lost.add(name)
                self._flight.events.report(Severity.WARNING, f"{title} lost")
            elif is_ok and name in self._lost:
                self._lost.remove(name)
                self._flight.events.report(Severity.INFO, f"{title} regained")

    def _delivers(self, sensor: Sensor) -> bool:
        now_us = self._flight.vehicle.time_us
        return self._plant.sensors.is_delivering(sensor, now_us, _STALE_US)

    def _health(self, *, is_armable: bool) -> Health:
        flight, vehicle = self._flight, self._flight.vehicle
        return Health(
            is_imu_ok=self._delivers(IMU) and vehicle.is_imu_ok,
            is_mag_ok=self._delivers(MAGNETOMETER),
            is_baro_ok=self._delivers(BAROMETER),
            is_gnss_ok=self._has_fix(),
            is_rangefinder_ok=self._delivers(RANGEFINDER) and not isnan(vehicle.range_m),
            is_attitude_ok=vehicle.is_attitude_ok,
            is_position_ok=vehicle.is_position_ok,
            is_battery_ok=self._battery.warning < BatteryWarning.CRITICAL,
            is_geofence_on=flight.fence.is_enabled,
            is_geofence_ok=fence_breach(flight, vehicle.position_enu_m) is None,
            is_armable=is_armable,
        )

    def _has_fix(self) -> bool:
        return self._delivers(GNSS) and self._plant.sensors.gnss.fix_type >= _GNSS_FIX_3D

    def _reasons(self, mode: Mode) -> list[str]:
        flight, vehicle, p = self._flight, self._flight.vehicle, self._flight.parameters
        reasons = self._sensor_reasons()
        if not vehicle.is_attitude_ok:
            reasons.append("attitude estimate not valid")
        elif vehicle.cos_tilt < _MAX_TILT_COSINE:
            reasons.append("vehicle is tilted by more than 60 degrees")
        # Offboard is no position mode, because attitude setpoints need none. Arming asks for one.
        if not vehicle.is_position_ok and (mode in POSITION_MODES or mode is Mode.OFFBOARD):
            reasons.append("position estimate not valid")
        if self._battery.warning >= BatteryWarning.CRITICAL:
            reasons.append("battery too low")
        # GF_ACTION 0 and 1 ignore a breach or only warn of it.
        if p["GF_ACTION"] > 1 and fence_breach(flight, vehicle.position_enu_m):
            reasons.append("outside the geofence")
        if mode in _NOT_FOR_TAKEOFF:
            reasons.append(f"mode {mode.value} is not suitable for takeoff")
        if mode is Mode.MISSION and (obstacle := mission_obstacle(flight)):
            reasons.append(obstacle)
        if mode in THRUST_MODES:
            reasons.extend(self._stick_reasons())
        return reasons

    def _sensor_reasons(self) -> list[str]:
        has_imu = self._delivers(IMU) and self._flight.vehicle.is_imu_ok
        has_fix = self._flight.parameters["COM_ARM_WO_GPS"] != 0 or self._has_fix()
        needed = {
            "no inertial sensor": has_imu,
            "no barometer": self._delivers(BAROMETER),
            "no magnetometer": self._delivers(MAGNETOMETER),
            "no satellite fix": has_fix,
        }
        return [reason for reason, is_there in needed.items() if not is_there]

    def _stick_reasons(self) -> list[str]:
        sticks, now_us = self._flight.sticks, self._flight.vehicle.time_us
        if not sticks.is_alive(now_us):
            return ["no manual control"]
        if sticks.current(now_us).throttle > _LOW_THROTTLE:
            return ["throttle is not down"]
        return []
