"""Motion telemetry: position, velocity, attitude and setpoint messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from autonomy.types import ControlLevel, Quaternion, State
from flightsim.frames import swap_enu_ned, swap_flu_frd, swap_quat_enu_flu_ned_frd, swap_yaw_enu_ned
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.view import VehicleView

_STANDARD_GRAVITY_MPS2 = 9.80665  # unit of "mG" in HIL_STATE_QUATERNION

_ATTITUDE = layout(
    "ATTITUDE", "time_boot_ms", "roll", "pitch", "yaw", "rollspeed", "pitchspeed", "yawspeed"
)
_ATTITUDE_QUATERNION = layout(
    "ATTITUDE_QUATERNION",
    *("time_boot_ms", "q1", "q2", "q3", "q4", "rollspeed", "pitchspeed", "yawspeed"),
    "repr_offset_q",
)
_ATTITUDE_TARGET = layout(
    "ATTITUDE_TARGET",
    *("time_boot_ms", "q", "body_roll_rate", "body_pitch_rate", "body_yaw_rate", "thrust"),
    "type_mask",
)
_LOCAL_POSITION_NED = layout("LOCAL_POSITION_NED", "time_boot_ms", "x", "y", "z", "vx", "vy", "vz")
_GLOBAL_POSITION_INT = layout(
    "GLOBAL_POSITION_INT",
    *("time_boot_ms", "lat", "lon", "alt", "relative_alt", "vx", "vy", "vz", "hdg"),
)
_ODOMETRY = layout(
    "ODOMETRY",
    *("time_usec", "x", "y", "z", "q", "vx", "vy", "vz", "rollspeed", "pitchspeed", "yawspeed"),
    *("pose_covariance", "velocity_covariance", "frame_id", "child_frame_id"),
    *("reset_counter", "estimator_type", "quality"),
)
_VFR_HUD = layout("VFR_HUD", "airspeed", "groundspeed", "alt", "climb", "heading", "throttle")
_ALTITUDE = layout(
    "ALTITUDE",
    *("time_usec", "altitude_monotonic", "altitude_amsl", "altitude_local", "altitude_relative"),
    *("altitude_terrain", "bottom_clearance"),
)
_TARGET_LOCAL = layout(
    "POSITION_TARGET_LOCAL_NED",
    *("time_boot_ms", "x", "y", "z", "vx", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate"),
    *("type_mask", "coordinate_frame"),
)
_TARGET_GLOBAL = layout(
    "POSITION_TARGET_GLOBAL_INT",
    *("time_boot_ms", "lat_int", "lon_int", "alt", "vx", "vy", "vz", "afx", "afy", "afz"),
    *("yaw", "yaw_rate", "type_mask", "coordinate_frame"),
)
_NAV_OUTPUT = layout(
    "NAV_CONTROLLER_OUTPUT",
    *("nav_roll", "nav_pitch", "alt_error", "aspd_error", "xtrack_error", "nav_bearing"),
    *("target_bearing", "wp_dist"),
)
_HIL_STATE = layout("HIL_STATE_QUATERNION")

_IGNORE_VELOCITY, _IGNORE_ACCELERATION = 7 << 3, 7 << 6
_IGNORE_YAW = mav.POSITION_TARGET_TYPEMASK_YAW_IGNORE
_IGNORE_YAW_RATE = mav.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
_UNKNOWN_COVARIANCE = (math.nan, *(0.0,) * 20)
_REST_OF_ODOMETRY = (
    *_UNKNOWN_COVARIANCE,
    *_UNKNOWN_COVARIANCE,
    mav.MAV_FRAME_LOCAL_NED,
    mav.MAV_FRAME_BODY_FRD,
    0,
    mav.MAV_ESTIMATOR_TYPE_AUTOPILOT,
    100,
)


def _int16(value: float) -> int:
    return max(-32768, min(32767, round(value)))


def _centidegrees(heading_deg: float) -> int:
    return round(heading_deg * 100.0) % 36000


class MotionTelemetry:
    """Packs messages from the estimate and the setpoint."""

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        of_estimate: Mapping[str, Callable[[], bytes | None]] = {
            "ATTITUDE": self._attitude,
            "ATTITUDE_QUATERNION": self._attitude_quaternion,
            "ATTITUDE_TARGET": self._attitude_target,
            "LOCAL_POSITION_NED": self._local_position,
            "GLOBAL_POSITION_INT": self._global_position,
            "ODOMETRY": self._odometry,
            "VFR_HUD": self._vfr_hud,
            "ALTITUDE": self._altitude,
            "POSITION_TARGET_LOCAL_NED": self._target_local,
            "POSITION_TARGET_GLOBAL_INT": self._target_global,
            "NAV_CONTROLLER_OUTPUT": self._nav_output,
        }
        self.producers: Mapping[str, Callable[[], bytes | None]] = {
            name: self._once_estimated(pack) for name, pack in of_estimate.items()
        } | {"HIL_STATE_QUATERNION": self._ground_truth}

    def _once_estimated(self, pack: Callable[[], bytes | None]) -> Callable[[], bytes | None]:
        return lambda: pack() if self._view.has_estimate else None

    def _attitude(self) -> bytes:
        v = self._view
        return _ATTITUDE.pack(v.time_boot_ms, *v.rpy_rad, *v.rates_frd_radps)

    def _attitude_quaternion(self) -> bytes:
        v = self._view
        return _ATTITUDE_QUATERNION.pack(
            v.time_boot_ms, *v.quat_ned_frd, *v.rates_frd_radps, 0.0, 0.0, 0.0, 0.0
        )

    def _attitude_target(self) -> bytes:
        v = self._view
        setpoint = v.autopilot.setpoint
        quat: Quaternion = v.quat_ned_frd
        if setpoint.level is ControlLevel.ATTITUDE:
            quat = swap_quat_enu_flu_ned_frd(setpoint.quat_wxyz)
        rates = swap_flu_frd(setpoint.angular_rate_flu_radps)
        return _ATTITUDE_TARGET.pack(
            v.time_boot_ms, *quat, *rates, v.plant.collective_thrust_fraction, 0
        )

    def _local_position(self) -> bytes:
        v = self._view
        return _LOCAL_POSITION_NED.pack(v.time_boot_ms, *v.position_ned_m, *v.velocity_ned_mps)

    def _global_position(self) -> bytes:
        v = self._view
        vx, vy, vz = v.velocity_ned_mps
        place = v.place
        return _GLOBAL_POSITION_INT.pack(
            v.time_boot_ms,
            round(place.latitude_deg * 1e7),
            round(place.longitude_deg * 1e7),
            round(place.altitude_m * 1e3),
            round((place.altitude_m - v.home_altitude_m) * 1e3),
            _int16(vx * 100.0),
            _int16(vy * 100.0),
            _int16(vz * 100.0),
            _centidegrees(v.heading_deg),
        )

    def _odometry(self) -> bytes:
        v = self._view
        velocity_frd = _rotate_inverse(v.quat_ned_frd, v.velocity_ned_mps)
        return _ODOMETRY.pack(
            v.time_us,
            *v.position_ned_m,
            *v.quat_ned_frd,
            *velocity_frd,
            *v.rates_frd_radps,
            *_REST_OF_ODOMETRY,
        )

    def _vfr_hud(self) -> bytes:
        v = self._view
        vx, vy, vz = v.velocity_ned_mps
        ground_speed = math.hypot(vx, vy)
        throttle = round(100.0 * v.plant.collective_thrust_fraction)
        return _VFR_HUD.pack(
            # As PX4 has it: nothing flies backwards.
            max(0.0, v.plant.sensors.airspeed.indicated_mps),
            ground_speed,
            v.place.altitude_m,
            -vz,
            round(v.heading_deg) % 360,
            max(0, min(100, throttle)),
        )

    def _altitude(self) -> bytes:
        v = self._view
        altitude_m = v.place.altitude_m
        up_enu_m = v.plant.estimate.position_enu_m[2]
        clearance_m = up_enu_m - v.plant.terrain_height_est_m
        return _ALTITUDE.pack(
            v.time_us,
            altitude_m,
            altitude_m,
            -v.position_ned_m[2],
            altitude_m - v.home_altitude_m,
            altitude_m - clearance_m,
            clearance_m,
        )

    def _target_local(self) -> bytes | None:
        v = self._view
        setpoint = v.autopilot.setpoint
        if setpoint.level is not ControlLevel.TRAJECTORY:
            return None
        position = v.ned_from_enu(setpoint.position_enu_m)
        velocity = swap_enu_ned(setpoint.velocity_enu_mps)
        acceleration = swap_enu_ned(setpoint.acceleration_enu_mps2)
        mask = _ignored(position) | _ignored(velocity) << 3 | _ignored(acceleration) << 6
        yaw, mask = _yaw_and_mask(setpoint.yaw_rad, mask)
        return _TARGET_LOCAL.pack(
            v.time_boot_ms,
            *position,
            *velocity,
            *acceleration,
            yaw,
            -setpoint.yaw_rate_radps,
            mask,
            mav.MAV_FRAME_LOCAL_NED,
        )

    def _target_global(self) -> bytes | None:
        v = self._view
        target = v.autopilot.target_enu_m
        if target is None or not all(map(math.isfinite, target)):
            return None
        place = v.frame.geodetic_from_enu(target)
        mask = _IGNORE_VELOCITY | _IGNORE_ACCELERATION | _IGNORE_YAW_RATE
        yaw, mask = _yaw_and_mask(v.autopilot.setpoint.yaw_rad, mask)
        return _TARGET_GLOBAL.pack(
            v.time_boot_ms,
            round(place.latitude_deg * 1e7),
            round(place.longitude_deg * 1e7),
            place.altitude_m,
            *(0.0,) * 6,
            yaw,
            0.0,
            mask,
            mav.MAV_FRAME_GLOBAL_INT,
        )

    def _nav_output(self) -> bytes | None:
        v = self._view
        target = v.autopilot.target_enu_m
        if target is None or not all(map(math.isfinite, target)):
            return None
        north, east, down = v.ned_from_enu(target)
        x, y, z = v.position_ned_m
        bearing = round(math.degrees(math.atan2(east - y, north - x)))
        distance = min(65535, round(math.hypot(north - x, east - y)))
        roll, pitch, _ = v.rpy_rad
        return _NAV_OUTPUT.pack(
            math.degrees(roll), math.degrees(pitch), z - down, 0.0, 0.0, bearing, bearing, distance
        )

    def _ground_truth(self) -> bytes:
        v = self._view
        truth: State = v.plant.truth
        quat = swap_quat_enu_flu_ned_frd(truth.quat_wxyz)
        place = v.frame.geodetic_from_enu(truth.position_enu_m)
        velocity = swap_enu_ned(truth.velocity_enu_mps)
        air_speed = math.dist(truth.velocity_enu_mps, v.plant.air_velocity_true_enu_mps)
        accel = swap_flu_frd(v.plant.sensors.imu.accel_flu_mps2)
        rates = swap_flu_frd(truth.angular_rate_flu_radps)
        return _HIL_STATE.encode(
            time_usec=v.time_us,
            attitude_quaternion=quat,
            rollspeed=rates[0],
            pitchspeed=rates[1],
            yawspeed=rates[2],
            lat=round(place.latitude_deg * 1e7),
            lon=round(place.longitude_deg * 1e7),
            alt=round(place.altitude_m * 1e3),
            **{f"v{axis}": _int16(100.0 * c) for axis, c in zip("xyz", velocity, strict=True)},
            ind_airspeed=_int16(100.0 * air_speed),
            true_airspeed=_int16(100.0 * air_speed),
            **{
                f"{axis}acc": _int16(1000.0 * c / _STANDARD_GRAVITY_MPS2)
                for axis, c in zip("xyz", accel, strict=True)
            },
        )


def _rotate_inverse(quat: Quaternion, vector: tuple[float, float, float]) -> tuple[float, ...]:
    """Rotate a vector from the quaternion's outer frame into its inner one."""
    w, x, y, z = quat
    a, b, c = vector
    # t = 2 v x u, v' = v + w t + t x u with u the vector part: rotation by the conjugate.
    tx, ty, tz = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    return (
        a + w * tx + ty * z - tz * y,
        b + w * ty + tz * x - tx * z,
        c + w * tz + tx * y - ty * x,
    )


def _ignored(vector: tuple[float, float, float]) -> int:
    """Type mask bits, one for each axis that is NaN."""
    x, y, z = vector
    return math.isnan(x) | math.isnan(y) << 1 | math.isnan(z) << 2


def _yaw_and_mask(yaw_enu_rad: float, mask: int) -> tuple[float, int]:
    if math.isnan(yaw_enu_rad):
        return 0.0, mask | _IGNORE_YAW
    return swap_yaw_enu_ned(yaw_enu_rad), mask
