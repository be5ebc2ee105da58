"""Magnetometer: the Earth's field in body axes, with noise, drift, steel and motor currents.

Compass errors decide whether a filter may trust its heading. White noise alone is harmless. Two
disturbances are not: steel near the vehicle turns the field (`flightsim.environment.steel`), and
the current of the motors adds a field in a random direction fixed to the body, which grows with the
thrust.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autonomy.estimation.alignment import collect_vector
from autonomy.estimation.fusion import fuse_magnetometer
from autonomy.jit import fields, kernel
from autonomy.rotation import matrix_from_quat
from autonomy.types import Vector3
from flightsim.environment.steel import disturb
from flightsim.sensors.drift import advance_drift, drift_terms
from flightsim.sensors.failure import is_stuck, said
from flightsim.sensors.sensor import Sensor, SensorStart, is_due, noise, reader


@dataclass(frozen=True, kw_only=True, slots=True)
class MagnetometerCfg:
    """Noise of a magnetometer, by PX4's gazebo-classic (0.4e-3 gauss/sqrt(Hz) is 0.04 uT)."""

    rate_hz: int = 50
    noise_density: float = 0.04
    """Density of the white noise, uT/sqrt(Hz)."""
    drift_density: float = 6.4e-4
    """Density of the noise that drives the drift, uT/s/sqrt(Hz)."""
    drift_correlation_s: float = 600.0
    motor_ut_per_a: float = 0.03
    """Field per ampere of motor current. It makes 1 uT, 2% of the Earth's field, at the 33 A of
    full throttle, as on a mast; ArduPilot's manual (compassmot) accepts 30%."""


def _configure(r: np.void, cfg: MagnetometerCfg, start: SensorStart) -> None:
    dt_s = 1.0 / cfg.rate_hz
    r["field_enu_ut"] = start.field_enu_ut
    r["decay"], r["drift_sigma_ut"] = drift_terms(cfg.drift_density, cfg.drift_correlation_s, dt_s)
    r["noise_ut"] = cfg.noise_density / math.sqrt(dt_s)
    direction = start.rng.standard_normal(3)
    # Current grows with the cube of the rotor speed, so the kernel only sums cubes.
    strength = cfg.motor_ut_per_a * start.amperes_per_cubed_speed
    r["motor_flu_ut_s3"] = strength * direction / np.linalg.norm(direction)


@kernel
def sample_magnetometer(
    r: np.record,
    tick: int,
    qpos: np.ndarray,
    rotor_speed_radps: np.ndarray,
    steel: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Take one sample of the field, with the currents' and the steel's share in it.

    Args:
        r: Record of the sensor, which takes the sample.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        rotor_speed_radps: Speed of each rotor; the current goes with its cube.
        steel: Steel around the site (`flightsim.environment.steel`).
        normals: Standard normal numbers of the sensor.
    """
    R, field = r.R, r.work_vector
    matrix_from_quat(qpos[3:7], R)
    field[:] = r.field_enu_ut
    disturb(steel, qpos[0:3], r.field_enu_ut, field)
    cubes = 0.0
    for k in range(len(rotor_speed_radps)):
        cubes += abs(rotor_speed_radps[k]) ** 3
    advance_drift(r.drift_flu_ut, r.decay, r.drift_sigma_ut, normals, 3)
    for i in range(3):
        true = R[0, i] * field[0] + R[1, i] * field[1] + R[2, i] * field[2]
        motors = cubes * r.motor_flu_ut_s3[i]
        measured = true + motors + r.drift_flu_ut[i] + r.noise_ut * normals[i]
        r.field_flu_ut[i] = said(r, 0, tick, i, measured, normals)
    r.tick = tick


@kernel
def sense_magnetometer(
    r: np.record,
    f: np.record,
    tick: int,
    qpos: np.ndarray,
    rotor_speed_radps: np.ndarray,
    steel: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Measure if a sample is due, and let the filter use it.

    Args:
        r: Record of the sensor.
        f: Record of the filter.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        rotor_speed_radps: Speed of each rotor; the current goes with its cube.
        steel: Steel around the site (`flightsim.environment.steel`).
        normals: Standard normal numbers of the sensor.
    """
    if not is_due(r, tick):
        return
    sample_magnetometer(r, tick, qpos, rotor_speed_radps, steel, noise(r, tick, normals))
    if is_stuck(r, 0, r.field_flu_ut[0]):
        return
    if f.is_aligned == 1:
        fuse_magnetometer(f, r.field_flu_ut)
    else:
        collect_vector(f.mag_sum, r.field_flu_ut)
        f.n_mag += 1


class MagReading(NamedTuple):
    """Latest magnetic field in body axes, uT."""

    time_us: int
    field_flu_ut: Vector3


MAGNETOMETER = Sensor(
    name="mag",
    setting="magnetometer",
    fields=(
        *fields("field_flu_ut", "field_enu_ut", "drift_flu_ut", "drift_sigma_ut", shape=(3,)),
        *fields("motor_flu_ut_s3", "work_vector", shape=(3,)),
        *fields("decay", "noise_ut"),
        ("R", "f8", (3, 3)),
    ),
    n_normals=6,
    stream=5,
    configure=_configure,
    wrong=(15.0, 15.0, 0.0),  # a magnet beside it
    garbage=(100.0, 100.0, 100.0),
    read=reader(MagReading),
)
