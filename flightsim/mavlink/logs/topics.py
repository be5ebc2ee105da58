"""Content of a flight log: PX4's topics with the names and intervals of its default profile.

Names of topics and fields are those of PX4 v1.15 (`msg/*.msg`), intervals those of
`src/modules/logger/logged_topics.cpp`. Fields that say nothing about a simulated vehicle are left
out, which readers of ULog allow: they look fields up by name. Nothing here is the simulation's
truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from autonomy.types import ControlLevel, Vector3
from flightsim.autopilot.modes import BatteryWarning, LandedState, Mode
from flightsim.frames import (
    euler_rpy_rad,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
    swap_yaw_enu_ned,
)
from flightsim.mavlink.logs.ulog import Topic
from flightsim.mavlink.vehicle_type import vehicle_type
from flightsim.mavlink.view import VehicleView
from flightsim.sensors.sensor import numbers

Values = Sequence[float]

_demanded = numbers("rate_cmd_flu_radps", "thrust_fraction", "rotor_command_radps")
"""Reads body rates, collective thrust and rotor speeds that the controller demands now."""

# PX4's vehicle_status.msg, v1.15.
NAV_STATES = {
    Mode.MANUAL: 0,
    Mode.ALTITUDE: 1,
    Mode.POSITION: 2,
    Mode.MISSION: 3,
    Mode.HOLD: 4,
    Mode.RETURN: 5,
    Mode.ACRO: 10,
    Mode.DESCEND: 12,
    Mode.TERMINATION: 13,
    Mode.OFFBOARD: 14,
    Mode.STABILIZED: 15,
    Mode.TAKEOFF: 17,
    Mode.LAND: 18,
    Mode.FOLLOW: 19,
    Mode.PRECISION_LAND: 20,
    Mode.ORBIT: 21,
}
_WARNINGS = {
    BatteryWarning.NONE: 0,
    BatteryWarning.LOW: 1,
    BatteryWarning.CRITICAL: 2,
    BatteryWarning.EMERGENCY: 3,
}
_ARMED = 2  # arming_state of vehicle_status
_N_OUTPUTS, _N_MOTORS = 16, 12
_GAUSS_PER_UT = 0.01
_AIR_J_PER_KG_K = 287.1  # gas constant of dry air
_ZERO_DEGC_K = 273.15
_IDLE_PWM, _RANGE_PWM = 1000.0, 1000.0


@dataclass(frozen=True, slots=True)
class Logged:
    """A topic of the log, the interval between samples, and its values at a time."""

    topic: Topic
    interval_ms: int
    sample: Callable[[VehicleView], Values]


def _ned(vector_enu: Vector3) -> Vector3:
    return swap_enu_ned(vector_enu)


def _yaw_ned(yaw_rad: float) -> float:
    return math.nan if math.isnan(yaw_rad) else swap_yaw_enu_ned(yaw_rad)


def _position(v: VehicleView) -> Values:
    status, origin = v.plant.estimator, v.origin
    quat = v.quat_ned_frd
    ground_m = v.plant.terrain_height_est_m
    # Height over the estimated terrain, as PX4's dist_bottom.
    above_m = v.plant.estimate.position_enu_m[2] - ground_m
    return (
        *(v.time_us, v.time_us, origin.latitude_deg, origin.longitude_deg),
        *(*v.position_ned_m, *v.velocity_ned_mps, v.velocity_ned_mps[2]),
        *(euler_rpy_rad(quat)[2], origin.altitude_m, above_m),
        *(status.sigma_horizontal_m, status.sigma_vertical_m),
        *(status.sigma_velocity_mps, status.sigma_velocity_mps),
        *(status.is_position_valid,) * 4,
        not math.isnan(above_m),
    )


def _position_setpoint(v: VehicleView) -> Values:
    s = v.autopilot.setpoint
    # Other levels have no position setpoint, which NaN marks.
    if s.level is not ControlLevel.TRAJECTORY:
        return (math.nan,) * 14
    # An axis without set point is NaN, which the change of frames keeps.
    position = v.ned_from_enu(s.position_enu_m)
    thrust = v.plant.collective_thrust_fraction
    return (
        *(*position, *_ned(s.velocity_enu_mps), _yaw_ned(s.yaw_rad), -s.yaw_rate_radps),
        *(*_ned(s.acceleration_enu_mps2), 0.0, 0.0, -thrust),
    )


def _trajectory_setpoint(v: VehicleView) -> Values:
    s = v.autopilot.setpoint
    if s.level is not ControlLevel.TRAJECTORY:
        return (math.nan,) * 14
    # An axis without set point is NaN, which the change of frames keeps.
    position = v.ned_from_enu(s.position_enu_m)
    derivatives = (s.velocity_enu_mps, s.acceleration_enu_mps2, s.jerk_enu_mps3)
    ned = [value for vector in derivatives for value in _ned(vector)]
    return (*position, *ned, _yaw_ned(s.yaw_rad), -s.yaw_rate_radps)


def _attitude_setpoint(v: VehicleView) -> Values:
    wxyz = np.zeros(4)
    mujoco.mju_mat2Quat(wxyz, v.plant.controller["R_cmd"].ravel())
    w, x, y, z = wxyz.tolist()
    thrust, s = v.plant.collective_thrust_fraction, v.autopilot.setpoint
    return (-s.yaw_rate_radps, *swap_quat_enu_flu_ned_frd((w, x, y, z)), 0.0, 0.0, -thrust)


def _rates_setpoint(v: VehicleView) -> Values:
    rates, thrust, _ = _demanded(v.plant.controller)
    return (*swap_flu_frd(rates), 0.0, 0.0, -thrust)


def _shares(v: VehicleView) -> list[float]:
    """Commanded speeds over the greatest, in the order of the motors' numbers."""
    airframe, (_, _, speeds) = v.plant.world.airframe, _demanded(v.plant.controller)
    rotors = airframe.quadrotor.rotors
    return [speeds[k] / rotors[k].max_speed_radps for k in airframe.motors]


