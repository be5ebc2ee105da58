"""Messages of PX4's simulator link, from our sensors' samples and from the truth.

PX4 takes a HIL_SENSOR at every tick, with flags for the sensors that have a new sample; the
receiver, odometry, optical flow and the range have messages of their own, at their own rates.
"""

from __future__ import annotations

import math

from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.bridges.physics.odometry import OdometryPose, OdometryPoses
from flightsim.frames import LocalFrame, swap_enu_ned, swap_flu_frd, swap_quat_enu_flu_ned_frd
from flightsim.mavlink.dialect import Layout, layout
from flightsim.mavlink.dialect import dialect as mavlink
from flightsim.plant import Plant

_HIL_SENSOR = layout(
    "HIL_SENSOR",
    *("time_usec", "xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "xmag", "ymag", "zmag"),
    *("abs_pressure", "diff_pressure", "pressure_alt", "temperature", "fields_updated", "id"),
)
_HIL_GPS = layout("HIL_GPS")
_HIL_STATE = layout("HIL_STATE_QUATERNION")
_HIL_FLOW = layout("HIL_OPTICAL_FLOW")
_ODOMETRY = layout("ODOMETRY")
_DISTANCE_SENSOR = layout("DISTANCE_SENSOR")
# Bits of HIL_SENSOR's fields_updated.
_IMU_FIELDS, _MAG_FIELDS, _BARO_FIELDS = 0b111111, 0b111000000, 0b1101000000000
_GAUSS_PER_UT, _HPA_PER_PA = 0.01, 0.01
_FIRST_US = 1_000_000
"""Time of the first sample: PX4 takes zero for no time."""
_TRUTH_EVERY_US = _RANGE_EVERY_US = 20_000
_MIN_RANGE_CM, _MAX_RANGE_CM = 10, 3000
_UNKNOWN_CM = 65535
_SYSTEM, _COMPONENT = 1, 200  # any pair but PX4's own component
_FACING_DOWN = 25  # MAV_SENSOR_ROTATION_PITCH_270
_DIAGONAL = (0, 6, 11, 15, 18, 20)
"""Indices of the variances in the upper triangle of a covariance of six numbers, row by row."""
_NO_VELOCITY = dict.fromkeys(("vx", "vy", "vz", "rollspeed", "pitchspeed", "yawspeed"), math.nan)
_FULL_QUALITY = 100
_UNKNOWN_DISTANCE_M = -1.0


class SensorMessages:
    """Builder of the frames of a tick.

    HIL_SENSOR comes last, since it lets PX4's time pass; all others are then there already.
    """

    def __init__(self, frame: LocalFrame) -> None:
        self._frame = frame
        self._sequence = 0
        self._odometry = OdometryPoses()
        self._mag_us = self._baro_us = self._gnss_us = -1
        self._flow_us = 0

    def frames(self, plant: Plant) -> tuple[bytes, int]:
        """Return the frames of a tick's samples, and the time in its HIL_SENSOR.

        Args:
            plant: Vehicle, after the tick.

        Returns:
            The frames one after the other, and PX4's time in microseconds.
        """
        time_us = plant.time_us + _FIRST_US
        parts = []
        if plant.time_us % _TRUTH_EVERY_US == 0:
            parts.append(self._frame_of(_HIL_STATE, self._state(plant, time_us)))
            parts.append(self._frame_of(_DISTANCE_SENSOR, _range(plant, time_us)))
        gnss = plant.sensors.gnss
        if gnss.time_us != self._gnss_us:
            self._gnss_us = gnss.time_us
            parts.append(self._frame_of(_HIL_GPS, self._gps(plant, time_us)))
        if (pose := self._odometry.arrived(plant)) is not None:
            parts.append(self._frame_of(_ODOMETRY, _pose(plant, pose)))
        if plant.sensors.optical_flow.time_us != self._flow_us:
            self._flow_us = plant.sensors.optical_flow.time_us
            parts.append(self._frame_of(_HIL_FLOW, _flow(plant, time_us)))
        parts.append(self._frame_of(_HIL_SENSOR, self._sensor(plant, time_us)))
        return b"".join(parts), time_us

    def _frame_of(self, kind: Layout, payload: bytes) -> bytes:
        self._sequence = (self._sequence + 1) % 256
        return kind.frame_v2(payload, self._sequence, _SYSTEM, _COMPONENT)

    def _sensor(self, plant: Plant, time_us: int) -> bytes:
        imu, mag, baro = plant.sensors.imu, plant.sensors.mag, plant.sensors.baro
        updated = _IMU_FIELDS
        if mag.time_us != self._mag_us:
            self._mag_us = mag.time_us
            updated |= _MAG_FIELDS
        # There is no pressure before the first sample.
        if baro.time_us != self._baro_us and baro.pressure_pa > 0.0:
            self._baro_us = baro.time_us
            updated |= _BARO_FIELDS
        mx, my, mz = swap_flu_frd(mag.field_flu_ut)
        return _HIL_SENSOR.pack(
            time_us,
            *swap_flu_frd(imu.accel_flu_mps2),
            *swap_flu_frd(imu.gyro_flu_radps),
            mx * _GAUSS_PER_UT,
            my * _GAUSS_PER_UT,
            mz * _GAUSS_PER_UT,
            baro.pressure_pa * _HPA_PER_PA,
            0.0,  # no airspeed sensor
            baro.altitude_m,
            baro.temperature_degc,
            updated,
            0,
        )

    def _gps(self, plant: Plant, time_us: int) -> bytes:
        gnss = plant.sensors.gnss
        place = self._frame.geodetic_from_enu(gnss.position_enu_m)
        vn, ve, vd = swap_enu_ned(gnss.velocity_enu_mps)
        course_deg = math.degrees(math.atan2(ve, vn)) % 360.0
        return _HIL_GPS.encode(
            time_usec=time_us,
            fix_type=gnss.fix_type,
            lat=round(place.latitude_deg * 1e7),
            lon=round(place.longitude_deg * 1e7),
            alt=round(place.altitude_m * 1e3),
            eph=_centimetres(gnss.eph_m),
            epv=_centimetres(gnss.epv_m),
            vel=_centimetres(math.hypot(vn, ve)),
            vn=round(100 * vn),
            ve=round(100 * ve),
            vd=round(100 * vd),
            cog=round(100 * course_deg) % 36_000,  # 36000 is no valid course
            satellites_visible=gnss.n_satellites,
        )

    def _state(self, plant: Plant, time_us: int) -> bytes:
        truth = plant.truth
        place = self._frame.geodetic_from_enu(truth.position_enu_m)
        rates = swap_flu_frd(truth.angular_rate_flu_radps)
        vn, ve, vd = (round(100 * v) for v in swap_enu_ned(truth.velocity_enu_mps))
        accel = swap_flu_frd(plant.sensors.imu.accel_flu_mps2)
        x_mg, y_mg, z_mg = (round(1e3 * a / GRAVITY_MPS2) for a in accel)
        return _HIL_STATE.encode(
            time_usec=time_us,
            attitude_quaternion=swap_quat_enu_flu_ned_frd(truth.quat_wxyz),
            rollspeed=rates[0],
            pitchspeed=rates[1],
            yawspeed=rates[2],
            lat=round(place.latitude_deg * 1e7),
            lon=round(place.longitude_deg * 1e7),
            alt=round(place.altitude_m * 1e3),
            vx=vn,
            vy=ve,
            vz=vd,
            xacc=x_mg,
            yacc=y_mg,
            zacc=z_mg,
        )


def _pose(plant: Plant, pose: OdometryPose) -> bytes:
    """Encode odometry's pose: from the start, without velocity, with its white noise."""
    vio = plant.cfg.vio
    position_m2, yaw_rad2 = vio.position_noise_m**2, vio.yaw_noise_rad**2
    covariance = [0.0] * (_DIAGONAL[-1] + 1)
    for k, variance in zip(_DIAGONAL, (position_m2,) * 3 + (yaw_rad2,) * 3, strict=True):
        covariance[k] = variance
    x, y, z = swap_enu_ned(pose.from_start_enu_m)
    return _ODOMETRY.encode(
        time_usec=pose.time_us + _FIRST_US,
        frame_id=mavlink.MAV_FRAME_LOCAL_NED,
        child_frame_id=mavlink.MAV_FRAME_BODY_FRD,
        x=x,
        y=y,
        # Unknown velocities are NaN in MAVLink; zeros would be fused as a standstill.
        z=z,
        q=swap_quat_enu_flu_ned_frd(pose.quat_wxyz),
        **_NO_VELOCITY,
        pose_covariance=covariance,
        velocity_covariance=[math.nan] * len(covariance),
        estimator_type=mavlink.MAV_ESTIMATOR_TYPE_VIO,
        quality=_FULL_QUALITY,
    )


def _flow(plant: Plant, time_us: int) -> bytes:
    flow = plant.sensors.optical_flow
    (x, y), (turn_x, turn_y, turn_z) = flow.flow_frd_rad, flow.gyro_frd_rad
    return _HIL_FLOW.encode(
        time_usec=time_us,
        integration_time_us=flow.integration_us,
        integrated_x=x,
        integrated_y=y,
        integrated_xgyro=turn_x,
        integrated_ygyro=turn_y,
        integrated_zgyro=turn_z,
        distance=flow.distance_m if math.isfinite(flow.distance_m) else _UNKNOWN_DISTANCE_M,
        quality=flow.quality,
    )


def _range(plant: Plant, time_us: int) -> bytes:
    range_m = plant.sensors.range_m
    return _DISTANCE_SENSOR.encode(
        time_boot_ms=time_us // 1000,
        min_distance=_MIN_RANGE_CM,
        max_distance=_MAX_RANGE_CM,
        # Beyond the greatest range is out of reach.
        current_distance=min(_centimetres(range_m), _MAX_RANGE_CM + 1),
        orientation=_FACING_DOWN,
    )


def _centimetres(value_m: float) -> int:
    return min(round(100 * value_m), _UNKNOWN_CM) if math.isfinite(value_m) else _UNKNOWN_CM
