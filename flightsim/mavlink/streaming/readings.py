"""Messages of sensors and motors, filled from the plant's record."""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from flightsim.mavlink.streaming.motion import centi

MIN_RANGE_CM, MAX_RANGE_CM = 10, 3000
# Pulse widths in us: stopped while disarmed, idle, and the range above it.
_PWM_STOPPED, _PWM_IDLE, _PWM_SPAN = 900.0, 1000.0, 1000.0


@kernel
def fill_readings(m: np.record, p: np.record, v: np.record) -> None:
    """Fill the messages of pressure, range and motor commands.

    Args:
        m: `VALUES_DTYPE`, changed.
        p: `PLANT_DTYPE`.
        v: `VIEW_DTYPE` of the same tick.
    """
    _fill_pressure(m.SCALED_PRESSURE, p, v)
    _fill_range(m.DISTANCE_SENSOR, p.range.range_m, v)
    _fill_motors(m.SERVO_OUTPUT_RAW, p.controller.rotor_command_radps, v)


@kernel
def fill_imu(m: np.record, p: np.record, v: np.record) -> None:
    """Fill HIGHRES_IMU."""
    accel, gyro, field = p.imu.accel_flu_mps2, p.imu.gyro_flu_radps, p.mag.field_flu_ut
    m.is_known = 1.0
    m.time_usec = v.time_us
    m.xacc, m.yacc, m.zacc = accel[0], -accel[1], -accel[2]
    m.xgyro, m.ygyro, m.zgyro = gyro[0], -gyro[1], -gyro[2]
    m.xmag, m.ymag, m.zmag = field[0] * 0.01, -field[1] * 0.01, -field[2] * 0.01  # gauss
    m.abs_pressure = p.baro.pressure_pa * 0.01
    m.diff_pressure = p.airspeed.differential_pa * 0.01
    m.pressure_alt, m.temperature = p.baro.altitude_m, p.baro.temperature_degc


@kernel
def _fill_pressure(m: np.record, p: np.record, v: np.record) -> None:
    m.is_known = 1.0
    m.time_boot_ms = v.time_boot_ms
    m.press_abs, m.press_diff = p.baro.pressure_pa * 0.01, p.airspeed.differential_pa * 0.01  # hPa
    m.temperature = centi(p.baro.temperature_degc)
    m.temperature_press_diff = centi(p.airspeed.temperature_degc)


@kernel
def _fill_range(m: np.record, range_m: float, v: np.record) -> None:
    m.is_known = 1.0
    m.time_boot_ms = v.time_boot_ms
    is_valid = math.isfinite(range_m)
    # One centimetre beyond the range means that nothing was met.
    distance_cm = np.rint(100.0 * range_m) if is_valid else MAX_RANGE_CM + 1.0
    m.current_distance = max(0.0, min(MAX_RANGE_CM + 1.0, distance_cm))
    m.signal_quality = 100.0 if is_valid else 1.0


@kernel
def _fill_motors(m: np.record, command_radps: np.ndarray, v: np.record) -> None:
    m.is_known = 1.0
    m.time_usec = int(v.time_us) & 0xFFFFFFFF
    # Field by field: kernels cannot reach a record's fields by a computed name.
    m.servo1_raw = _pulse(0, command_radps, v)
    m.servo2_raw = _pulse(1, command_radps, v)
    m.servo3_raw = _pulse(2, command_radps, v)
    m.servo4_raw = _pulse(3, command_radps, v)
    m.servo5_raw = _pulse(4, command_radps, v)
    m.servo6_raw = _pulse(5, command_radps, v)
    m.servo7_raw = _pulse(6, command_radps, v)
    m.servo8_raw = _pulse(7, command_radps, v)
    m.servo9_raw = _pulse(8, command_radps, v)
    m.servo10_raw = _pulse(9, command_radps, v)
    m.servo11_raw = _pulse(10, command_radps, v)
    m.servo12_raw = _pulse(11, command_radps, v)


@kernel
def _pulse(motor: int, command_radps: np.ndarray, v: np.record) -> float:
    """Return the width of a motor's pulse in us, 0 if there is no such motor."""
    if motor >= v.n_motors:
        return 0.0
    speed_radps = command_radps[v.motors[motor]]
    if v.is_armed == 0 and not speed_radps > 0.0:
        return _PWM_STOPPED
    return _PWM_IDLE + np.rint(_PWM_SPAN * (speed_radps / v.most_radps))