def _outputs(v: VehicleView) -> Values:
    shares = _shares(v)
    pulses = [_IDLE_PWM + _RANGE_PWM * share for share in shares]
    return (len(shares), *pulses, *(0.0,) * (_N_OUTPUTS - len(shares)))


def _motors(v: VehicleView) -> Values:
    # A rotor's thrust grows with the square of its speed, and this topic holds thrusts.
    thrusts = [share * share for share in _shares(v)]
    return (v.time_us, *thrusts, *(math.nan,) * (_N_MOTORS - len(thrusts)), 0)


def _gps(v: VehicleView) -> Values:
    gnss = v.plant.sensors.gnss
    place = v.frame.geodetic_from_enu(gnss.position_enu_m)
    north, east, down = _ned(gnss.velocity_enu_mps)
    return (
        *(v.time_us, place.latitude_deg, place.longitude_deg),
        *(place.altitude_m, place.altitude_m),
        *(gnss.eph_m, gnss.epv_m, math.hypot(north, east), north, east, down),
        *(math.atan2(east, north), gnss.fix_type, min(255, gnss.n_satellites), True),
    )


def _estimator(v: VehicleView) -> Values:
    s, is_known = v.plant.estimator, v.plant.estimator.is_position_valid
    position, velocity = s.gnss_position_ratio, s.gnss_velocity_ratio
    # attitude, velocity horizontal and vertical, position relative, absolute, vertical absolute
    flags = (1 if s.is_attitude_valid else 0) | (0b111110 if is_known else 0)
    return (
        *(v.time_us, s.sigma_horizontal_m, s.sigma_vertical_m),
        *(s.heading_ratio, velocity, position, s.baro_ratio, flags),
    )


def _battery(v: VehicleView) -> Values:
    b = v.autopilot.battery
    return (
        *(b.voltage_v, b.current_a, b.current_a, b.consumed_mah, b.remaining),
        *(b.n_cells, _WARNINGS[b.warning], True),
    )


def _status(v: VehicleView) -> Values:
    autopilot = v.autopilot
    return (
        *(autopilot.armed_at_us or 0, autopilot.took_off_at_us or 0),
        *(_ARMED, NAV_STATES[autopilot.mode], vehicle_type(v.plant.world.airframe)),
        *(int(v.autopilot.parameters["MAV_SYS_ID"]), 1, 1, autopilot.failsafe is not None),
    )


