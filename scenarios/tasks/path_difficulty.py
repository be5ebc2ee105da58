"""Difficulty of a task's path, measured before anybody flies it.

The path is the shortest one through the cells in which the vehicle's sphere fits, straightened, but
neither smoothed nor timed, and the same for every pilot. Each of four figures earns points: none in
the easiest third of paths between drawn starts and areas of the shipped scenes, one in the middle
third, two in the hardest. The sum decides between easy, medium and hard.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.planning import DistanceField
from autonomy.planning.openings import MAX_WIDTH_M, Opening
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.difficulty import points_by_thirds
from scenarios.tasks.reach import Reach

Grade = Literal["easy", "medium", "hard"]
GRADES: tuple[Grade, ...] = ("easy", "medium", "hard")

_STEP_M = 0.25  # between the points at which room is measured
_NEAR_M, _ABOUT_M = 1.5, 5.0
"""Distance within which an obstacle is near, and width of the space about a path that counts."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PathFigures:
    """Figures of the shortest path from above the start to above the area."""

    way_m: float
    """Length."""
    corridor_m: float
    """Least width of free space about it, twice the least distance to obstacles."""
    clutter: float
    """Share of the space about it that is within 1.5 m of an obstacle, 5 m and less to the side."""
    openings: int
    """Doors, windows and other openings that it passes."""

    @property
    def points(self) -> int:
        """Sum of the points of the four figures, 0 to 8."""
        return sum(
            points_by_thirds(getattr(self, name), *bounds) for name, bounds in THIRDS.items()
        )

    @property
    def grade(self) -> Grade:
        """Class of the path."""
        return next(grade for grade in GRADES if self.points <= MOST_POINTS[grade])


# An Iris in 16 scenes spread over the shipped ones, 6 draws in each.
THIRDS: Mapping[str, tuple[float, float]] = {
    "way_m": (20.0, 42.0),
    "corridor_m": (4.0, 2.0),
    "clutter": (0.27, 0.43),
    "openings": (0.0, 1.0),
}
"""Bounds of the middle third of each figure, from easy to hard."""
MOST_POINTS: Mapping[Grade, int] = {"easy": 2, "medium": 4, "hard": 8}
"""Most points of a class; 42, 29 and 29% of the same paths are easy, medium and hard."""


def measure_path(
    reach: Reach,
    corners: Float[np.ndarray, "n 3"],
    find_openings: Callable[[Float[np.ndarray, "n 3"]], Sequence[Opening]],
) -> PathFigures:
    """Measure a path through free space.

    Args:
        reach: Free space that the path leads through.
        corners: The path, as `Reach.shortest_path` finds it, ENU.
        find_openings: Returns the openings of the scene, those about some points at least; called
            only if the path is narrow.
    """
    points = _along(corners)
    room_m = reach.obstacles.signed_distance(points)[0]
    corridor_m = 2.0 * float(room_m.min())
    # Finding the openings takes seconds; a path with room on both sides passes none.
    is_narrow = 2.0 * room_m < MAX_WIDTH_M
    openings = find_openings(points[is_narrow]) if is_narrow.any() else ()
    return PathFigures(
        way_m=round(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()), 2),
        corridor_m=round(corridor_m, 2),
        clutter=round(_clutter(points, reach.whole_field), 3),
        openings=_passed(points, openings),
    )


def least_navigation_s(way_m: float, airframe: Airframe) -> float:
    """Return the least time of a path: from rest to rest on a straight, level line of its length.

    It is the time-optimal flight of a point with the vehicle's mass and greatest thrust, which
    turns at once and meets no air: full tilt forwards for the first half, full tilt backwards for
    the second. No pilot of the vehicle is as fast on a level path in still air.

    Args:
        way_m: Length of the path.
        airframe: Vehicle.
    """
    craft = airframe.quadrotor
    greatest_mps2 = math.sqrt((craft.max_thrust_n / craft.mass_kg) ** 2 - GRAVITY_MPS2**2)
    return 2.0 * math.sqrt(way_m / greatest_mps2)


def _along(corners: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 3"]:
    """Return points on a polyline, close to each other."""
    parts = [corners[:1]]
    for a, b in itertools.pairwise(corners):
        n_steps = max(1, math.ceil(float(np.linalg.norm(b - a)) / _STEP_M))
        parts.append(a + np.arange(1, n_steps + 1)[:, None] / n_steps * (b - a))
    return np.concatenate(parts)


def _clutter(points: Float[np.ndarray, "n 3"], field: DistanceField) -> float:
    """Return the share of the cells about a path, in the box that holds it, near an obstacle."""
    about = np.array([_ABOUT_M, _ABOUT_M, 0.0])
    low, high = field.cells(np.array([points.min(axis=0) - about, points.max(axis=0) + about]))
    (i, j, k), (u, v, w) = np.maximum(low, 0).tolist(), (high + 1).tolist()
    return float(np.mean(field.distance_m[i:u, j:v, k:w] < _NEAR_M))


def _passed(points: Float[np.ndarray, "n 3"], openings: Sequence[Opening]) -> int:
    """Return the number of openings that a path leads through."""
    if not openings:
        return 0
    centres = np.array([opening.center_enu_m for opening in openings])
    reach_m = np.array([max(opening.width_m, opening.height_m) / 2 for opening in openings])
    # Near the middle of an opening, by half its larger extent, counts as through it.
    # Points are a quarter of a metre apart, close enough to meet any opening.
    away_m = np.linalg.norm(points[:, None] - centres, axis=2).min(axis=0)
    return int(np.count_nonzero(away_m <= reach_m))
