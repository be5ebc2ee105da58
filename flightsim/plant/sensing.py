"""Sensors of a plant: the list, the order in which they measure, and their readings.

The order is fixed, because all sensors correct the same filter: another order would give slightly
different estimates. The IMU comes first, so that corrections meet a state that is predicted up to
the present tick.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from autonomy.estimation.terrain import fuse_range
from autonomy.jit import kernel
from flightsim.plant.rays import cast_ray_m
from flightsim.plant.sky import look_up
from flightsim.sensors.airspeed import AIRSPEED, AirspeedReading, sense_airspeed
from flightsim.sensors.barometer import BAROMETER, BaroReading, sense_barometer
from flightsim.sensors.failure import MOST_ALIKE, is_stuck
from flightsim.sensors.gnss import GNSS, sense_gnss
from flightsim.sensors.gnss_reading import GnssReading
from flightsim.sensors.imu import IMU, ImuReading, sense_imu
from flightsim.sensors.magnetometer import MAGNETOMETER, MagReading, sense_magnetometer
from flightsim.sensors.mocap import MOCAP, sense_mocap
from flightsim.sensors.optical_flow import (
    OPTICAL_FLOW,
    OpticalFlowReading,
    follow_flow,
    sample_optical_flow,
)
from flightsim.sensors.rangefinder import RANGEFINDER, aim_ray, sample_rangefinder
from flightsim.sensors.sensor import Sensor, is_due, noise
from flightsim.sensors.vibration import shake
from flightsim.sensors.vio import VIO, VioReading, sense_vio

SENSORS: tuple[Sensor, ...] = (
    IMU,
    GNSS,
    VIO,
    MOCAP,
    BAROMETER,
    MAGNETOMETER,
    RANGEFINDER,
    AIRSPEED,
    OPTICAL_FLOW,
)


@kernel
def sense(
    p: np.record,
    qpos: np.ndarray,
    qvel: np.ndarray,
    rooms: np.ndarray,
    steel: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Let every sensor that is due measure, and let the filter use the sample.

    Args:
        p: `PLANT_DTYPE`, changed.
        qpos: True pose (7,): position ENU, attitude wxyz.
        qvel: True velocity (6,): linear ENU, angular FLU.
        rooms: Rooms without satellite signals (n, 8).
        steel: Steel that disturbs the magnetometer (n, 5).
        normals: Standard normals of the present second for all sensors.
    """
    f, tick = p.filter, p.engine.tick
    speeds = p.rotors.speed_radps[: p.rotors.n_rotors]
    shake(p.vibration, speeds)
    sense_imu(p.imu, f, tick, qpos, qvel, speeds, p.vibration, normals)
    if is_due(p.gnss, tick):
        # Only for a fix that is due: each look casts rays.
        look_up(p.sky, p.engine, qpos[0:3])
    sense_gnss(p.gnss, f, tick, qpos, qvel, p.sky, rooms, normals)
    sense_vio(p.vio, f, tick, qpos, normals)
    sense_mocap(p.mocap, f, tick, qpos, normals)
    sense_barometer(p.baro, f, tick, qpos, normals)
    sense_magnetometer(p.mag, f, tick, qpos, speeds, steel, normals)
    _sense_range(p.range, f, p.engine, qpos, normals)
    _sense_flow(p.optical_flow, p.engine, qpos, qvel, p.imu.gyro_flu_radps, normals)
    sense_airspeed(p.airspeed, tick, qpos, qvel, p.rotors.wind_enu_mps, normals)


@kernel
def _sense_range(
    r: np.record, f: np.record, e: np.record, qpos: np.ndarray, normals: np.ndarray
) -> None:
    """Cast the rangefinder's ray in MuJoCo's world if a sample is due, and fuse the reading."""
    if not is_due(r, e.tick):
        return
    aim_ray(r, qpos[0:3], qpos[3:7])
    distance_m = cast_ray_m(e, r)
    sample_rangefinder(r, e.tick, distance_m, noise(r, e.tick, normals))
    if f.is_aligned == 1 and not is_stuck(r, 0, r.range_m):
        fuse_range(f, r.range_m, r.period_ticks * f.dt_s)


@kernel
def _sense_flow(
    r: np.record,
    e: np.record,
    qpos: np.ndarray,
    qvel: np.ndarray,
    gyro_flu_radps: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Add the flow of this tick, and finish a sample if one is due; does nothing if not fitted."""
    if r.is_enabled == 0:
        return
    dt_s = 1.0 / e.tick_hz
    is_time = is_due(r, e.tick)
    if is_time:
        aim_ray(r, qpos[0:3], qpos[3:7])
        r.seen_m = cast_ray_m(e, r)
    # The flow is added at every tick, with the distance that the last ray measured.
    follow_flow(r, qpos[3:7], qvel[0:3], qvel[3:6], gyro_flu_radps, dt_s)
    if is_time:
        sample_optical_flow(r, e.tick, r.period_ticks * dt_s, noise(r, e.tick, normals))


class SensorReadings:
    """Latest sample of every sensor, read out of the plant's record on request."""

    __slots__ = ("_readings", "_records", "_tick_us")

    def __init__(self, record: np.void, tick_us: int) -> None:
        self._records = {sensor.name: record[sensor.name] for sensor in SENSORS}
        self._tick_us = tick_us
        self._readings: dict[str, Any] = {}

    def drop(self) -> None:
        """Forget the cached readings, because the sensors have measured again."""
        self._readings.clear()

    def read(self, sensor: Sensor) -> Any:
        """Return the latest sample of a sensor of `SENSORS`."""
        name = sensor.name
        if name not in self._readings:
            self._readings[name] = sensor.read(self._records[name], self._tick_us)
        return self._readings[name]

    def is_delivering(self, sensor: Sensor, now_us: int, patience_us: int) -> bool:
        """Return true if a sensor sends fresh samples.

        Args:
            sensor: The sensor.
            now_us: Present simulated time.
            patience_us: Greatest age of the last sample. A sensor that only repeats itself sends
                none.
        """
        r = self._records[sensor.name]
        age_us = now_us - max(0, int(r["tick"])) * self._tick_us
        return age_us < patience_us and max(r["n_alike"].tolist()) < MOST_ALIKE

    @property
    def imu(self) -> ImuReading:
        """Accelerometer and gyroscope."""
        return self.read(IMU)

    @property
    def gnss(self) -> GnssReading:
        """Satellite receiver."""
        return self.read(GNSS)

    @property
    def vio(self) -> VioReading:
        """Visual-inertial odometry."""
        return self.read(VIO)

    @property
    def baro(self) -> BaroReading:
        """Barometer."""
        return self.read(BAROMETER)

    @property
    def mag(self) -> MagReading:
        """Magnetometer."""
        return self.read(MAGNETOMETER)

    @property
    def range_m(self) -> float:
        """Distance along body -z; infinite beyond reach, NaN before the first sample."""
        return self.read(RANGEFINDER)

    @property
    def airspeed(self) -> AirspeedReading:
        """Pitot tube along body x."""
        return self.read(AIRSPEED)

    @property
    def optical_flow(self) -> OpticalFlowReading:
        """Optical flow, on vehicles that carry the sensor (`PlantCfg.optical_flow`)."""
        return self.read(OPTICAL_FLOW)
