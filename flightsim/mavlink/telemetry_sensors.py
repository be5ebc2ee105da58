"""Sensor telemetry: messages of sensors and the battery."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flightsim.autopilot.modes import BatteryWarning
from flightsim.frames import swap_enu_ned
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.view import VehicleView
from flightsim.sensors.optical_flow import OPTICAL_FLOW

_GPS_RAW_INT = layout(
    "GPS_RAW_INT",
    *("time_usec", "lat", "lon", "alt", "eph", "epv", "vel", "cog", "fix_type"),
    *("satellites_visible", "alt_ellipsoid", "h_acc", "v_acc", "vel_acc", "hdg_acc", "yaw"),
)
_OPTICAL_FLOW_RAD = layout("OPTICAL_FLOW_RAD")
_SCALED_PRESSURE = layout("SCALED_PRESSURE")
_BATTERY_STATUS = layout("BATTERY_STATUS")
_ESTIMATOR_STATUS = layout("ESTIMATOR_STATUS")
_VIBRATION = layout("VIBRATION")

_UNKNOWN_U16 = 0xFFFF
_CHARGE_STATES = {
    BatteryWarning.NONE: mav.MAV_BATTERY_CHARGE_STATE_OK,
    BatteryWarning.LOW: mav.MAV_BATTERY_CHARGE_STATE_LOW,
    BatteryWarning.CRITICAL: mav.MAV_BATTERY_CHARGE_STATE_CRITICAL,
    BatteryWarning.EMERGENCY: mav.MAV_BATTERY_CHARGE_STATE_EMERGENCY,
}


def _uint16(value: float) -> int:
    return max(0, min(0xFFFE, round(value))) if math.isfinite(value) else _UNKNOWN_U16


def _millimetres(value_m: float) -> int:
    return round(1e3 * value_m) if math.isfinite(value_m) else 0


class SensorTelemetry:
    """Packs messages from the latest readings."""

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self.producers: Mapping[str, Callable[[], bytes | None]] = {
            "GPS_RAW_INT": self._gps_raw,
            "SCALED_PRESSURE": self._pressure,
            "BATTERY_STATUS": self._battery,
            "ESTIMATOR_STATUS": self._estimator,
            "VIBRATION": self._vibration,
        }
        if view.plant.cfg.has(OPTICAL_FLOW.name):
            self.producers = {**self.producers, "OPTICAL_FLOW_RAD": self._flow}

    def _gps_raw(self) -> bytes:
        v = self._view
        gnss = v.plant.sensors.gnss
        place = v.frame.geodetic_from_enu(gnss.position_enu_m)
        vn, ve, _ = swap_enu_ned(gnss.velocity_enu_mps)
        altitude_mm = round(place.altitude_m * 1e3)
        course_deg = math.degrees(math.atan2(ve, vn)) % 360.0
        return _GPS_RAW_INT.pack(
            gnss.time_us,
            round(place.latitude_deg * 1e7),
            round(place.longitude_deg * 1e7),
            altitude_mm,
            _uint16(100.0 * gnss.eph_m),
            _uint16(100.0 * gnss.epv_m),
            _uint16(100.0 * math.hypot(vn, ve)),
            round(course_deg * 100.0) % 36000,
            gnss.fix_type,
            min(254, gnss.n_satellites),
            altitude_mm,
            _millimetres(gnss.eph_m),
            _millimetres(gnss.epv_m),
            0,
            0,
            0,
        )

    def _flow(self) -> bytes | None:
        """Report the flow of what passes below; none before the first sample."""
        flow = self._view.plant.sensors.optical_flow
        if flow.integration_us == 0:
            return None
        x, y = flow.flow_frd_rad
        about_x, about_y, about_z = flow.gyro_frd_rad
        return _OPTICAL_FLOW_RAD.encode(
            time_usec=flow.time_us,
            sensor_id=0,
            integration_time_us=flow.integration_us,
            integrated_x=x,
            integrated_y=y,
            integrated_xgyro=about_x,
            integrated_ygyro=about_y,
            integrated_zgyro=about_z,
            quality=flow.quality,
            time_delta_distance_us=0,
            distance=flow.distance_m if math.isfinite(flow.distance_m) else -1.0,
        )

    def _pressure(self) -> bytes:
        v = self._view
        baro, airspeed = v.plant.sensors.baro, v.plant.sensors.airspeed
        return _SCALED_PRESSURE.encode(
            time_boot_ms=v.time_boot_ms,
            press_abs=baro.pressure_pa * 0.01,
            press_diff=airspeed.differential_pa * 0.01,
            temperature=round(100.0 * baro.temperature_degc),
            temperature_press_diff=round(100.0 * airspeed.temperature_degc),
        )

    def _battery(self) -> bytes:
        battery = self._view.autopilot.battery
        millivolts = max(0, round(1e3 * battery.voltage_v))
        cells = max(1, min(10, battery.n_cells))
        return _BATTERY_STATUS.encode(
            battery_function=mav.MAV_BATTERY_FUNCTION_ALL,
            type=mav.MAV_BATTERY_TYPE_LIPO,
            temperature=0x7FFF,
            voltages=[millivolts // cells] * cells + [_UNKNOWN_U16] * (10 - cells),
            current_battery=max(-1, min(0x7FFF, round(100.0 * battery.current_a))),
            current_consumed=round(battery.consumed_mah),
            energy_consumed=-1,
            battery_remaining=max(0, min(100, round(100.0 * battery.remaining))),
            charge_state=_CHARGE_STATES[battery.warning],
        )

    def _estimator(self) -> bytes:
        v = self._view
        estimator = v.plant.estimator
        flags = mav.ESTIMATOR_ATTITUDE if estimator.is_attitude_valid else 0
        # velocities, positions relative and absolute, height above ground, and their predictions
        flags |= 0b11_0111_1110 if estimator.is_position_valid else 0
        return _ESTIMATOR_STATUS.encode(
            time_usec=v.time_us,
            flags=flags,
            vel_ratio=estimator.gnss_velocity_ratio,
            pos_horiz_ratio=estimator.gnss_position_ratio,
            pos_vert_ratio=estimator.baro_ratio,
            mag_ratio=estimator.heading_ratio,
            pos_horiz_accuracy=estimator.sigma_horizontal_m,
            pos_vert_accuracy=estimator.sigma_vertical_m,
        )

    def _vibration(self) -> bytes:
        return _VIBRATION.encode(time_usec=self._view.time_us)
