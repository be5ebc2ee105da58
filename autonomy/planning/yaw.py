"""Heading along a path: towards the coming positions, within limits of rate and acceleration.

The forward camera must see the space ahead before the vehicle gets there. Pointing along the
velocity would turn too late at corners and jump near rest, so the heading follows the direction to
a position a little later on the path.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.planning.trajectory import YawProfile

LOOK_AHEAD_S = 0.8
STEP_S = 0.05  # spacing of the heading's table
_MIN_TRAVEL_M = 0.4
"""Least horizontal travel ahead that gives a direction; with less the heading stays."""
_BANDWIDTH_RADPS = 4.0  # of the filter; twice the damping ratio 1 makes its rate gain half of it


def yaw_along_path(
    positions_enu_m: Float[np.ndarray, "n 3"],
    start_yaw_rad: float,
    *,
    max_rate_radps: float,
    max_acceleration_radps2: float,
    start_rate_radps: float = 0.0,
) -> YawProfile:
    """Return the heading for positions sampled every `STEP_S`.

    A critically damped second-order filter with bounded rate and acceleration follows the direction
    to the position `LOOK_AHEAD_S` later, so that the camera sees the path ahead. The turn begins at
    once, even if the vehicle climbs or rests first.

    Args:
        positions_enu_m: Positions along the path.
        start_yaw_rad: Heading at the start.
        max_rate_radps: Limit of the yaw rate.
        max_acceleration_radps2: Limit of the yaw's acceleration.
        start_rate_radps: Yaw rate at the start.
    """
    wanted = _wanted_yaw(positions_enu_m, start_yaw_rad)
    rate = min(max(start_rate_radps, -max_rate_radps), max_rate_radps)
    yaw, out = start_yaw_rad, []
    for target in wanted:
        out.append(yaw)
        error = math.remainder(target - yaw, 2 * math.pi)
        rate = next_rate(rate, error, STEP_S, max_rate_radps, max_acceleration_radps2)
        yaw += rate * STEP_S
    return YawProfile(step_s=STEP_S, yaw_rad=np.array(out))


def next_rate(
    rate_radps: float,
    error_rad: float,
    step_s: float,
    max_rate_radps: float,
    max_acceleration_radps2: float,
) -> float:
    """The yaw rate after one step, given the angle left to turn, with bounded acceleration."""
    # Rate from which a stop at the target is still possible, with half of the acceleration as
    # reserve.
    stoppable = math.sqrt(2 * 0.5 * max_acceleration_radps2 * abs(error_rad))
    fastest = min(max_rate_radps, stoppable, 0.5 * _BANDWIDTH_RADPS * abs(error_rad))
    change = max_acceleration_radps2 * step_s
    return rate_radps + min(max(math.copysign(fastest, error_rad) - rate_radps, -change), change)


def _wanted_yaw(positions_enu_m: np.ndarray, start_yaw_rad: float) -> list[float]:
    ahead = round(LOOK_AHEAD_S / STEP_S)
    last = len(positions_enu_m) - 1
    later = positions_enu_m[np.minimum(np.arange(last + 1) + ahead, last)]
    travel = later - positions_enu_m
    is_moving = np.hypot(travel[:, 0], travel[:, 1]) >= _MIN_TRAVEL_M
    direction = np.arctan2(travel[:, 1], travel[:, 0])
    # The vehicle turns to its path before it departs.
    wanted, latest = [], float(direction[is_moving][0]) if is_moving.any() else start_yaw_rad
    for moves, angle in zip(is_moving.tolist(), direction.tolist(), strict=True):
        latest = angle if moves else latest
        wanted.append(latest)
    return wanted
