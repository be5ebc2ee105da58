"""How near a plan comes to what moves, as predicted."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from autonomy.planning import FlightLimits, MovingObstacles, Trajectory

KEEP_FROM_MOVERS_M = 0.2
"""Between the vehicle's sphere and what moves: a plan that comes nearer is made anew. Less than a
new plan aims at, so that one is enough."""
URGENT_ACCELERATION_MPS2 = (5.0, 3.5)
"""Horizontal and vertical: out of somebody's way the vehicle may do more than on its way."""
_STEP_S = 0.1


def room_to_movers_m(
    trajectory: Trajectory, since_s: float, moving: MovingObstacles, radius_m: float
) -> float:
    """Least predicted distance of the vehicle to what moves, infinite where nothing does.

    Args:
        trajectory: What is flown; at its end the vehicle stands.
        since_s: Time of the trajectory at which the predictions begin.
        moving: What moves.
        radius_m: Of the vehicle's sphere.
    """
    if not len(moving):
        return math.inf
    times = np.arange(0.0, moving.horizon_s + _STEP_S / 2, _STEP_S)
    distances, _ = moving.distances(trajectory.positions(since_s + times), times)
    return float(distances.min()) - radius_m


def first_to_come(
    trajectory: Trajectory, since_s: float, moving: MovingObstacles, within_m: float
) -> tuple[float, float, float] | None:
    """Where somebody is who comes near soonest and is not past yet; None where nobody does.

    Args:
        trajectory: What is flown.
        since_s: Time of the trajectory at which the predictions begin.
        moving: What moves.
        within_m: Of the vehicle's centre counts as near.
    """
    if not len(moving):
        return None
    times = np.arange(0.0, moving.horizon_s + _STEP_S / 2, _STEP_S)
    distances, _ = moving.distances(trajectory.positions(since_s + times), times)
    nearest = np.argmin(distances, axis=1)
    comes = (distances.min(axis=1) < within_m) & (nearest > 0)
    if not np.any(comes):
        return None
    x, y, z = moving.position_enu_m[np.argmin(np.where(comes, nearest, len(times)))].tolist()
    return x, y, z


def with_less_room(moving: MovingObstacles, less_m: float) -> MovingObstacles:
    """The same, each smaller all around: for a way that passes nearer than is wanted."""
    return dataclasses.replace(moving, radius_m=moving.radius_m - less_m)


def urgent_limits(limits: FlightLimits) -> FlightLimits:
    """Limits of the motion out of somebody's way."""
    across, up = URGENT_ACCELERATION_MPS2
    return dataclasses.replace(
        limits,
        acceleration_mps2=max(across, limits.acceleration_mps2),
        acceleration_vertical_mps2=max(up, limits.acceleration_vertical_mps2),
    )
