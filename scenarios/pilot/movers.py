"""Predicted distances between a plan and movers.

Predictions are straight and short, so distances are sampled ten times a second instead of proved.
They only decide when to replan; the new plan itself is certified.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Float

from autonomy.planning import FlightLimits, MovingObstacles, Trajectory
from autonomy.types import Vector3

KEEP_FROM_MOVERS_M = 0.2
"""Distance from the vehicle's sphere to movers below which a plan is replaced; smaller than the
distance that a new plan aims at, so that one replan is enough."""
URGENT_ACCELERATION_MPS2 = (5.0, 3.5)
"""Horizontal and vertical limits of evasion, above those of normal flight."""
_STEP_S = 0.1


def room_to_movers_m(
    trajectory: Trajectory, since_s: float, moving: MovingObstacles, radius_m: float
) -> float:
    """Least predicted distance of the vehicle to movers, m; infinite without any.

    Args:
        trajectory: Present trajectory; the vehicle rests at its end.
        since_s: Time of the trajectory at which the predictions begin.
        moving: Movers.
        radius_m: Radius of the vehicle's sphere.
    """
    if not len(moving):
        return math.inf
    return float(_predicted_m(trajectory, since_s, moving).min()) - radius_m


def room_in_column_m(
    foot_enu_m: Vector3, height_m: float, moving: MovingObstacles, radius_m: float
) -> float:
    """Least predicted distance of movers to a vehicle anywhere in a column, infinite without any.

    Args:
        foot_enu_m: Lower end of the column that the vehicle's centre is in.
        height_m: Height of the upper end, ENU.
        moving: Movers.
        radius_m: Radius of the vehicle's sphere.
    """
    if not len(moving):
        return math.inf
    x, y, z = foot_enu_m
    times = np.arange(0.0, moving.horizon_s + _STEP_S / 2, _STEP_S)
    # Heights at most a radius apart, so that no mover slips between two of them.
    heights = np.linspace(z, max(height_m, z), 2 + math.ceil(max(height_m - z, 0.0) / radius_m))
    places = [np.broadcast_to((x, y, height), (len(times), 3)) for height in heights]
    return min(float(moving.distances(place, times)[0].min()) for place in places) - radius_m


def first_to_come(
    trajectory: Trajectory, since_s: float, moving: MovingObstacles, within_m: float
) -> Vector3 | None:
    """Position of the mover that comes near soonest and has not passed yet; None without one.

    Args:
        trajectory: Present trajectory.
        since_s: Time of the trajectory at which the predictions begin.
        moving: Movers.
        within_m: Distance from the vehicle's centre that counts as near.
    """
    if not len(moving):
        return None
    distances = _predicted_m(trajectory, since_s, moving)
    nearest = np.argmin(distances, axis=1)
    # A mover that is nearest at present has passed already.
    comes = (distances.min(axis=1) < within_m) & (nearest > 0)
    if not np.any(comes):
        return None
    x, y, z = moving.position_enu_m[
        np.argmin(np.where(comes, nearest, distances.shape[1]))
    ].tolist()
    return x, y, z


def _predicted_m(
    trajectory: Trajectory, since_s: float, moving: MovingObstacles
) -> Float[np.ndarray, "movers times"]:
    """Distances of the vehicle's centre to movers from now to the end of their predictions."""
    times = np.arange(0.0, moving.horizon_s + _STEP_S / 2, _STEP_S)
    return moving.distances(trajectory.positions(since_s + times), times)[0]


def with_less_room(moving: MovingObstacles, less_m: float) -> MovingObstacles:
    """Return the same movers, each reduced all around, to allow a path that passes nearer."""
    return dataclasses.replace(moving, radius_m=moving.radius_m - less_m)


def urgent_limits(limits: FlightLimits) -> FlightLimits:
    """Return the limits of the motion while evading; never below the usual ones."""
    across, up = URGENT_ACCELERATION_MPS2
    return dataclasses.replace(
        limits,
        acceleration_mps2=max(across, limits.acceleration_mps2),
        acceleration_vertical_mps2=max(up, limits.acceleration_vertical_mps2),
    )