def _landed(v: VehicleView) -> Values:
    is_landed = v.autopilot.landed_state is LandedState.ON_GROUND
    return (False, is_landed, is_landed, is_landed)


def _air(v: VehicleView) -> Values:
    baro = v.plant.sensors.baro
    density = baro.pressure_pa / (_AIR_J_PER_KG_K * (baro.temperature_degc + _ZERO_DEGC_K))
    numbers = (baro.altitude_m, baro.temperature_degc, baro.pressure_pa, density)
    return (baro.time_us, *numbers)


def _magnetometer(v: VehicleView) -> Values:
    mag = v.plant.sensors.mag
    return (mag.time_us, *(_GAUSS_PER_UT * value for value in swap_flu_frd(mag.field_flu_ut)))


def _wind(v: VehicleView) -> Values:
    east, north = v.plant.wind_est_enu_mps
    return (north, east)


def _acceleration(v: VehicleView) -> Values:
    return swap_flu_frd(v.plant.sensors.imu.accel_flu_mps2)


def _floats(names: str) -> tuple[str, ...]:
    return tuple(f"float {name}" for name in names.split())


LOGGED = (
    Logged(
        Topic(
            "vehicle_local_position",
            *("uint64_t timestamp_sample", "uint64_t ref_timestamp"),
            *("double ref_lat", "double ref_lon"),
            *_floats("x y z vx vy vz z_deriv heading ref_alt dist_bottom eph epv evh evv"),
            *(f"bool {name}_valid" for name in ("xy", "z", "v_xy", "v_z", "dist_bottom")),
        ),
        100,
        _position,
    ),
    Logged(
        Topic(
            "vehicle_local_position_setpoint",
            *_floats("x y z vx vy vz yaw yawspeed"),
            *("float[3] acceleration", "float[3] thrust"),
        ),
        100,
        _position_setpoint,
    ),
    Logged(
        Topic(
            "trajectory_setpoint",
            *(f"float[3] {name}" for name in ("position", "velocity", "acceleration", "jerk")),
            *_floats("yaw yawspeed"),
        ),
        200,
        _trajectory_setpoint,
    ),
    Logged(
        Topic("vehicle_attitude", "uint64_t timestamp_sample", "float[4] q"),
        50,
        lambda v: (v.time_us, *v.quat_ned_frd),
    ),
    Logged(
        Topic(
            "vehicle_attitude_setpoint",
            *("float yaw_sp_move_rate", "float[4] q_d", "float[3] thrust_body"),
        ),
        50,
        _attitude_setpoint,
    ),
    Logged(
        Topic("vehicle_angular_velocity", "uint64_t timestamp_sample", "float[3] xyz"),
        20,
        lambda v: (v.time_us, *v.rates_frd_radps),
    ),
    Logged(
        Topic("vehicle_rates_setpoint", *_floats("roll pitch yaw"), "float[3] thrust_body"),
        20,
        _rates_setpoint,
    ),
    Logged(Topic("vehicle_acceleration", "float[3] xyz"), 50, _acceleration),
    Logged(
        Topic("actuator_outputs", "uint32_t noutputs", f"float[{_N_OUTPUTS}] output"),
        100,
        _outputs,
    ),
    Logged(
        Topic(
            "actuator_motors",
            *("uint64_t timestamp_sample", f"float[{_N_MOTORS}] control"),
            "uint16_t reversible_flags",
        ),
        100,
        _motors,
    ),
    Logged(
        Topic(
            "vehicle_gps_position",
            *("uint64_t timestamp_sample", "double latitude_deg", "double longitude_deg"),
            *("double altitude_msl_m", "double altitude_ellipsoid_m"),
            *_floats("eph epv vel_m_s vel_n_m_s vel_e_m_s vel_d_m_s cog_rad"),
            *("uint8_t fix_type", "uint8_t satellites_used", "bool vel_ned_valid"),
        ),
        100,
        _gps,
    ),
    Logged(
        Topic(
            "estimator_status",
            "uint64_t timestamp_sample",
            *_floats("pos_horiz_accuracy pos_vert_accuracy hdg_test_ratio vel_test_ratio"),
            *_floats("pos_test_ratio hgt_test_ratio"),
            "uint16_t solution_status_flags",
        ),
        200,
        _estimator,
    ),
    Logged(
        Topic(
            "battery_status",
            *_floats("voltage_v current_a current_average_a discharged_mah remaining"),
            *("uint8_t cell_count", "uint8_t warning", "bool connected"),
        ),
        200,
        _battery,
    ),
    Logged(
        Topic(
            "vehicle_status",
            *("uint64_t armed_time", "uint64_t takeoff_time"),
            *(f"uint8_t {name}" for name in ("arming_state", "nav_state", "system_type")),
            *(f"uint8_t {name}" for name in ("system_id", "component_id", "vehicle_type")),
            "bool failsafe",
        ),
        500,
        _status,
    ),
    Logged(
        Topic(
            "vehicle_land_detected",
            *("bool freefall", "bool ground_contact", "bool maybe_landed", "bool landed"),
        ),
        100,
        _landed,
    ),
    Logged(
        Topic(
            "vehicle_air_data",
            "uint64_t timestamp_sample",
            *_floats("baro_alt_meter baro_temp_celcius baro_pressure_pa rho"),
        ),
        200,
        _air,
    ),
    Logged(
        Topic("vehicle_magnetometer", "uint64_t timestamp_sample", "float[3] magnetometer_ga"),
        200,
        _magnetometer,
    ),
    Logged(Topic("wind", *_floats("windspeed_north windspeed_east")), 1000, _wind),
)
"""Topics that are sampled at ticks of the autopilot; the position is the message id."""

