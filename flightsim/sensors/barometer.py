"""Barometer: static pressure of the standard atmosphere, with white noise and drift.

The true height gives the true pressure, and errors are added to the pressure rather than to the
height. The pressure that MAVLink reports and the altitude that the filter reads, which the standard
atmosphere assigns to the measured pressure, then have the same error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autonomy.estimation.fusion import fuse_barometer
from autonomy.jit import fields, kernel
from flightsim.environment.atmosphere import pressure_altitude_m, pressure_pa, temperature_k
from flightsim.sensors.drift import drift_terms
from flightsim.sensors.failure import is_stuck, said
from flightsim.sensors.sensor import Sensor, SensorStart, is_due, noise, reader


@dataclass(frozen=True, kw_only=True, slots=True)
class BarometerCfg:
    """Noise of a barometer."""

    rate_hz: int = 50
    noise_pa: float = 1.0
    """RMS of a sample: PX4's gazebo-classic barometer, with a true normal law."""
    drift_density_pa: float = 0.0
    """Density of the noise that drives the drift, Pa/s/sqrt(Hz); 0 for no drift."""
    drift_correlation_s: float = 300.0
    """Time after which the drift has forgotten 1 - 1/e of its value."""


def _configure(r: np.void, cfg: BarometerCfg, start: SensorStart) -> None:
    density, correlation_s = cfg.drift_density_pa, cfg.drift_correlation_s
    r["decay"], r["drift_sigma_pa"] = drift_terms(density, correlation_s, 1.0 / cfg.rate_hz)
    r["origin_altitude_m"] = start.altitude_m


@kernel
def sample_barometer(r: np.record, tick: int, height_enu_m: float, normals: np.ndarray) -> None:
    """Take one sample, whose altitude is that of the standard atmosphere at the measured pressure.

    Args:
        r: Record of the sensor, which takes the sample.
        tick: Number of the control tick.
        height_enu_m: True height above the scene's origin.
        normals: Standard normal numbers; the first two are used.
    """
    altitude = r.origin_altitude_m + height_enu_m
    r.drift_pa = r.decay * r.drift_pa + r.drift_sigma_pa * normals[1]
    measured_pa = pressure_pa(altitude) + r.drift_pa + r.noise_pa * normals[0]
    r.pressure_pa = said(r, 0, tick, 0, measured_pa, normals)
    r.altitude_m = pressure_altitude_m(r.pressure_pa)
    r.temperature_degc = temperature_k(altitude) - 273.15
    r.tick = tick


@kernel
def sense_barometer(
    r: np.record, f: np.record, tick: int, qpos: np.ndarray, normals: np.ndarray
) -> None:
    """Measure if a sample is due, and let the filter use it.

    Before the filter is aligned, samples are summed for its first height.

    Args:
        r: Record of the sensor.
        f: Record of the filter.
        tick: Number of the control tick.
        qpos: True pose of the vehicle, (7,).
        normals: Standard normal numbers of the sensor.
    """
    if not is_due(r, tick):
        return
    sample_barometer(r, tick, qpos[2], noise(r, tick, normals))
    if is_stuck(r, 0, r.pressure_pa):
        return
    if f.is_aligned == 1:
        fuse_barometer(f, r.altitude_m)
    else:
        f.baro_sum += r.altitude_m
        f.n_baro += 1


class BaroReading(NamedTuple):
    """Static pressure and the altitude above mean sea level that the standard gives it."""

    time_us: int
    pressure_pa: float
    altitude_m: float
    temperature_degc: float


BAROMETER = Sensor(
    name="baro",
    setting="barometer",
    fields=(
        *fields("pressure_pa", "altitude_m", "temperature_degc"),
        *fields("drift_pa", "decay", "drift_sigma_pa", "noise_pa", "origin_altitude_m"),
    ),
    n_normals=2,
    stream=4,
    configure=_configure,
    wrong=(-120.0,),  # 10 m up
    garbage=(5e4,),
    read=reader(BaroReading),
)
