"""Optical flow: how fast what lies below passes the eye of a sensor that looks along body -z.

    symbol   name                                             frame     unit
    w        angular rate                                     body FRD  rad/s
    v        velocity                                         body FRD  m/s
    d        distance along the ray to what is below                    m
    f        rate of flow, (w_x - v_y / d, w_y + v_x / d)     body FRD  rad/s

A right-handed turn about an axis and a flow in its sense are positive, as OPTICAL_FLOW_RAD of
MAVLink and SensorOpticalFlow of PX4 define it (docs.px4.io, msg_docs/SensorOpticalFlow). It follows
from the optical axis alone: all below counts as at rest, and as rich in texture. The gyroscope
beside the eye is the vehicle's own, summed over the same time.

The distance is measured with each sample, and taken to stay so until the next. Near the ground and
far above, or where things pass too fast for it, the sensor says that its quality is zero.

Source of the limits: PixArt's PMW3901 and PAA3905 as PX4 and their makers state them: 0.08 m, 7.4
rad/s (github.com/PX4/PX4-Autopilot, src/drivers/optical_flow; github.com/kriswiner/PAA3905).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autonomy.jit import fields, kernel
from flightsim.sensors.failure import said
from flightsim.sensors.sensor import Sensor, SensorStart, reader


@dataclass(frozen=True, kw_only=True, slots=True)
class OpticalFlowCfg:
    """A sensor of optical flow with a gyroscope and a rangefinder of its own."""

    is_fitted: bool = False
    """Whether the vehicle carries it from the start."""
    rate_hz: int = 50
    noise_radps: float = 0.05
    """Standard deviation of the mean rate in a sample. PX4's filter takes 0.15 rad/s at the best
    quality (EKF2_OF_N_MIN), three of these."""
    min_distance_m: float = 0.08
    max_distance_m: float = 30.0
    """Reach: that of the rangefinder beside it."""
    max_rate_radps: float = 7.4


class OpticalFlowReading(NamedTuple):
    """A sample; angles are sums over `integration_us` that end at `time_us`."""

    time_us: int
    integration_us: int
    flow_frd_rad: tuple[float, float]
    """Flow about the axes forward and right; zero while the quality is."""
    gyro_frd_rad: tuple[float, float, float]
    """Turn about the axes forward, right and down."""
    distance_m: float
    """To what lies below; infinite beyond reach, NaN before the first sample."""
    quality: int
    """0 if there is no flow to see, else 255."""


BEST_QUALITY = 255


def _configure(r: np.void, _cfg: OpticalFlowCfg, _start: SensorStart) -> None:
    r["distance_m"] = r["seen_m"] = math.nan


@kernel
def follow_flow(
    r: np.record,
    quat_wxyz: np.ndarray,
    velocity_enu_mps: np.ndarray,
    rate_flu_radps: np.ndarray,
    gyro_flu_radps: np.ndarray,
    dt_s: float,
) -> None:
    """Add what passes in a control tick.

    Args:
        r: The sensor with `seen_m`, the distance to what is below; changed.
        quat_wxyz: True attitude, body to world.
        velocity_enu_mps: True velocity.
        rate_flu_radps: True angular rate.
        gyro_flu_radps: What the gyroscope measures of it.
        dt_s: Length of the tick.
    """
    w, x, y, z = quat_wxyz[0], quat_wxyz[1], quat_wxyz[2], quat_wxyz[3]
    v = velocity_enu_mps
    forward = (1.0 - 2.0 * (y * y + z * z)) * v[0] + 2.0 * (x * y + w * z) * v[1]
    forward += 2.0 * (x * z - w * y) * v[2]
    left = 2.0 * (x * y - w * z) * v[0] + (1.0 - 2.0 * (x * x + z * z)) * v[1]
    left += 2.0 * (y * z + w * x) * v[2]
    is_seen = r.min_distance_m <= r.seen_m <= r.max_distance_m
    about_x = rate_flu_radps[0] + (left / r.seen_m if is_seen else 0.0)
    about_y = -rate_flu_radps[1] + (forward / r.seen_m if is_seen else 0.0)
    if not is_seen or max(abs(about_x), abs(about_y)) > r.max_rate_radps:
        r.has_lost = 1
    r.passed_frd_rad[0] += about_x * dt_s
    r.passed_frd_rad[1] += about_y * dt_s
    r.turned_frd_rad[0] += gyro_flu_radps[0] * dt_s
    r.turned_frd_rad[1] -= gyro_flu_radps[1] * dt_s
    r.turned_frd_rad[2] -= gyro_flu_radps[2] * dt_s


@kernel
def sample_optical_flow(r: np.record, tick: int, period_s: float, normals: np.ndarray) -> None:
    """Measure what has passed since the sample before, `period_s` ago."""
    r.quality = BEST_QUALITY if r.has_lost == 0 else 0
    for i in range(2):
        flow = r.passed_frd_rad[i] + r.noise_radps * period_s * normals[i]
        r.flow_frd_rad[i] = said(r, 0, tick, i, flow if r.quality > 0 else 0.0, normals)
        r.passed_frd_rad[i] = 0.0
    for i in range(3):
        r.gyro_frd_rad[i], r.turned_frd_rad[i] = r.turned_frd_rad[i], 0.0
    is_near = 0.0 <= r.seen_m <= r.max_distance_m
    r.distance_m = r.seen_m if is_near else math.inf
    r.integration_us = round(1e6 * period_s)
    r.has_lost = 0
    r.tick = tick


def _rate_radps(reading: OpticalFlowReading) -> float:
    """Size of the mean rate of flow; NaN before the first sample."""
    if reading.integration_us == 0:
        return math.nan
    return math.hypot(*reading.flow_frd_rad) / (1e-6 * reading.integration_us)


OPTICAL_FLOW = Sensor(
    name="optical_flow",
    setting="optical_flow",
    fields=(
        *fields("noise_radps", "min_distance_m", "max_distance_m", "max_rate_radps"),
        ("distance_m", "f8"),
        *fields("quality", "integration_us", kind="i8"),
        ("flow_frd_rad", "f8", 2),
        ("gyro_frd_rad", "f8", 3),
        # since the last sample: flow, turn by the gyroscope, whether any of it was not seen
        ("passed_frd_rad", "f8", 2),
        ("turned_frd_rad", "f8", 3),
        ("has_lost", "i8"),
        ("seen_m", "f8"),  # true distance, negative for nothing
        ("ray", "f8", 6),  # origin and direction in the world
    ),
    n_normals=2,
    stream=15,
    configure=_configure,
    read=reader(OpticalFlowReading),
    wrong=(0.02, 0.02),
    garbage=(0.1, 0.1),
    gauge=("flow rad/s", _rate_radps),
)
