"""Magnetometer: the Earth's field in body axes, with white noise and drift."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.jit import kernel
from autonomy.model.quadrotor import Vector3
from autonomy.rotation import matrix_from_quat
from flightsim.sensors.drift import advance_drift, drift_terms

MAGNETOMETER_NORMALS = 6


@dataclass(frozen=True, kw_only=True, slots=True)
class MagnetometerCfg:
    """Noise of a magnetometer: PX4's gazebo-classic (0.4e-3 gauss/sqrt(Hz) is 0.04 uT)."""

    rate_hz: int = 50
    noise_density: float = 0.04
    """uT/sqrt(Hz)."""
    drift_density: float = 6.4e-4
    """uT/s/sqrt(Hz)."""
    drift_correlation_s: float = 600.0


MAGNETOMETER_DTYPE = np.dtype(
    [
        ("field_flu_ut", "f8", 3),
        ("tick", "i8"),
        ("field_enu_ut", "f8", 3),
        ("drift_flu_ut", "f8", 3),
        ("decay", "f8"),
        ("drift_sigma_ut", "f8", 3),
        ("noise_ut", "f8"),
        ("period_ticks", "i8"),
        ("is_enabled", "i8"),
        ("R", "f8", (3, 3)),
    ],
    align=True,
)


def new_magnetometer(cfg: MagnetometerCfg, *, tick_hz: int, field_enu_ut: Vector3) -> np.ndarray:
    """A magnetometer in a uniform field, in an array of shape (1,)."""
    records = np.zeros(1, MAGNETOMETER_DTYPE)
    r = records[0]
    dt_s = 1.0 / cfg.rate_hz
    r["field_enu_ut"] = field_enu_ut
    r["decay"], r["drift_sigma_ut"] = drift_terms(cfg.drift_density, cfg.drift_correlation_s, dt_s)
    r["noise_ut"] = cfg.noise_density / math.sqrt(dt_s)
    r["period_ticks"] = tick_hz // cfg.rate_hz
    r["is_enabled"] = 1
    r["tick"] = -1
    return records


@kernel
def sample_magnetometer(
    r: np.record, tick: int, quat_wxyz: np.ndarray, normals: np.ndarray
) -> None:
    """Measure at a true attitude."""
    R, field = r.R, r.field_enu_ut
    matrix_from_quat(quat_wxyz, R)
    advance_drift(r.drift_flu_ut, r.decay, r.drift_sigma_ut, normals, 3)
    for i in range(3):
        true = R[0, i] * field[0] + R[1, i] * field[1] + R[2, i] * field[2]
        r.field_flu_ut[i] = true + r.drift_flu_ut[i] + r.noise_ut * normals[i]
    r.tick = tick
