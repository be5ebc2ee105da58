"""What each message that the kernel fills ought to say of a flight, in plain Python."""

from __future__ import annotations

import math

from autonomy.types import ControlLevel
from flightsim.environment.date import EPOCH_US
from flightsim.frames import (
    euler_rpy_rad,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
    swap_yaw_enu_ned,
)
from flightsim.mavlink.dialect import dialect as mav


def _int16(value):
    return max(-32768, min(32767, round(value)))


class Said:
    """What each compiled message ought to say of a flight, in plain Python."""

    def __init__(self, flight):
        self.flight = flight
        self.estimate, self.truth = flight.plant.estimate, flight.plant.truth
        self.setpoint, self.sensors = flight.autopilot.setpoint, flight.plant.sensors
        self.boot = {"time_boot_ms": flight.plant.time_us // 1000}
        self.now = {"time_usec": flight.plant.time_us}
        self.origin_enu_m = flight.server._view.origin_enu_m
        self.ned = self._ned(self.estimate.position_enu_m)
        self.velocity = swap_enu_ned(self.estimate.velocity_enu_mps)
        self.quat = swap_quat_enu_flu_ned_frd(self.estimate.quat_wxyz)
        self.rpy = euler_rpy_rad(self.quat)
        rates = swap_flu_frd(self.estimate.angular_rate_flu_radps)
        self.rates = dict(zip(("rollspeed", "pitchspeed", "yawspeed"), rates, strict=True))
        self.place = flight.frame.geodetic_from_enu(self.estimate.position_enu_m)
        home = flight.autopilot.home
        self.height_m = self.place.altitude_m - (
            home.geodetic.altitude_m
            if home
            else flight.frame.origin.altitude_m + self.origin_enu_m[2]
        )
        self.heading_deg = math.degrees(self.rpy[2]) % 360.0

    def _ned(self, position_enu_m):
        (x, y, z), (x0, y0, z0) = position_enu_m, self.origin_enu_m
        return (y - y0, x - x0, z0 - z)

    def of(self, name):
        """Its fields; None if there is nothing to tell."""
        if not self.flight.plant.is_aligned and name not in _BEFORE_ALIGNMENT:
            return None
        return getattr(self, name.lower())()

    def attitude(self):
        return {**self.boot, **_named("roll pitch yaw", self.rpy), **self.rates}

    def attitude_quaternion(self):
        return {**self.boot, **_named("q1 q2 q3 q4", self.quat), **self.rates}

    def attitude_target(self):
        is_given = self.setpoint.level is ControlLevel.ATTITUDE
        quat = swap_quat_enu_flu_ned_frd(self.setpoint.quat_wxyz) if is_given else self.quat
        rates = swap_flu_frd(self.setpoint.angular_rate_flu_radps)
        names = "body_roll_rate body_pitch_rate body_yaw_rate"
        thrust = self.flight.plant.collective_thrust_fraction
        return {**self.boot, "q": quat, **_named(names, rates), "thrust": thrust}

    def local_position_ned(self):
        return {**self.boot, **_named("x y z vx vy vz", (*self.ned, *self.velocity))}

    def global_position_int(self):
        return {
            **self.boot,
            "lat": round(self.place.latitude_deg * 1e7),
            "lon": round(self.place.longitude_deg * 1e7),
            "alt": round(self.place.altitude_m * 1e3),
            "relative_alt": round(self.height_m * 1e3),
            **_named("vx vy vz", [_int16(100.0 * v) for v in self.velocity]),
            "hdg": round(self.heading_deg * 100.0) % 36000,
        }

    def odometry(self):
        w, x, y, z = self.quat
        a, b, c = self.velocity
        tx, ty, tz = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
        body = (
            a + w * tx + ty * z - tz * y,
            b + w * ty + tz * x - tx * z,
            c + w * tz + tx * y - ty * x,
        )
        unknown = (math.nan, *(0.0,) * 20)
        return {
            **self.now,
            **_named("x y z vx vy vz", (*self.ned, *body)),
            "q": self.quat,
            **self.rates,
            **dict.fromkeys(("pose_covariance", "velocity_covariance"), unknown),
            **_named("frame_id child_frame_id estimator_type quality", (1, 12, 8, 100)),
        }

    def vfr_hud(self):
        return {
            "airspeed": max(0.0, self.sensors.airspeed.indicated_mps),
            "groundspeed": math.hypot(*self.velocity[:2]),
            "alt": self.place.altitude_m,
            "climb": -self.velocity[2],
            "heading": round(self.heading_deg) % 360,
            "throttle": round(100.0 * self.flight.plant.collective_thrust_fraction),
        }

    def altitude(self):
        altitude_m = self.place.altitude_m
        terrain_m = self.flight.plant.terrain_height_est_m
        clearance_m = self.estimate.position_enu_m[2] - terrain_m
        return {
            **self.now,
            **dict.fromkeys(("altitude_monotonic", "altitude_amsl"), altitude_m),
            "altitude_local": -self.ned[2],
            "altitude_relative": self.height_m,
            "altitude_terrain": altitude_m - clearance_m,
            "bottom_clearance": clearance_m,
        }

    def position_target_local_ned(self):
        s = self.setpoint
        if s.level is not ControlLevel.TRAJECTORY:
            return None
        vectors = (
            *self._ned(s.position_enu_m),
            *swap_enu_ned(s.velocity_enu_mps),
            *swap_enu_ned(s.acceleration_enu_mps2),
        )
        bits = sum(math.isnan(v) << axis for axis, v in enumerate(vectors))
        has_yaw = not math.isnan(s.yaw_rad)
        return {
            **self.boot,
            **_named("x y z vx vy vz afx afy afz", vectors),
            "yaw": swap_yaw_enu_ned(s.yaw_rad) if has_yaw else 0.0,
            "yaw_rate": -s.yaw_rate_radps,
            "type_mask": bits | (0 if has_yaw else 1024),
            "coordinate_frame": 1,
        }

    def position_target_global_int(self):
        target = self.flight.autopilot.target_enu_m
        if target is None:
            return None
        place, yaw = self.flight.frame.geodetic_from_enu(target), self.setpoint.yaw_rad
        has_yaw = not math.isnan(yaw)
        return {
            **self.boot,
            "lat_int": round(place.latitude_deg * 1e7),
            "lon_int": round(place.longitude_deg * 1e7),
            "alt": place.altitude_m,
            "yaw": swap_yaw_enu_ned(yaw) if has_yaw else 0.0,
            "type_mask": 7 << 3 | 7 << 6 | 2048 | (0 if has_yaw else 1024),
            "coordinate_frame": 5,
        }

    def nav_controller_output(self):
        target = self.flight.autopilot.target_enu_m
        if target is None:
            return None
        ahead = self._ned(target)
        north, east = ahead[0] - self.ned[0], ahead[1] - self.ned[1]
        bearing = round(math.degrees(math.atan2(east, north)))
        return {
            "nav_roll": math.degrees(self.rpy[0]),
            "nav_pitch": math.degrees(self.rpy[1]),
            "alt_error": self.ned[2] - ahead[2],
            **dict.fromkeys(("nav_bearing", "target_bearing"), bearing),
            "wp_dist": round(math.hypot(north, east)),
        }

    def hil_state_quaternion(self):
        state, plant = self.truth, self.flight.plant
        place = self.flight.frame.geodetic_from_enu(state.position_enu_m)
        rates = swap_flu_frd(state.angular_rate_flu_radps)
        velocity = [_int16(100.0 * v) for v in swap_enu_ned(state.velocity_enu_mps)]
        air = _int16(100.0 * math.dist(state.velocity_enu_mps, plant.air_velocity_true_enu_mps))
        accel = [1000.0 * a / 9.80665 for a in swap_flu_frd(self.sensors.imu.accel_flu_mps2)]
        return {
            **self.now,
            "attitude_quaternion": swap_quat_enu_flu_ned_frd(state.quat_wxyz),
            **_named("rollspeed pitchspeed yawspeed", rates),
            "lat": round(place.latitude_deg * 1e7),
            "lon": round(place.longitude_deg * 1e7),
            "alt": round(place.altitude_m * 1e3),
            **_named("vx vy vz", velocity),
            **dict.fromkeys(("ind_airspeed", "true_airspeed"), air),
            **_named("xacc yacc zacc", [_int16(a) for a in accel]),
        }

    def highres_imu(self):
        imu, baro = self.sensors.imu, self.sensors.baro
        field = [0.01 * b for b in swap_flu_frd(self.sensors.mag.field_flu_ut)]
        names = "xacc yacc zacc xgyro ygyro zgyro xmag ymag zmag"
        motion = (*swap_flu_frd(imu.accel_flu_mps2), *swap_flu_frd(imu.gyro_flu_radps))
        return {
            **self.now,
            **_named(names, (*motion, *field)),
            "abs_pressure": 0.01 * baro.pressure_pa,
            "diff_pressure": 0.01 * self.sensors.airspeed.differential_pa,
            "pressure_alt": baro.altitude_m,
            "temperature": baro.temperature_degc,
            "fields_updated": 0x1FFF,
        }

    def distance_sensor(self):
        range_m = self.sensors.range_m
        is_valid = math.isfinite(range_m)
        return {
            **self.boot,
            "min_distance": 10,
            "max_distance": 3000,
            "current_distance": min(3001, round(100.0 * range_m)) if is_valid else 3001,
            "orientation": mav.MAV_SENSOR_ROTATION_PITCH_270,
            "covariance": 255,
            "signal_quality": 100 if is_valid else 1,
        }

    def servo_output_raw(self):
        plant = self.flight.plant
        airframe, speeds = plant.world.airframe, plant.rotor_speed_commands_radps
        most = max(rotor.max_speed_radps for rotor in airframe.quadrotor.rotors)
        pulses = {
            f"servo{number}_raw": 1000 + round(1000 * (speeds[rotor] / most))
            if self.flight.autopilot.is_armed or speeds[rotor] > 0.0
            else 900
            for number, rotor in enumerate(airframe.motors, start=1)
        }
        return {"time_usec": plant.time_us & 0xFFFFFFFF, **pulses}

    def gps_raw_int(self):
        gnss = self.sensors.gnss
        place = self.flight.frame.geodetic_from_enu(gnss.position_enu_m)
        east, north, _ = gnss.velocity_enu_mps
        course_deg = math.degrees(math.atan2(east, north))
        errors_m, is_fixed = (gnss.eph_m, gnss.epv_m), math.isfinite(gnss.eph_m)
        return {
            "time_usec": gnss.time_us,
            "lat": round(place.latitude_deg * 1e7),
            "lon": round(place.longitude_deg * 1e7),
            **dict.fromkeys(("alt", "alt_ellipsoid"), round(place.altitude_m * 1e3)),
            **_named("eph epv", [round(100 * m) if is_fixed else 65535 for m in errors_m]),
            **_named("h_acc v_acc", [round(1e3 * m) if is_fixed else 0 for m in errors_m]),
            "vel": round(100.0 * math.hypot(north, east)),
            "cog": round(course_deg * 100.0) % 36000,
            **_named("fix_type satellites_visible", (gnss.fix_type, gnss.n_satellites)),
        }

    def scaled_pressure(self):
        baro, airspeed = self.sensors.baro, self.sensors.airspeed
        return {
            **self.boot,
            "press_abs": 0.01 * baro.pressure_pa,
            "press_diff": 0.01 * airspeed.differential_pa,
            "temperature": round(100.0 * baro.temperature_degc),
            "temperature_press_diff": round(100.0 * airspeed.temperature_degc),
        }

    def estimator_status(self):
        e = self.flight.plant.estimator
        return {
            **self.now,
            "flags": e.is_position_valid * 0b11_0111_1110 | int(e.is_attitude_valid),
            **_named("vel_ratio pos_horiz_ratio", (e.gnss_velocity_ratio, e.gnss_position_ratio)),
            **_named("pos_vert_ratio mag_ratio", (e.baro_ratio, e.heading_ratio)),
            "pos_horiz_accuracy": e.sigma_horizontal_m,
            "pos_vert_accuracy": e.sigma_vertical_m,
        }

    def wind_cov(self):
        east, north = self.flight.plant.wind_est_enu_mps
        return {
            **self.now,
            **_named("wind_x wind_y wind_alt", (north, east, self.place.altitude_m)),
            **dict.fromkeys(("horiz_accuracy", "vert_accuracy"), math.nan),
        }

    def vibration(self):
        return self.now

    def system_time(self):
        return {**self.boot, "time_unix_usec": EPOCH_US + self.flight.plant.time_us}


_BEFORE_ALIGNMENT = (
    *("HIL_STATE_QUATERNION", "HIGHRES_IMU", "DISTANCE_SENSOR", "SERVO_OUTPUT_RAW", "SYSTEM_TIME"),
    *("GPS_RAW_INT", "SCALED_PRESSURE", "ESTIMATOR_STATUS", "WIND_COV", "VIBRATION"),
)


def _named(names, values):
    return dict(zip(names.split(), values, strict=True))
