"""Downward rangefinder along body -z: distance to what a ray from the centre of mass hits.

The plant casts the ray (`flightsim.plant.rays`), because only it knows the solids. This module aims
the ray and turns the true distance into a reading.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.jit import fields, kernel
from flightsim.sensors.failure import said
from flightsim.sensors.sensor import Sensor, SensorStart


@dataclass(frozen=True, kw_only=True, slots=True)
class RangefinderCfg:
    """A small laser rangefinder."""

    rate_hz: int = 50
    max_range_m: float = 30.0
    """Range of the sensor; the reading is infinite if there is nothing within it."""
    noise_m: float = 0.01
    """Standard deviation at short distances."""
    relative_noise: float = 0.003
    """Share of the distance that is added to `noise_m` in quadrature."""


def _configure(r: np.void, _cfg: RangefinderCfg, _start: SensorStart) -> None:
    r["range_m"] = math.nan


@kernel
def aim_ray(r: np.record, position_enu_m: np.ndarray, q: np.ndarray) -> None:
    """Point the ray from a true pose; `r.ray` becomes origin and direction (body -z) in the world.

    Args:
        r: Record of the sensor; changed.
        position_enu_m: True position of the centre of mass, shape (3,).
        q: True attitude (w, x, y, z), body FLU to world ENU.
    """
    for i in range(3):
        r.ray[i] = position_enu_m[i]
    # The third column of the rotation matrix, negated.
    r.ray[3] = -2.0 * (q[1] * q[3] + q[0] * q[2])
    r.ray[4] = -2.0 * (q[2] * q[3] - q[0] * q[1])
    r.ray[5] = -1.0 + 2.0 * (q[1] * q[1] + q[2] * q[2])


@kernel
def sample_rangefinder(r: np.record, tick: int, distance_m: float, normals: np.ndarray) -> None:
    """Turn a true distance along the ray into a reading.

    Args:
        r: Record of the sensor; changed.
        tick: Present tick.
        distance_m: True distance; negative if the ray meets nothing.
        normals: At least one standard normal.
    """
    r.tick = tick
    relative = r.relative_noise * distance_m
    sigma = math.sqrt(r.noise_m * r.noise_m + relative * relative)
    measured_m = distance_m + sigma * normals[0]
    # The true distance decides, not the noisy one: otherwise readings flicker at the limit.
    if distance_m < 0.0 or distance_m > r.max_range_m:
        measured_m = math.inf
    r.range_m = max(0.0, said(r, 0, tick, 0, measured_m, normals))


RANGEFINDER = Sensor(
    name="range",
    setting="rangefinder",
    fields=(
        *fields("range_m", "max_range_m", "noise_m", "relative_noise"),
        ("ray", "f8", 6),  # origin and direction in the world
    ),
    n_normals=1,
    stream=6,
    configure=_configure,
    wrong=(2.0,),
    garbage=(15.0,),
    read=lambda r, _: float(r["range_m"]),
    gauge=("range m", lambda range_m: range_m),
)