SENSOR_COMBINED = Topic(
    "sensor_combined",
    *("float[3] gyro_rad", "uint32_t gyro_integral_dt", "float[3] accelerometer_m_s2"),
    *("uint32_t accelerometer_integral_dt", "int32_t accelerometer_timestamp_relative"),
    "uint8_t accelerometer_clipping",
)
"""Every sample of the inertial sensor, as PX4 logs it."""
_COMBINED_DTYPE = np.dtype(
    [
        *(("size", "<u2"), ("kind", "u1"), ("id", "<u2"), ("time_us", "<u8")),
        *(("gyro", "<f4", 3), ("gyro_dt", "<u4"), ("accel", "<f4", 3), ("accel_dt", "<u4")),
        *(("relative_us", "<i4"), ("clipping", "u1")),
    ]
)
# Body axes are mirrored: y to the right, z down.
_FRD_FROM_FLU = np.array([1.0, -1.0, -1.0])


class InertialPacker:
    """Packs `sensor_combined` for the control ticks of each advance.

    All of them in one call of numpy: 250 samples a second would cost too much one by one.
    """

    def __init__(self, message_id: int, history: np.ndarray, tick_us: int) -> None:
        """Prepare the messages.

        Args:
            message_id: Id of the topic in the file.
            history: `flightsim.plant.record.HISTORY_DTYPE` (k,), which each advance writes anew.
            tick_us: Time between two ticks.
        """
        self._rows = rows = np.zeros(len(history), _COMBINED_DTYPE)
        # ULog does not count the three bytes of a message's header.
        rows["size"], rows["kind"], rows["id"] = SENSOR_COMBINED.size - 3, ord("D"), message_id
        rows["gyro_dt"] = rows["accel_dt"] = tick_us
        # Views into both arrays, made once: this is done fifty times a second.
        self._to = (rows["time_us"], rows["gyro"], rows["accel"])
        self._from = tuple(history[f] for f in ("time_us", "gyro_flu_radps", "accel_flu_mps2"))

    def pack(self) -> bytes:
        """Return the data messages of the last advance."""
        (to_time, to_gyro, to_accel), (time_us, gyro, accel) = self._to, self._from
        to_time[:] = time_us
        np.multiply(gyro, _FRD_FROM_FLU, out=to_gyro, casting="same_kind")
        np.multiply(accel, _FRD_FROM_FLU, out=to_accel, casting="same_kind")
        return self._rows.tobytes()
