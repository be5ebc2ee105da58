"""Messages of the estimate, the setpoint and the truth, filled from the plant's record.

The meaning of each field is MAVLink's; `look` is `flightsim.frames` for kernels.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from autonomy.types import ControlLevel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.plant.mujoco_calls import doubles

FULL_TURN_CENTIDEG = 36000.0  # MAVLink's headings are 0 to 35,999 hundredths of a degree
_TRAJECTORY, _ATTITUDE_LEVEL = float(ControlLevel.TRAJECTORY), float(ControlLevel.ATTITUDE)
_STANDARD_GRAVITY_MPS2 = 9.80665  # unit of "mG" in HIL_STATE_QUATERNION
_HALF_SQRT_2 = math.sqrt(0.5)
_IGNORE_VELOCITY, _IGNORE_ACCELERATION = 7 << 3, 7 << 6
_IGNORE_YAW = mav.POSITION_TARGET_TYPEMASK_YAW_IGNORE
_IGNORE_YAW_RATE = mav.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
_MOST_WAYPOINT_M = 65535.0  # wp_dist has 16 bits


@kernel
def look(v: np.record, p: np.record, now_us: int) -> None:
    """Convert the estimate of the present tick into MAVLink's frames.

    Args:
        v: `VIEW_DTYPE`, changed.
        p: `PLANT_DTYPE`.
        now_us: Simulated time.
    """
    f = p.filter
    v.time_us = now_us
    v.time_boot_ms = now_us // 1000 & 0xFFFFFFFF
    _ned_of(f.position_enu_m, v.origin_enu_m, v.position_ned_m)
    _swap_world(f.velocity_enu_mps, v.velocity_ned_mps)
    _swap_body(f.angular_rate_flu_radps, v.rates_frd_radps)
    _swap_attitude(f.quat_wxyz, v.quat_ned_frd)
    w, x, y, z = v.quat_ned_frd[0], v.quat_ned_frd[1], v.quat_ned_frd[2], v.quat_ned_frd[3]
    v.rpy_rad[0] = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    # Rounding may push the sine beyond 1, where asin is not defined.
    v.rpy_rad[1] = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    v.rpy_rad[2] = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    v.heading_deg = math.degrees(v.rpy_rad[2]) % 360.0
    v.latitude_est_deg, v.longitude_est_deg, v.altitude_est_m = place_of(v, f.position_enu_m)


@kernel
def fill_pose(m: np.record, p: np.record, v: np.record) -> None:
    """Fill the messages of position and attitude.

    Args:
        m: `VALUES_DTYPE`, changed.
        p: `PLANT_DTYPE`.
        v: `VIEW_DTYPE` of the same tick.
    """
    _fill_attitude(m.ATTITUDE, m.ATTITUDE_QUATERNION, p, v)
    _fill_position(m.LOCAL_POSITION_NED, m.GLOBAL_POSITION_INT, p, v)
    _fill_odometry(m.ODOMETRY, p, v)


@kernel
def fill_course(m: np.record, p: np.record, v: np.record) -> None:
    """Fill the messages of the setpoint, the flight instruments, and the truth.

    Args:
        m: `VALUES_DTYPE`, changed.
        p: `PLANT_DTYPE`.
        v: `VIEW_DTYPE` of the same tick.
    """
    _fill_attitude_target(m.ATTITUDE_TARGET, p, v)
    _fill_flight(m.VFR_HUD, m.ALTITUDE, p, v)
    _fill_local_target(m.POSITION_TARGET_LOCAL_NED, p, v)
    _fill_target(m.POSITION_TARGET_GLOBAL_INT, m.NAV_CONTROLLER_OUTPUT, p, v)
    _fill_truth(m.HIL_STATE_QUATERNION, p, v)


@kernel
def _fill_attitude(euler: np.record, quat: np.record, p: np.record, v: np.record) -> None:
    rates, q = v.rates_frd_radps, v.quat_ned_frd
    euler.is_known = quat.is_known = p.filter.is_aligned
    euler.time_boot_ms = quat.time_boot_ms = v.time_boot_ms
    euler.roll, euler.pitch, euler.yaw = v.rpy_rad[0], v.rpy_rad[1], v.rpy_rad[2]
    euler.rollspeed, euler.pitchspeed, euler.yawspeed = rates[0], rates[1], rates[2]
    quat.q1, quat.q2, quat.q3, quat.q4 = q[0], q[1], q[2], q[3]
    quat.rollspeed, quat.pitchspeed, quat.yawspeed = rates[0], rates[1], rates[2]


@kernel
def _fill_attitude_target(m: np.record, p: np.record, v: np.record) -> None:
    s = p.setpoint
    m.is_known = p.filter.is_aligned
    m.time_boot_ms = v.time_boot_ms
    # Without an attitude setpoint the present attitude is reported, with the demanded rates.
    if s.level == _ATTITUDE_LEVEL:
        _swap_attitude(s.quat_wxyz, m.q)
    else:
        for i in range(4):
            m.q[i] = v.quat_ned_frd[i]
    rate = s.angular_rate_flu_radps
    m.body_roll_rate, m.body_pitch_rate = rate[0], -rate[1]
    m.body_yaw_rate, m.thrust = -rate[2], p.controller.thrust_fraction


@kernel
def _fill_position(local: np.record, place: np.record, p: np.record, v: np.record) -> None:
    x, velocity = v.position_ned_m, v.velocity_ned_mps
    local.is_known = place.is_known = p.filter.is_aligned
    local.time_boot_ms = place.time_boot_ms = v.time_boot_ms
    local.x, local.y, local.z = x[0], x[1], x[2]
    local.vx, local.vy, local.vz = velocity[0], velocity[1], velocity[2]
    place.lat = np.rint(v.latitude_est_deg * 1e7)
    place.lon = np.rint(v.longitude_est_deg * 1e7)
    place.alt = np.rint(v.altitude_est_m * 1e3)
    place.relative_alt = np.rint((v.altitude_est_m - v.home_altitude_m) * 1e3)
    place.vx, place.vy, place.vz = centi(velocity[0]), centi(velocity[1]), centi(velocity[2])
    place.hdg = np.rint(v.heading_deg * 100.0) % FULL_TURN_CENTIDEG


@kernel
def _fill_odometry(m: np.record, p: np.record, v: np.record) -> None:
    m.is_known = p.filter.is_aligned
    m.time_usec = v.time_us
    m.x, m.y, m.z = v.position_ned_m[0], v.position_ned_m[1], v.position_ned_m[2]
    for i in range(4):
        m.q[i] = v.quat_ned_frd[i]
    m.rollspeed, m.pitchspeed = v.rates_frd_radps[0], v.rates_frd_radps[1]
    # ODOMETRY's velocity is in the body frame, unlike that of LOCAL_POSITION_NED.
    m.yawspeed = v.rates_frd_radps[2]
    w, x, y, z = v.quat_ned_frd[0], v.quat_ned_frd[1], v.quat_ned_frd[2], v.quat_ned_frd[3]
    a, b, c = v.velocity_ned_mps[0], v.velocity_ned_mps[1], v.velocity_ned_mps[2]
    # t = 2 v x u, v' = v + w t + t x u with u the vector part: rotation by the conjugate.
    tx, ty, tz = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    m.vx = a + w * tx + ty * z - tz * y
    m.vy = b + w * ty + tz * x - tx * z
    m.vz = c + w * tz + tx * y - ty * x


@kernel
def _fill_flight(hud: np.record, height: np.record, p: np.record, v: np.record) -> None:
    """Fill VFR_HUD and ALTITUDE."""
    hud.is_known = height.is_known = p.filter.is_aligned
    velocity, altitude_m = v.velocity_ned_mps, v.altitude_est_m
    hud.airspeed = max(0.0, p.airspeed.indicated_mps)  # as with PX4, never negative
    hud.groundspeed = math.hypot(velocity[0], velocity[1])
    hud.alt, hud.climb = altitude_m, -velocity[2]
    hud.heading = np.rint(v.heading_deg) % 360.0
    hud.throttle = within(np.rint(100.0 * p.controller.thrust_fraction), 0.0, 100.0)
    clearance_m = p.filter.position_enu_m[2] - p.filter.terrain_height_m
    height.time_usec = v.time_us
    height.altitude_monotonic = height.altitude_amsl = altitude_m
    height.altitude_local = -v.position_ned_m[2]
    height.altitude_relative = altitude_m - v.home_altitude_m
    height.altitude_terrain, height.bottom_clearance = altitude_m - clearance_m, clearance_m


@kernel
def _fill_local_target(m: np.record, p: np.record, v: np.record) -> None:
    s = p.setpoint
    # Other levels have no position target.
    m.is_known = p.filter.is_aligned == 1 and s.level == _TRAJECTORY
    x, y, z = s.position_enu_m[0], s.position_enu_m[1], s.position_enu_m[2]
    m.time_boot_ms = v.time_boot_ms
    m.x, m.y = y - v.origin_enu_m[1], x - v.origin_enu_m[0]
    m.z = v.origin_enu_m[2] - z
    velocity, acceleration = s.velocity_enu_mps, s.acceleration_enu_mps2
    m.vx, m.vy, m.vz = velocity[1], velocity[0], -velocity[2]
    m.afx, m.afy, m.afz = acceleration[1], acceleration[0], -acceleration[2]
    # Three bits each for position, velocity and acceleration that are free.
    mask = _ignored(m.x, m.y, m.z) | _ignored(m.vx, m.vy, m.vz) << 3
    mask |= _ignored(m.afx, m.afy, m.afz) << 6
    m.yaw, of_yaw = _yaw_and_mask(s.yaw_rad)
    m.yaw_rate = -s.yaw_rate_radps
    m.type_mask = mask | of_yaw


@kernel
def _fill_target(place: np.record, nav: np.record, p: np.record, v: np.record) -> None:
    """Fill POSITION_TARGET_GLOBAL_INT and NAV_CONTROLLER_OUTPUT."""
    target = v.target_enu_m
    is_there = math.isfinite(target[0]) and math.isfinite(target[1]) and math.isfinite(target[2])
    place.is_known = nav.is_known = p.filter.is_aligned == 1 and is_there
    if not is_there:
        return
    latitude_deg, longitude_deg, altitude_m = place_of(v, target)
    place.time_boot_ms = v.time_boot_ms
    place.lat_int, place.lon_int = np.rint(latitude_deg * 1e7), np.rint(longitude_deg * 1e7)
    place.alt = altitude_m
    place.yaw, of_yaw = _yaw_and_mask(p.setpoint.yaw_rad)
    place.type_mask = _IGNORE_VELOCITY | _IGNORE_ACCELERATION | _IGNORE_YAW_RATE | of_yaw
    north = target[1] - v.origin_enu_m[1] - v.position_ned_m[0]
    east = target[0] - v.origin_enu_m[0] - v.position_ned_m[1]
    nav.nav_roll, nav.nav_pitch = math.degrees(v.rpy_rad[0]), math.degrees(v.rpy_rad[1])
    nav.alt_error = v.position_ned_m[2] - (v.origin_enu_m[2] - target[2])
    nav.nav_bearing = nav.target_bearing = np.rint(math.degrees(math.atan2(east, north)))
    nav.wp_dist = min(_MOST_WAYPOINT_M, np.rint(math.hypot(north, east)))


@kernel
def _fill_truth(m: np.record, p: np.record, v: np.record) -> None:
    qpos, qvel = doubles(p.engine.qpos_address, 7), doubles(p.engine.qvel_address, 6)
    air, accel = p.rotors.wind_enu_mps, p.imu.accel_flu_mps2
    m.is_known = 1.0
    m.time_usec = v.time_us
    _swap_attitude(qpos[3:7], m.attitude_quaternion)
    # qvel holds the velocity in the world and the rates in the body.
    m.rollspeed, m.pitchspeed, m.yawspeed = qvel[3], -qvel[4], -qvel[5]
    latitude_deg, longitude_deg, altitude_m = place_of(v, qpos[0:3])
    m.lat, m.lon = np.rint(latitude_deg * 1e7), np.rint(longitude_deg * 1e7)
    m.alt = np.rint(altitude_m * 1e3)
    m.vx, m.vy, m.vz = centi(qvel[1]), centi(qvel[0]), centi(-qvel[2])
    # The true airspeed: velocity relative to the wind at the vehicle.
    squares = (qvel[0] - air[0]) ** 2 + (qvel[1] - air[1]) ** 2 + (qvel[2] - air[2]) ** 2
    m.ind_airspeed = m.true_airspeed = centi(math.sqrt(squares))
    m.xacc, m.yacc, m.zacc = _milli_g(accel[0]), _milli_g(-accel[1]), _milli_g(-accel[2])


@kernel
def _ned_of(position_enu_m: np.ndarray, origin_enu_m: np.ndarray, out: np.ndarray) -> None:
    out[0] = position_enu_m[1] - origin_enu_m[1]
    out[1] = position_enu_m[0] - origin_enu_m[0]
    out[2] = origin_enu_m[2] - position_enu_m[2]


@kernel
def _swap_world(vector: np.ndarray, out: np.ndarray) -> None:
    out[0], out[1], out[2] = vector[1], vector[0], -vector[2]


@kernel
def _swap_body(vector: np.ndarray, out: np.ndarray) -> None:
    out[0], out[1], out[2] = vector[0], -vector[1], -vector[2]


@kernel
def _swap_attitude(quat_wxyz: np.ndarray, out: np.ndarray) -> None:
    """Convert FLU-to-ENU into FRD-to-NED, or back; w >= 0."""
    w, x, y, z = quat_wxyz[0], quat_wxyz[1], quat_wxyz[2], quat_wxyz[3]
    sign = 1.0 if _HALF_SQRT_2 * (w + z) >= 0 else -1.0
    out[0], out[1] = sign * (_HALF_SQRT_2 * (w + z)), sign * (_HALF_SQRT_2 * (x + y))
    out[2], out[3] = sign * (_HALF_SQRT_2 * (x - y)), sign * (_HALF_SQRT_2 * (w - z))


@kernel
def place_of(v: np.record, position_enu_m: np.ndarray) -> tuple[float, float, float]:
    """Return latitude and longitude in degrees, and altitude in metres, of a position."""
    return (
        v.latitude_deg + position_enu_m[1] / v.metres_per_degree_north,
        v.longitude_deg + position_enu_m[0] / v.metres_per_degree_east,
        v.altitude_m + position_enu_m[2],
    )


@kernel
def within(value: float, least: float, most: float) -> float:
    """Return a number moved into a range; NaN stays NaN."""
    if value < least:
        return least
    return min(value, most)


@kernel
def centi(value: float) -> float:
    """Return hundredths in 16 bits."""
    return within(np.rint(value * 100.0), -32768.0, 32767.0)


@kernel
def _milli_g(accel_mps2: float) -> float:
    return within(np.rint(1000.0 * accel_mps2 / _STANDARD_GRAVITY_MPS2), -32768.0, 32767.0)


@kernel
def _ignored(x: float, y: float, z: float) -> int:
    """Return type mask bits, one for each axis that is NaN."""
    return int(math.isnan(x)) | int(math.isnan(y)) << 1 | int(math.isnan(z)) << 2


@kernel
def _yaw_and_mask(yaw_enu_rad: float) -> tuple[float, int]:
    if math.isnan(yaw_enu_rad):
        return 0.0, _IGNORE_YAW
    # East is zero in ENU, north in NED; wrapped to (-pi, pi].
    swapped = math.pi / 2 - yaw_enu_rad
    return -((math.pi - swapped) % (2 * math.pi) - math.pi), 0
