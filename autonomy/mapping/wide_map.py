"""Given map of a large place, whose distances are computed about each way before it is planned.

A coarse field of the whole place shows where a way leads, and only the fine cells about that way
are computed. If no way is found there, it is sought once more with more of the place about it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.mapping.coarse_way import SEARCH_EXCESS, coarse_way
from autonomy.mapping.map import GivenObstacles
from autonomy.planning.craft import Craft
from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.openings import Opening
from autonomy.planning.planner import plan_trajectory
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference, Vector3

NEAR_M, FAR_M = 8.0, 48.0
"""Distances from the coarse way within which a fine one is sought, at first and then."""
_PIECES = 16
"""Pieces into which a long way is cut at least. More would take the optimiser longer, and a long
leg is flown at one speed anyway."""
Build = Callable[[Float[np.ndarray, "n 3"], float], None]
"""Computes the distances of all cells that come within a distance of some points."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WideMap(GivenObstacles):
    """A map that was given before the flight, of a place too large to compute all its cells."""

    field: DistanceField
    """Distances of the cells that were computed, 0 in all others."""
    coarse: DistanceField
    """Distances of the whole place in larger cells."""
    radius_m: float
    """Radius of the vehicle's sphere."""
    build: Build
    """Computes more of `field`."""

    def plan(self, start: FlatReference, goal_enu_m: Vector3, craft: Craft) -> Trajectory:
        """Plan a certified trajectory, see `plan_trajectory`.

        Raises:
            PlanningError: If there is none within 48 m of the coarse way.
        """
        length_m = math.dist(start.position_enu_m, goal_enu_m)
        piece_m = max(craft.cfg.max_piece_m, length_m / _PIECES)
        cfg = dataclasses.replace(craft.cfg, search_excess=SEARCH_EXCESS, max_piece_m=piece_m)
        craft = dataclasses.replace(craft, cfg=cfg)
        for reach_m in (NEAR_M, FAR_M):
            self.build_between(start.position_enu_m, goal_enu_m, reach_m)
            try:
                return plan_trajectory(start, goal_enu_m, self.field, self.obstacles, craft)
            except UnreachableError:
                if reach_m == FAR_M:
                    raise
        raise AssertionError("the last reach returns or raises")

    def build_between(self, start_enu_m: Vector3, goal_enu_m: Vector3, reach_m: float) -> None:
        """Compute the distances about the way between two places."""
        ends = np.array([start_enu_m, goal_enu_m])
        if np.all(self.field.contains(ends)):
            self.build(coarse_way(self.coarse, ends, self.radius_m), reach_m)

    def find_openings(self) -> Sequence[Opening]:
        """None: a large place has too many cells to look at all of them."""
        return ()

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Whether the vehicle has room at a point; a plan finds out whether a way leads there."""
        self.build(np.array([point_enu_m]), 0.0)
        cell = tuple(self.field.cells(np.array(point_enu_m)))
        return bool(self.field.distance_m[cell] >= self.radius_m)
