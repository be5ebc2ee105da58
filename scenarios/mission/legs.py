"""Straight legs certified to be free, except near a surface that the vehicle stands on.

A certificate of the whole leg would always fail beside the surface that the vehicle leaves. Without
any certificate a branch above would go unseen. So only as much of the first stretch is exempt as
the vehicle's sphere needs.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from autonomy.planning import Craft, MovingObstacles, Obstacles, PlannerCfg, Trajectory
from autonomy.types import Vector3

_STEP_M = 0.05  # between the points at which room is sought
# No solids at all: the leg is first proved against limits and movers alone.
NOTHING_STANDS = Obstacles.boxes(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)))


class LegMaker(Protocol):
    """Maker of a straight leg from rest to rest."""

    def __call__(self, start_enu_m: Vector3, goal_enu_m: Vector3) -> Trajectory:
        """Make a leg between two positions, ENU, m."""
        ...


def certified(
    leg: LegMaker,
    ends_enu_m: tuple[Vector3, Vector3],
    obstacles: Obstacles,
    craft: Craft,
    *,
    moving: MovingObstacles,
    exempt_m: float,
) -> Trajectory:
    """Return a straight leg that keeps the limits and stays clear of static obstacles and movers.

    Args:
        leg: Makes the leg.
        ends_enu_m: Start and goal of the leg.
        obstacles: Static obstacles.
        craft: Limits, mass and size of the vehicle.
        moving: Movers, predicted from now on.
        exempt_m: Length of the leg that may be exempt from the check of static obstacles; no more
            than necessary is exempt.

    Raises:
        PlanningError: If the leg is not free or breaks a limit.
    """
    start_enu_m, goal_enu_m = ends_enu_m
    whole = leg(start_enu_m, goal_enu_m)
    craft.prove(whole, NOTHING_STANDS, moving=moving, margin_m=0.0)
    begin_enu_m = _first_free(start_enu_m, goal_enu_m, exempt_m, obstacles, craft.cfg)
    # Clearance from static obstacles depends on the path alone, not on its timing.
    proved = craft.prove(leg(begin_enu_m, goal_enu_m), obstacles)
    return replace(whole, min_clearance_m=proved.min_clearance_m)


def _first_free(
    start_enu_m: Vector3, goal_enu_m: Vector3, most_m: float, obstacles: Obstacles, cfg: PlannerCfg
) -> Vector3:
    """The first point of a line, within a distance of its start, with room for the vehicle."""
    start, way = np.array(start_enu_m), np.subtract(goal_enu_m, start_enu_m)
    length_m = float(np.linalg.norm(way))
    if most_m == 0.0 or length_m == 0.0:
        return start_enu_m
    along_m = np.arange(0.0, min(most_m, length_m), _STEP_M)
    points = start + np.outer(along_m / length_m, way)
    room_m = obstacles.signed_distance(points)[0] - cfg.vehicle_radius_m
    # The certificate is a lower bound, so demand a little more.
    has_room = room_m > cfg.min_margin_m + _STEP_M
    x, y, z = points[np.argmax(has_room) if has_room.any() else -1].tolist()
    return (x, y, z)
