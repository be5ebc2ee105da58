"""Inertial measurement unit in the centre of mass.

A sample is the mean over its interval, as from an IMU that integrates fast: the specific force from
the change of velocity, the angular rate from the change of attitude. Instantaneous values would
miss the motion between two samples, and a filter that integrates them would drift from the truth
even without noise.

Each axis adds white noise N / sqrt(dt), a drifting bias (`flightsim.sensors.drift`), and the
vibration of the rotors (`flightsim.sensors.vibration`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autonomy.estimation.alignment import collect_imu
from autonomy.estimation.predict import predict
from autonomy.estimation.wind import fuse_drag
from autonomy.jit import fields, kernel
from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.rotation import (
    matrix_from_quat,
    quat_from_rotation_vector,
    quat_multiply,
    rotation_vector_from_quat,
)
from autonomy.types import Vector3
from flightsim.sensors.drift import advance_drift, drift_terms
from flightsim.sensors.failure import is_heard, is_stuck, said
from flightsim.sensors.sensor import Sensor, SensorStart, noise, reader


@dataclass(frozen=True, kw_only=True, slots=True)
class ImuCfg:
    """Noise of an IMU."""

    gyro_noise_density: float
    """Density N of the white noise, rad/s/sqrt(Hz)."""
    gyro_bias_walk: float
    """Density of the noise that drives the bias, rad/s^2/sqrt(Hz)."""
    gyro_bias_correlation_s: float = 1000.0
    gyro_turn_on_sigma_radps: float
    """Standard deviation of the bias at switching on."""
    accel_noise_density: float
    """Density N of the white noise, m/s^2/sqrt(Hz)."""
    accel_bias_walk: float
    """Density of the noise that drives the bias, m/s^3/sqrt(Hz)."""
    accel_bias_correlation_s: float = 300.0
    accel_turn_on_sigma_mps2: float
    """Standard deviation of the bias at switching on."""


ADIS16448 = ImuCfg(
    gyro_noise_density=3.394e-4,
    gyro_bias_walk=3.8785e-5,
    gyro_turn_on_sigma_radps=0.0087,
    accel_noise_density=0.004,
    accel_bias_walk=0.006,
    accel_turn_on_sigma_mps2=0.196,
)
"""Default IMU of RotorS: an uncalibrated ADIS16448."""

PX4_IMU = ImuCfg(
    gyro_noise_density=8.7266e-4,
    gyro_bias_walk=0.0,
    gyro_turn_on_sigma_radps=0.0,
    accel_noise_density=0.00637,
    accel_bias_walk=0.0,
    accel_turn_on_sigma_mps2=0.0,
)
"""IMU of PX4's gazebo-classic vehicles today: noisier, and calibrated."""

IMUS = {"px4": PX4_IMU, "adis16448": ADIS16448}
ACCELEROMETER, GYROSCOPE = 0, 1
"""Parts of the IMU that can fail alone."""


def _configure(r: np.void, cfg: ImuCfg, start: SensorStart) -> None:
    """Fill the record of a sensor that is switched on at a true attitude and velocity."""
    dt_s = 1.0 / start.tick_hz
    r["dt_s"] = dt_s
    r["last_quat_wxyz"] = start.quat_wxyz
    r["last_velocity_enu_mps"] = start.velocity_enu_mps
    r["accel_bias_flu_mps2"] = cfg.accel_turn_on_sigma_mps2 * start.rng.standard_normal(3)
    r["gyro_bias_flu_radps"] = cfg.gyro_turn_on_sigma_radps * start.rng.standard_normal(3)
    r["accel_sigma"] = cfg.accel_noise_density / math.sqrt(dt_s)
    r["gyro_sigma"] = cfg.gyro_noise_density / math.sqrt(dt_s)
    r["accel_decay"], r["accel_drift_sigma"] = drift_terms(
        cfg.accel_bias_walk, cfg.accel_bias_correlation_s, dt_s
    )
    r["gyro_decay"], r["gyro_drift_sigma"] = drift_terms(
        cfg.gyro_bias_walk, cfg.gyro_bias_correlation_s, dt_s
    )


@kernel
def sample_imu(
    r: np.record, quat_wxyz: np.ndarray, velocity_enu_mps: np.ndarray, normals: np.ndarray
) -> None:
    """Measure the interval since the previous sample, which ends in this true state.

    Args:
        r: Record of the sensor; changed.
        quat_wxyz: True attitude at the end of the interval, body FLU to world ENU.
        velocity_enu_mps: True velocity at the end of the interval.
        normals: Twelve standard normals: white noise and drift of accelerometer and gyroscope.
    """
    _mean_motion(r, quat_wxyz, velocity_enu_mps)
    advance_drift(r.accel_bias_flu_mps2, r.accel_decay, r.accel_drift_sigma, normals, 6)
    advance_drift(r.gyro_bias_flu_radps, r.gyro_decay, r.gyro_drift_sigma, normals, 9)
    for i in range(3):
        r.accel_flu_mps2[i] += r.accel_bias_flu_mps2[i] + r.accel_sigma * normals[i]
        r.gyro_flu_radps[i] += r.gyro_bias_flu_radps[i] + r.gyro_sigma * normals[3 + i]


