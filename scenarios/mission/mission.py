"""Task of a flight: the landing area, the hover point above it and the plan to get there.

An area is only a good goal if a path leads to it. Areas are therefore tried in drawn order until
the planner finds a path to one, and the plan is kept for the flight.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.scene import InteractionArea, Scene
from aeroscene.scene.catalogue import PADS
from autonomy.planning import FlightLimits, Method, PlanningError, Trajectory
from autonomy.types import FlatReference, Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.goals import Target, draw_goals, fitting_areas, is_indoor
from scenarios.mission.surroundings import (
    DESCENT_MARGIN_M,
    HOVER_MARGIN_M,
    MapSource,
    MissionError,
    Surroundings,
    survey,
)

TAKEOFF_HEIGHTS_M = (2.5, 2.0, 1.5, 3.0, 4.0, 1.2)  # above the start; the first free one is used
FAR_ENOUGH_M = 15.0
"""Areas nearer to the start than this are chosen only if there is no other."""
_MAX_ALTERNATES = 8
_LUCK = 2.0
"""Greatest share of chance in an area's appeal, twice that of height above the ground."""
_WANTED = {"landing": "landing area", "perching": "place to perch", "any": "area"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Mission:
    """A planned flight."""

    surroundings: Surroundings
    area: InteractionArea
    alternates: tuple[InteractionArea, ...]
    """Areas to try if the assigned one turns out to be unsafe, best first."""
    takeoff_enu_m: Vector3
    """End of the take-off, above the start."""
    hover_enu_m: Vector3
    """Hover point from which the area is observed."""
    trajectory: Trajectory
    """Plan from above the start to the hover point; in a growing map, a stay above the start."""

    def path_enu_m(self, step_s: float) -> Float[np.ndarray, "n 3"] | None:
        """Return points of the path planned before the take-off, from the start to the hover point.

        Args:
            step_s: Time between two points of the trajectory.

        Returns:
            The points; None in a growing map, where nothing is planned that far.
        """
        if not self.surroundings.is_known:
            return None
        end_s = self.trajectory.duration_s
        times_s = np.append(np.arange(0.0, end_s, step_s), end_s)
        start = np.array(self.surroundings.scene.start_position_enu_m)
        return np.concatenate([start[None], self.trajectory.positions(times_s)])


def plan_mission(
    scene: Scene,
    airframe: Airframe,
    *,
    seed: int = 0,
    area: InteractionArea | None = None,
    target: Target = "landing",
    map_source: MapSource = "truth",
    method: Method = "optimise",
    limits: FlightLimits | None = None,
    is_free: Callable[[InteractionArea], bool] = lambda _: True,
) -> Mission:
    """Draw an area that can be flown to (unless one is given) and plan the path to it.

    Args:
        scene: Scene to fly in.
        airframe: Vehicle that flies.
        seed: Seed of the draw.
        area: Area to land on; None draws one.
        target: Kind of area to draw.
        map_source: "truth" gives the map, "onboard" lets it grow with what the vehicle sees. A
            growing map is planned in from above the start, and its areas are those of the brief.
        method: Planner that makes trajectories of paths, now and in flight.
        limits: Limits of the motion; None for the usual ones.
        is_free: Returns True if no other vehicle has an area; asked for drawn areas and alternates.

    Raises:
        MissionError: If no area suits the vehicle, or none can be flown to.
    """
    surroundings = survey(scene, airframe, limits, map_source=map_source, method=method)
    # Before any area is tried: without a free column above the start, none can be flown to.
    takeoff = takeoff_point(surroundings)
    drawn = draw_goals(scene, airframe, seed, target) if area is None else []
    candidates = [each for each in drawn if is_free(each)] if area is None else [area]
    # The author of the task knows the place, even if the pilot does not: the area must be
    # reachable.
    given = surroundings if surroundings.is_known else survey(scene, airframe)
    reason = f"no {_WANTED[target]} suits class {airframe.drone_class}"
    for candidate in candidates:
        hover = given.hover_point(candidate) and surroundings.hover_point(candidate)
        if hover is None:
            reason = f"area {candidate.id} has no free place to hover above it"
            continue
        try:
            trajectory = _first_plan(surroundings, takeoff, hover)
        except PlanningError as error:
            reason = f"area {candidate.id}: {error}"
            continue
        ranked = rank_areas(scene, airframe, seed, target)
        # Alternates are ranked by appeal; only the assigned area is drawn.
        others = [each for each in ranked if each != candidate and is_free(each)]
        return Mission(
            surroundings=surroundings,
            area=candidate,
            alternates=tuple(others[:_MAX_ALTERNATES]),
            takeoff_enu_m=takeoff,
            hover_enu_m=hover,
            trajectory=trajectory,
        )
    raise MissionError(f"scene {scene.scene_id}, {airframe.name}: {reason}")


def _first_plan(world: Surroundings, takeoff_enu_m: Vector3, hover_enu_m: Vector3) -> Trajectory:
    """Plan from above the start to above the area; in an empty map, stay above the start.

    Raises:
        PlanningError: If there is no path.
    """
    yaw_rad = world.scene.start_yaw_rad
    if not world.is_known:
        return world.leg(takeoff_enu_m, takeoff_enu_m, yaw_rad)
    start = FlatReference(position_enu_m=takeoff_enu_m, yaw_rad=yaw_rad)
    return world.plan(start, hover_enu_m)


def takeoff_point(surroundings: Surroundings) -> Vector3:
    """Return the point above the start to which the vehicle rises before it flies on.

    Raises:
        MissionError: If something is above the start.
    """
    x, y, z = surroundings.scene.start_position_enu_m
    for height_m in TAKEOFF_HEIGHTS_M:
        heights = np.arange(surroundings.radius_m + 2 * DESCENT_MARGIN_M, height_m + 0.1, 0.1)
        column = np.column_stack([np.full_like(heights, x), np.full_like(heights, y), z + heights])
        room_m = surroundings.clearance_m(column)
        if np.all(room_m >= DESCENT_MARGIN_M) and room_m[-1] >= HOVER_MARGIN_M:
            return (x, y, z + height_m)
    raise MissionError(
        f"start {surroundings.scene.start_position_enu_m} has something above it; "
        f"valid: {HOVER_MARGIN_M} m of room at one of {TAKEOFF_HEIGHTS_M} m above the start"
    )


def rank_areas(
    scene: Scene, airframe: Airframe, seed: int, target: Target = "landing"
) -> list[InteractionArea]:
    """Return the areas for the vehicle's class, in the order in which a pilot prefers them.

    The best are far, elevated, roomy and under the open sky. The seed settles the order among areas
    that are about as good.
    """
    fits = fitting_areas(scene, airframe, target)
    start = scene.start_position_enu_m
    chance = np.random.default_rng(seed).uniform(0.0, _LUCK, len(fits)).tolist()
    score = {area.id: luck + _appeal(scene, area) for area, luck in zip(fits, chance, strict=True)}

    def is_near(area: InteractionArea) -> bool:
        return math.dist(area.centroid, start) < FAR_ENOUGH_M

    return sorted(fits, key=lambda area: (is_near(area), -score[area.id], area.id))


def _appeal(scene: Scene, area: InteractionArea) -> float:
    bearer = None if area.object_id is None else scene.object_by_id[area.object_id]
    is_elevated = area.centroid[2] - scene.start_position_enu_m[2] > 1.5
    is_pad = bearer is not None and bearer.category in PADS
    return (
        1.0 * is_elevated
        + 0.8 * is_pad
        + 0.5 * min(area.radius, 2.0)
        - 2.0 * is_indoor(scene, area)
    )
