"""Sensor telemetry: messages of sensors and the battery."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flightsim.autopilot.modes import BatteryWarning
from flightsim.frames import swap_flu_frd
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.view import VehicleView
from flightsim.sensors.optical_flow import OPTICAL_FLOW

_OPTICAL_FLOW_RAD = layout("OPTICAL_FLOW_RAD")
_BATTERY_STATUS = layout("BATTERY_STATUS")
_SCALED_IMU = layout("SCALED_IMU")

_MILLI_G_PER_MPS2 = 1e3 / 9.80665
_MILLIGAUSS_PER_UT = 10.0
_LARGEST_I16 = 0x7FFF
_UNKNOWN_U16 = 0xFFFF
_CHARGE_STATES = {
    BatteryWarning.NONE: mav.MAV_BATTERY_CHARGE_STATE_OK,
    BatteryWarning.LOW: mav.MAV_BATTERY_CHARGE_STATE_LOW,
    BatteryWarning.CRITICAL: mav.MAV_BATTERY_CHARGE_STATE_CRITICAL,
    BatteryWarning.EMERGENCY: mav.MAV_BATTERY_CHARGE_STATE_EMERGENCY,
}


class SensorTelemetry:
    """Packs messages from the latest readings."""

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self.producers: Mapping[str, Callable[[], bytes | None]] = {
            "BATTERY_STATUS": self._battery,
            "SCALED_IMU": self._imu,
        }
        if view.plant.cfg.has(OPTICAL_FLOW.name):
            self.producers = {**self.producers, "OPTICAL_FLOW_RAD": self._flow}

    def _imu(self) -> bytes:
        """Report the inertial sensor and the magnetometer."""
        return _SCALED_IMU.encode(time_boot_ms=self._view.time_boot_ms, **imu_fields(self._view))

    def _flow(self) -> bytes | None:
        """Report the optical flow; none before the first sample."""
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
            # As MAVLink defines it, a negative distance is unknown.
            time_delta_distance_us=0,
            distance=flow.distance_m if math.isfinite(flow.distance_m) else -1.0,
        )

    def _battery(self) -> bytes:
        battery = self._view.autopilot.battery
        millivolts = max(0, round(1e3 * battery.voltage_v))
        cells = max(1, min(10, battery.n_cells))
        return _BATTERY_STATUS.encode(
            battery_function=mav.MAV_BATTERY_FUNCTION_ALL,
            type=mav.MAV_BATTERY_TYPE_LIPO,
            temperature=0x7FFF,
            # Cells are not measured one by one: each gets its share of the pack's voltage.
            voltages=[millivolts // cells] * cells + [_UNKNOWN_U16] * (10 - cells),
            current_battery=max(-1, min(0x7FFF, round(100.0 * battery.current_a))),
            current_consumed=round(battery.consumed_mah),
            energy_consumed=-1,
            battery_remaining=max(0, min(100, round(100.0 * battery.remaining))),
            charge_state=_CHARGE_STATES[battery.warning],
        )


def imu_fields(view: VehicleView) -> Mapping[str, int]:
    """Return the fields of SCALED_IMU and RAW_IMU.

    Units are thousandths of g, of rad/s and of gauss, and centidegrees.
    """
    sensors = view.plant.sensors
    accel, gyro = sensors.imu.accel_flu_mps2, sensors.imu.gyro_flu_radps
    readings = {
        "acc": [_MILLI_G_PER_MPS2 * value for value in swap_flu_frd(accel)],
        "gyro": [1e3 * value for value in swap_flu_frd(gyro)],
        "mag": [_MILLIGAUSS_PER_UT * value for value in swap_flu_frd(sensors.mag.field_flu_ut)],
    }
    fields = {
        f"{axis}{name}": _i16(value)
        for name, values in readings.items()
        for axis, value in zip("xyz", values, strict=True)
    }
    return {**fields, "temperature": _i16(100.0 * sensors.baro.temperature_degc)}


def _i16(value: float) -> int:
    """Return the nearest whole number that a signed 16-bit field holds."""
    return round(max(-_LARGEST_I16, min(_LARGEST_I16, value)))