@kernel
def _mean_motion(r: np.record, quat_wxyz: np.ndarray, velocity_enu_mps: np.ndarray) -> None:
    """Write the mean specific force and mean angular rate of the interval, without errors."""
    q, turn, R, dt = r.work_quat, r.work_vector, r.work_R, r.dt_s
    # q is the inverse of the last attitude; q times the present one is the turn in body axes.
    q[0] = r.last_quat_wxyz[0]
    for i in range(3):
        q[i + 1] = -r.last_quat_wxyz[i + 1]
    quat_multiply(q, quat_wxyz, q)
    rotation_vector_from_quat(q, turn)
    # The mean acceleration is rotated by the attitude halfway through the interval, which is right
    # to second order.
    quat_from_rotation_vector(0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2], q)
    quat_multiply(r.last_quat_wxyz, q, q)
    matrix_from_quat(q, R)
    for i in range(3):
        r.gyro_flu_radps[i] = turn[i] / dt
        turn[i] = (velocity_enu_mps[i] - r.last_velocity_enu_mps[i]) / dt
        r.last_velocity_enu_mps[i] = velocity_enu_mps[i]
    # `turn` now holds the mean acceleration. An accelerometer at rest reads +g upwards.
    turn[2] += GRAVITY_MPS2
    for i in range(3):
        r.accel_flu_mps2[i] = R[0, i] * turn[0] + R[1, i] * turn[1] + R[2, i] * turn[2]
    for i in range(4):
        r.last_quat_wxyz[i] = quat_wxyz[i]


@kernel
def sense_imu(
    r: np.record,
    f: np.record,
    tick: int,
    qpos: np.ndarray,
    qvel: np.ndarray,
    rotor_speed_radps: np.ndarray,
    vibration: np.record,
    normals: np.ndarray,
) -> None:
    """Measure, and let the filter predict with the sample; called at every control tick.

    Args:
        r: Record of the IMU.
        f: Record of the filter.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        qvel: True velocity of the vehicle, (6,).
        rotor_speed_radps: Speed of each rotor, for the filter's air resistance.
        vibration: Record of the vibration, which is added to the sample.
        normals: Standard normal numbers of the sensor.
    """
    drawn = noise(r, tick, normals)
    sample_imu(r, qpos[3:7], qvel[0:3], drawn)
    for i in range(3):
        accel = r.accel_flu_mps2[i] + vibration.accel_flu_mps2[i]
        gyro = r.gyro_flu_radps[i] + vibration.gyro_flu_radps[i]
        r.accel_flu_mps2[i] = said(r, ACCELEROMETER, tick, i, accel, drawn)
        r.gyro_flu_radps[i] = said(r, GYROSCOPE, tick, 3 + i, gyro, drawn)
    if is_heard(r, ACCELEROMETER, tick) and is_heard(r, GYROSCOPE, tick):
        r.tick = tick
    # The vehicle has no second IMU to switch to, so the filter goes on even with a stuck one. The
    # calls only keep the counts that the health report reads.
    is_stuck(r, ACCELEROMETER, r.accel_flu_mps2[0])
    is_stuck(r, GYROSCOPE, r.gyro_flu_radps[0])
    if f.is_aligned == 1:
        predict(f, r.accel_flu_mps2, r.gyro_flu_radps)
        fuse_drag(f, r.accel_flu_mps2, rotor_speed_radps)
    else:
        collect_imu(f, r.accel_flu_mps2, r.gyro_flu_radps)


class ImuReading(NamedTuple):
    """Mean specific force and angular rate of the last IMU interval."""

    time_us: int
    accel_flu_mps2: Vector3
    gyro_flu_radps: Vector3


IMU = Sensor(
    name="imu",
    setting="imu",
    grades=IMUS,
    fields=(
        *fields("accel_flu_mps2", "accel_bias_flu_mps2", "accel_drift_sigma", shape=(3,)),
        *fields("gyro_flu_radps", "gyro_bias_flu_radps", "gyro_drift_sigma", shape=(3,)),
        *fields("dt_s", "accel_sigma", "gyro_sigma", "accel_decay", "gyro_decay"),
        *fields("last_velocity_enu_mps", "work_vector", shape=(3,)),
        *fields("last_quat_wxyz", "work_quat", shape=(4,)),
        ("work_R", "f8", (3, 3)),
    ),
    n_normals=12,
    stream=2,
    start_stream=0,
    configure=_configure,
    wrong=(0.4, 0.4, 0.0, 0.01, 0.01, 0.01),
    garbage=(200.0, 200.0, 200.0, 80.0, 80.0, 80.0),
    read=reader(ImuReading),
)
