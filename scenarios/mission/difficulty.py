"""Difficulty of a scene: the planner's paths to landing areas, graded against the shipped scenes.

Absolute thresholds would mean little, because lengths and turns depend on the place. So a scene is
compared with the shipped ones. It has four figures, the medians over its paths. Each earns it
points: none in the easiest third of the shipped scenes, one in the middle third, two in the
hardest. The sum of the points decides between easy, medium and hard.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from aeroscene.scene import AttributeValue, InteractionArea, Scene
from autonomy.planning import PlanningError, Trajectory
from autonomy.types import FlatReference, Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.mission import rank_areas, takeoff_point
from scenarios.mission.surroundings import MissionError, Surroundings, survey

Grade = Literal["easy", "medium", "hard"]

N_WAYS = 4
"""Number of paths of a scene that are measured."""
_MOST_TRIED = 8
"""Number of areas to which a path is sought at most."""
_STEP_S = 0.1  # between the points at which a trajectory is measured


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """Figures of the planner's path from above the start to above a landing area."""

    over_straight: float
    """Length over the straight distance of its ends, 1 or more."""
    seconds: float
    """Flight time."""
    quarter_turns: float
    """Sum of all changes of direction, in right angles."""
    least_clearance_m: float
    """Least distance between the vehicle's sphere and an obstacle."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Difficulty:
    """Medians over the paths of a scene, and the grade that follows from them."""

    n_ways: int
    way: Way
    """Median of each figure."""

    @property
    def points(self) -> int:
        """Sum of the points of the four figures, 0 to 8."""
        return sum(
            points_by_thirds(getattr(self.way, name), *bounds) for name, bounds in THIRDS.items()
        )

    @property
    def grade(self) -> Grade:
        """Class of the scene."""
        if self.points <= MOST_POINTS["easy"]:
            return "easy"
        return "medium" if self.points <= MOST_POINTS["medium"] else "hard"

    def to_plain(self) -> dict[str, AttributeValue]:
        """Return the grade, its points and the figures as plain data for a scene's document."""
        figures = {name: round(getattr(self.way, name), 3) for name in THIRDS}
        return {
            "difficulty": self.grade,
            "difficulty_points": self.points,
            "ways": self.n_ways,
            **figures,
        }


# An Iris in 101 scenes drawn from the shipped ones, by `python tools/bench.py difficulty`.
THIRDS: Mapping[str, tuple[float, float]] = {
    "over_straight": (1.005, 1.026),
    "seconds": (8.9, 11.1),
    "quarter_turns": (0.31, 0.57),
    "least_clearance_m": (1.09, 0.78),
}
"""Bounds of the middle third of each figure, from easy to hard."""
MOST_POINTS: Mapping[Grade, int] = {"easy": 2, "medium": 5, "hard": 8}
"""Most points of a class; 30, 36 and 35% of the same scenes are easy, medium and hard."""


def points_by_thirds(value: float, easy: float, hard: float) -> int:
    """Return the points of a figure that is harder towards `hard`: 0, 1 or 2 by its third.

    Args:
        value: The figure.
        easy: Bound between the easiest and the middle third.
        hard: Bound between the middle and the hardest third; below `easy` if small values are hard.
    """
    sign = 1.0 if hard > easy else -1.0
    return (sign * value > sign * easy) + (sign * value > sign * hard)


def measure_difficulty(scene: Scene, airframe: Airframe) -> Difficulty:
    """Measure the difficulty of a scene for a vehicle.

    Raises:
        MissionError: If the vehicle cannot leave the start, or no area can be flown to.
    """
    ways = measure_paths(scene, airframe)
    if not ways:
        raise MissionError(f"scene {scene.scene_id}: no landing area can be flown to")
    medians = {name: float(np.median([getattr(way, name) for way in ways])) for name in THIRDS}
    return Difficulty(n_ways=len(ways), way=Way(**medians))


def measure_paths(scene: Scene, airframe: Airframe) -> list[Way]:
    """Plan to the areas of `rank_areas`, best first, and measure the first paths found.

    Returns:
        At most `N_WAYS` paths; none if no area can be flown to.

    Raises:
        MissionError: If the vehicle cannot leave the start.
    """
    world = survey(scene, airframe)
    takeoff = takeoff_point(world)
    # Always the areas of seed 0, so that a scene has one difficulty.
    ways: list[Way] = []
    for area in rank_areas(scene, airframe, seed=0)[:_MOST_TRIED]:
        trajectory = _way_to(world, takeoff, area)
        if trajectory is not None:
            ways.append(_measured(world, trajectory))
        if len(ways) == N_WAYS:
            break
    return ways


def _way_to(
    world: Surroundings, takeoff_enu_m: Vector3, area: InteractionArea
) -> Trajectory | None:
    hover = world.hover_point(area)
    if hover is None:
        return None
    start = FlatReference(position_enu_m=takeoff_enu_m, yaw_rad=world.scene.start_yaw_rad)
    try:
        return world.plan(start, hover)
    except PlanningError:
        return None


def _measured(world: Surroundings, trajectory: Trajectory) -> Way:
    n_steps = max(2, math.ceil(trajectory.duration_s / _STEP_S))
    points = trajectory.positions(np.linspace(0.0, trajectory.duration_s, n_steps + 1))
    steps = np.diff(points, axis=0)
    lengths_m = np.linalg.norm(steps, axis=1)
    straight_m = float(np.linalg.norm(points[-1] - points[0]))
    # At rest a step has no direction.
    directions = steps[lengths_m > 1e-3] / lengths_m[lengths_m > 1e-3, None]
    cosines = np.sum(directions[1:] * directions[:-1], axis=1).clip(-1.0, 1.0)
    return Way(
        over_straight=float(lengths_m.sum()) / max(straight_m, 1e-6),
        seconds=trajectory.duration_s,
        quarter_turns=float(np.arccos(cosines).sum()) / (math.pi / 2),
        least_clearance_m=float(world.clearance_m(points).min()),
    )
