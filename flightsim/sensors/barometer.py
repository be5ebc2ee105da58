"""Barometer: static pressure of the standard atmosphere, with white noise and drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autonomy.jit import kernel
from flightsim.environment.atmosphere import pressure_altitude_m, pressure_pa, temperature_k
from flightsim.sensors.drift import drift_terms

BAROMETER_NORMALS = 2


@dataclass(frozen=True, kw_only=True, slots=True)
class BarometerCfg:
    """Noise of a barometer."""

    rate_hz: int = 50
    noise_pa: float = 1.0
    """RMS of a sample: PX4's gazebo-classic barometer, with a true normal law."""
    drift_density_pa: float = 0.0
    """Pa/s/sqrt(Hz)."""
    drift_correlation_s: float = 300.0


BAROMETER_DTYPE = np.dtype(
    [
        ("pressure_pa", "f8"),
        ("altitude_m", "f8"),
        ("temperature_degc", "f8"),
        ("tick", "i8"),
        ("drift_pa", "f8"),
        ("decay", "f8"),
        ("drift_sigma_pa", "f8"),
        ("noise_pa", "f8"),
        ("origin_altitude_m", "f8"),
        ("period_ticks", "i8"),
        ("is_enabled", "i8"),
    ],
    align=True,
)


def new_barometer(cfg: BarometerCfg, *, tick_hz: int, origin_altitude_m: float) -> np.ndarray:
    """A barometer in a scene whose z = 0 lies at an altitude, in an array of shape (1,)."""
    records = np.zeros(1, BAROMETER_DTYPE)
    r = records[0]
    r["decay"], r["drift_sigma_pa"] = drift_terms(
        cfg.drift_density_pa, cfg.drift_correlation_s, 1.0 / cfg.rate_hz
    )
    r["noise_pa"] = cfg.noise_pa
    r["origin_altitude_m"] = origin_altitude_m
    r["period_ticks"] = tick_hz // cfg.rate_hz
    r["is_enabled"] = 1
    r["tick"] = -1
    return records


@kernel
def sample_barometer(r: np.record, tick: int, height_enu_m: float, normals: np.ndarray) -> None:
    """Measure at a true height in the scene."""
    altitude = r.origin_altitude_m + height_enu_m
    r.drift_pa = r.decay * r.drift_pa + r.drift_sigma_pa * normals[1]
    r.pressure_pa = pressure_pa(altitude) + r.drift_pa + r.noise_pa * normals[0]
    r.altitude_m = pressure_altitude_m(r.pressure_pa)
    r.temperature_degc = temperature_k(altitude) - 273.15
    r.tick = tick
