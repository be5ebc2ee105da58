"""Health of the estimate, read out of the filter's record on request."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.types import Vector3
from flightsim.sensors.sensor import numbers

MAX_HORIZONTAL_SIGMA_M = 5.0
"""Horizontal standard deviation beyond which the position counts as lost: after some ten seconds
without a fix."""
DEAD_RECKONING_S = 1.5
"""Time without a measured position after which the estimate rests on inertial sensors alone. A
receiver that is silent every other second stays below it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimatorStatus:
    """Health of the estimate; a ratio of an innovation to its gate is accepted below 1."""

    is_attitude_valid: bool
    is_position_valid: bool
    is_dead_reckoning: bool
    """True if neither satellites nor odometry nor a client have measured the position recently."""
    sigma_horizontal_m: float
    sigma_vertical_m: float
    sigma_velocity_mps: float
    sigma_tilt_rad: float
    sigma_yaw_rad: float
    gnss_age_s: float
    """Time since the last accepted fix."""
    gnss_position_ratio: float
    gnss_velocity_ratio: float
    baro_ratio: float
    heading_ratio: float
    gyro_bias_flu_radps: Vector3
    accel_bias_flu_mps2: Vector3


_numbers = numbers(
    *("is_aligned", "tick", "last_gnss_tick", "last_position_tick"),
    *("gyro_bias_flu_radps", "accel_bias_flu_mps2"),
    *("ratio_gnss_position", "ratio_gnss_velocity", "ratio_baro", "ratio_heading"),
)


def estimator_status(f: np.void, tick_us: int) -> EstimatorStatus:
    """Return the status of an estimator: its validity, its deviations and its test ratios.

    Args:
        f: Record of `FILTER_DTYPE`.
        tick_us: Length of its ticks.
    """
    # Order of the error state: position, velocity, attitude; three each.
    v = f["covariance"].diagonal()[:9].tolist()
    is_aligned, tick, last_gnss_tick, last_tick, gyro_bias, accel_bias, *ratios = _numbers(f)
    gnss_position, gnss_velocity, baro, heading = ratios
    sigma_horizontal = math.sqrt(v[0] + v[1]) if is_aligned else math.inf
    return EstimatorStatus(
        is_attitude_valid=bool(is_aligned),
        is_position_valid=sigma_horizontal < MAX_HORIZONTAL_SIGMA_M,
        is_dead_reckoning=bool(is_aligned)
        and (tick - last_tick) * tick_us * 1e-6 > DEAD_RECKONING_S,
        sigma_horizontal_m=sigma_horizontal,
        sigma_vertical_m=math.sqrt(v[2]) if is_aligned else math.inf,
        sigma_velocity_mps=math.sqrt(v[3] + v[4] + v[5]) if is_aligned else math.inf,
        sigma_tilt_rad=math.sqrt(v[6] + v[7]) if is_aligned else math.inf,
        sigma_yaw_rad=math.sqrt(v[8]) if is_aligned else math.inf,
        gnss_age_s=(tick - last_gnss_tick) * tick_us * 1e-6,
        gnss_position_ratio=gnss_position,
        gnss_velocity_ratio=gnss_velocity,
        baro_ratio=baro,
        heading_ratio=heading,
        gyro_bias_flu_radps=gyro_bias,
        accel_bias_flu_mps2=accel_bias,
    )
