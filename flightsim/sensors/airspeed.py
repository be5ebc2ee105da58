"""Airspeed: a pitot tube along body x, the pressure at its nose over that of the air around it.

    symbol   name                                          unit
    v        forward speed through the air (along body x)  m/s
    rho      density of the air                            kg/m^3
    q        differential pressure, sign(v) rho v^2 / 2    Pa

A sample has white noise and constant errors of zero and span. The indicated speed assumes the
density at sea level, so that it is below v in thin air.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autonomy.jit import fields, kernel
from flightsim.environment.atmosphere import AIR_DENSITY_KGPM3, pressure_pa, temperature_k
from flightsim.sensors.failure import said
from flightsim.sensors.sensor import Sensor, SensorStart, is_due, noise, reader

_GAS_CONSTANT_JPKGK = 287.053
"""Specific gas constant of dry air."""


@dataclass(frozen=True, kw_only=True, slots=True)
class AirspeedCfg:
    """Errors of a pitot tube and of its pressure sensor."""

    rate_hz: int = 50
    """Samples a second; it must divide the control rate."""
    noise_pa: float = 1.0
    """RMS of a sample: 0.01 hPa in PX4's simulated sensor (SensorAirspeedSim.cpp) and in its plugin
    for Gazebo Classic (gazebo_airspeed_plugin.cpp)."""
    zero_sigma_pa: float = 0.1
    """Reading in still air, drawn once: half of the 0.2 Pa stated for the ThunderFly TFPITOT01, a
    pitot tube with a Sensirion SDP33 (docs.thunderfly.cz/avionics/TFPITOT01)."""
    span_sigma: float = 0.015
    """Error of the scale, drawn once: half of the 3 % of the measured value stated for the same."""


def _configure(r: np.void, cfg: AirspeedCfg, start: SensorStart) -> None:
    r["zero_pa"] = cfg.zero_sigma_pa * start.rng.standard_normal()
    r["span"] = 1.0 + cfg.span_sigma * start.rng.standard_normal()
    r["origin_altitude_m"] = start.altitude_m


@kernel
def sample_airspeed(
    r: np.record,
    tick: int,
    height_enu_m: float,
    quat_wxyz: np.ndarray,
    air_velocity_enu_mps: np.ndarray,
    velocity_enu_mps: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Take one sample from the true state of a vehicle in moving air, and write it into the record.

    Args:
        r: Record of the sensor; changed.
        tick: Present control tick, which becomes the time of the sample.
        height_enu_m: True height above the scene's origin, m.
        quat_wxyz: True attitude, body FLU to world ENU.
        air_velocity_enu_mps: Velocity of the air at the vehicle, m/s.
        velocity_enu_mps: True velocity of the vehicle, m/s.
        normals: At least one standard normal number.
    """
    w, x, y, z = quat_wxyz[0], quat_wxyz[1], quat_wxyz[2], quat_wxyz[3]
    v, air = velocity_enu_mps, air_velocity_enu_mps
    # Airspeed along body x: first column of the rotation matrix times the relative velocity.
    speed = (1.0 - 2.0 * (y * y + z * z)) * (v[0] - air[0])
    speed += 2.0 * (x * y + w * z) * (v[1] - air[1]) + 2.0 * (x * z - w * y) * (v[2] - air[2])
    altitude_m = r.origin_altitude_m + height_enu_m
    density = pressure_pa(altitude_m) / (_GAS_CONSTANT_JPKGK * temperature_k(altitude_m))
    # speed * |speed| keeps the sign: air from behind lowers the pressure at the nose.
    dynamic_pa = 0.5 * density * speed * abs(speed)
    measured_pa = r.span * dynamic_pa + r.zero_pa + r.noise_pa * normals[0]
    r.differential_pa = said(r, 0, tick, 0, measured_pa, normals)
    # The instrument knows no altitude, so it converts with the density at sea level.
    indicated = math.sqrt(2.0 * abs(r.differential_pa) / AIR_DENSITY_KGPM3)
    r.indicated_mps = math.copysign(indicated, r.differential_pa)
    r.temperature_degc = temperature_k(altitude_m) - 273.15
    r.tick = tick


@kernel
def sense_airspeed(
    r: np.record,
    tick: int,
    qpos: np.ndarray,
    qvel: np.ndarray,
    air_velocity_enu_mps: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Measure if a sample is due; the filter estimates the wind without it.

    Args:
        r: Record of the sensor, which takes the sample.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        qvel: True velocity of the vehicle, (6,), of which the first three are ENU.
        air_velocity_enu_mps: Velocity of the air around it.
        normals: Standard normal numbers of the sensor.
    """
    if is_due(r, tick):
        row = noise(r, tick, normals)
        sample_airspeed(r, tick, qpos[2], qpos[3:7], air_velocity_enu_mps, qvel[0:3], row)


class AirspeedReading(NamedTuple):
    """Differential pressure, and the forward speed through the air that it stands for."""

    time_us: int
    differential_pa: float
    indicated_mps: float
    """Speed that the pressure stands for at sea level; negative when the air comes from behind."""
    temperature_degc: float


AIRSPEED = Sensor(
    name="airspeed",
    setting="airspeed",
    fields=(
        *fields("differential_pa", "indicated_mps", "temperature_degc"),
        *fields("noise_pa", "zero_pa", "span", "origin_altitude_m"),
    ),
    n_normals=1,
    stream=12,
    configure=_configure,
    wrong=(60.0,),  # 10 m/s in still air
    garbage=(500.0,),
    read=reader(AirspeedReading),
    gauge=("airspeed m/s", lambda reading: reading.indicated_mps),
)
