"""Optical flow: angular rate at which the ground passes a sensor that looks along body -z.

    symbol   name                                             frame     unit
    w        angular rate                                     body FRD  rad/s
    v        velocity                                         body FRD  m/s
    d        distance along the ray to the ground                       m
    f        rate of flow, (w_x - v_y / d, w_y + v_x / d)     body FRD  rad/s

A right-handed turn about an axis and a flow in its sense are positive, as OPTICAL_FLOW_RAD of
MAVLink and SensorOpticalFlow of PX4 define it (docs.px4.io, msg_docs/SensorOpticalFlow).

The flow follows from the optical axis alone. Rendering an image for each sample would cost far
more, and a filter would see the same number. The price is that all ground counts as at rest and as
rich in texture. The gyroscope beside the eye is the vehicle's own, summed over the same time.

The distance is measured with each sample and held until the next. Close to the ground, far above
it, or where it passes too fast, the sensor reports a quality of zero.

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
    """True if the vehicle carries the sensor from the start."""
    rate_hz: int = 50
    noise_radps: float = 0.05
    """Standard deviation of the mean rate in a sample. PX4's filter takes 0.15 rad/s at the best
    quality (EKF2_OF_N_MIN), three of these."""
    min_distance_m: float = 0.08
    """Distance below which the sensor sees no flow."""
    max_distance_m: float = 30.0
    """Reach, which is that of the rangefinder beside the eye."""
    max_rate_radps: float = 7.4
    """Fastest flow of either axis that the sensor can follow."""


class OpticalFlowReading(NamedTuple):
    """A sample; angles are sums over `integration_us` that end at `time_us`."""

    time_us: int
    integration_us: int
    flow_frd_rad: tuple[float, float]
    """Flow about the axes forward and right; zero if the quality is zero."""
    gyro_frd_rad: tuple[float, float, float]
    """Turn about the axes forward, right and down."""
    distance_m: float
    """Distance to the ground along the ray; infinite beyond reach, NaN before the first sample."""
    quality: int
    """0 if some flow in the interval could not be seen, otherwise 255."""


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
    """Add the flow and the turn of one control tick to the sums of the running sample.

    Args:
        r: Record of the sensor, with `seen_m`, the true distance to the ground; changed.
        quat_wxyz: True attitude, body FLU to world ENU.
        velocity_enu_mps: True velocity.
        rate_flu_radps: True angular rate.
        gyro_flu_radps: Angular rate that the IMU measures.
        dt_s: Length of the tick.
    """
    w, x, y, z = quat_wxyz[0], quat_wxyz[1], quat_wxyz[2], quat_wxyz[3]
    v = velocity_enu_mps
    # Velocity along body x and y: first two columns of the rotation matrix times the velocity.
    forward_mps = (1.0 - 2.0 * (y * y + z * z)) * v[0] + 2.0 * (x * y + w * z) * v[1]
    forward_mps += 2.0 * (x * z - w * y) * v[2]
    leftward_mps = 2.0 * (x * y - w * z) * v[0] + (1.0 - 2.0 * (x * x + z * z)) * v[1]
    leftward_mps += 2.0 * (y * z + w * x) * v[2]
    is_seen = r.min_distance_m <= r.seen_m <= r.max_distance_m
    # The signs change from FLU to FRD: y and z of the body point the other way.
    about_x = rate_flu_radps[0] + (leftward_mps / r.seen_m if is_seen else 0.0)
    about_y = -rate_flu_radps[1] + (forward_mps / r.seen_m if is_seen else 0.0)
    if not is_seen or max(abs(about_x), abs(about_y)) > r.max_rate_radps:
        r.has_lost = 1
    r.passed_frd_rad[0] += about_x * dt_s
    r.passed_frd_rad[1] += about_y * dt_s
    r.turned_frd_rad[0] += gyro_flu_radps[0] * dt_s
    r.turned_frd_rad[1] -= gyro_flu_radps[1] * dt_s
    r.turned_frd_rad[2] -= gyro_flu_radps[2] * dt_s


@kernel
def sample_optical_flow(r: np.record, tick: int, period_s: float, normals: np.ndarray) -> None:
    """Finish the sample that began `period_s` ago and start the next one.

    A sample during which the ground was lost once has quality 0 and no flow.

    Args:
        r: Record of the sensor.
        tick: Number of the control tick.
        period_s: Time over which the flow was summed up.
        normals: Standard normal numbers; the first two are used.
    """
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
    """Return the size of the mean rate of flow in rad/s; NaN before the first sample."""
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
        # sums since the last sample: flow, turn by the gyroscope; 1 if any flow was not seen
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
