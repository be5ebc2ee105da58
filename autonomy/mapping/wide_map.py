"""Given map of a large place, whose distances are computed about each path before it is planned.

A district has more fine cells than can be computed before a flight. A coarse field of the whole
place shows where a path leads, and only the fine cells about that path are computed. If there is no
path among those, the search is repeated once with more of the place around it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.mapping.coarse_path import SEARCH_EXCESS, coarse_path
from autonomy.mapping.map import GivenObstacles
from autonomy.planning.craft import Craft
from autonomy.planning.errors import UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.openings import Opening, find_openings
from autonomy.planning.planner import plan_trajectory
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference, Vector3

NEAR_M, FAR_M = 8.0, 48.0
"""Distances from the coarse path within which a fine one is sought: at first, and if that fails."""
_PIECES = 16
"""Pieces into which a long path is cut at least. More would take the optimiser longer, and a long
leg is flown at one speed anyway."""
_ABOUT_OPENING_M = 8.0
"""Distance about a place within which its openings are sought: enough to measure them."""
_POINTS_AT_ONCE = 32
"""Number of points about which openings are sought in one part of the field."""

Build = Callable[[Float[np.ndarray, "n 3"], float], None]
"""Function that computes the distances of all cells within a distance of some points, m, ENU."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WideMap(GivenObstacles):
    """Map that was given before the flight, of a place too large to compute all its cells."""

    field: DistanceField
    """Distances of the cells that were computed; 0 in all others, so that no path leads there."""
    coarse: DistanceField
    """Distances of the whole place in larger cells."""
    radius_m: float
    """Radius of the vehicle's sphere."""
    build: Build
    """Function that computes more of `field`."""

    def plan(self, start: FlatReference, goal_enu_m: Vector3, craft: Craft) -> Trajectory:
        """Plan a certified trajectory, see `plan_trajectory`.

        Args:
            start: State of the vehicle.
            goal_enu_m: Position to go to, at rest.
            craft: Vehicle that flies.

        Raises:
            PlanningError: If there is none within 48 m of the coarse path.
        """
        length_m = math.dist(start.position_enu_m, goal_enu_m)
        # The optimiser's time grows with the number of pieces, which depends on the length here.
        piece_m = max(craft.cfg.max_piece_m, length_m / _PIECES)
        cfg = dataclasses.replace(craft.cfg, search_excess=SEARCH_EXCESS, max_piece_m=piece_m)
        craft = dataclasses.replace(craft, cfg=cfg)
        # Cells cost more than a search, so few are computed as long as they are enough.
        for reach_m in (NEAR_M, FAR_M):
            self.build_between(start.position_enu_m, goal_enu_m, reach_m)
            try:
                return plan_trajectory(start, goal_enu_m, self.field, self.obstacles, craft)
            except UnreachableError:
                if reach_m == FAR_M:
                    raise
        raise AssertionError("the last reach returns or raises")

    def build_between(self, start_enu_m: Vector3, goal_enu_m: Vector3, reach_m: float) -> None:
        """Compute the distances around the coarse path between two places.

        Args:
            start_enu_m: One end; nothing is computed if either end is off the map.
            goal_enu_m: The other end.
            reach_m: Distance from the path up to which cells are computed.
        """
        ends = np.array([start_enu_m, goal_enu_m])
        if np.all(self.field.contains(ends)):
            self.build(coarse_path(self.coarse, ends, self.radius_m), reach_m)

    def find_openings(self) -> Sequence[Opening]:
        """Return none: in a large place, ask `openings_about` for those along a path."""
        return ()

    def openings_about(self, points_enu_m: Float[np.ndarray, "n 3"]) -> Sequence[Opening]:
        """Find the openings around some points, which follow each other along a path."""
        self.build(points_enu_m, _ABOUT_OPENING_M)
        # Points far apart are parts of different paths: a field between them would be for nothing.
        gaps_m = np.linalg.norm(np.diff(points_enu_m, axis=0), axis=1)
        # An opening that two parts find counts once, by its centre.
        found: dict[Vector3, Opening] = {}
        for run in np.split(points_enu_m, np.flatnonzero(gaps_m > _ABOUT_OPENING_M) + 1):
            for n in range(0, len(run), _POINTS_AT_ONCE):
                part = self.field.part_about(run[n : n + _POINTS_AT_ONCE], _ABOUT_OPENING_M)
                found |= {each.center_enu_m: each for each in find_openings(part, self.obstacles)}
        return tuple(found.values())

    def may_be_reached(self, point_enu_m: Vector3) -> bool:
        """Return whether the vehicle has room at a point.

        Only a plan finds out whether a path leads there.
        """
        self.build(np.array([point_enu_m]), 0.0)
        cell = tuple(self.field.cells(np.array(point_enu_m)))
        return bool(self.field.distance_m[cell] >= self.radius_m)
