"""How near a plan comes to what moves, as predicted."""

from __future__ import annotations

import math

import numpy as np

from autonomy.planning import MovingObstacles, Trajectory

KEEP_FROM_MOVERS_M = 0.2
"""Between the vehicle's sphere and what moves: a plan that comes nearer is made anew. Less than a
new plan aims at, so that one is enough."""
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
