"""The task of a flight: which landing area, from where to look at it, and the way there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from aeroscene.freespace import NoFreeSpaceError, build_distance_field, reachable
from aeroscene.scene import InteractionArea, Scene
from aeroscene.shapes import scene_primitives
from autonomy.model.quadrotor import Vector3
from autonomy.planning import (
    NOTHING_MOVES,
    DistanceField,
    FlightLimits,
    MovingObstacles,
    Obstacles,
    PlannerCfg,
    PlanningError,
    Trajectory,
    plan_leg,
    plan_trajectory,
    replan,
)
from autonomy.types import FlatReference
from flightsim.vehicles.airframe import Airframe
from scenarios.obstacles import distance_field, scene_obstacles

FIELD_RESOLUTION_M = 0.25
HOVER_HEIGHTS_M = (4.0, 3.5, 3.0, 2.5, 2.0, 1.6, 1.2)
"""Above an area, from where to look at it: the first that is free."""
TAKEOFF_HEIGHTS_M = (2.5, 2.0, 1.5, 3.0, 4.0, 1.2)
FAR_ENOUGH_M = 15.0
"""Areas nearer to the start than this are flown to only where there is no other."""
_HOVER_MARGIN_M = 0.4
_DESCENT_MARGIN_M = 0.1
_MAX_ATTEMPTS = 8
_LUCK = 2.0
"""What chance adds to an area's appeal at most: twice what height above the ground does."""
_CLASSES = ("small", "medium", "large")


class MissionError(ValueError):
    """A scene in which the vehicle has no mission; says why."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """What planning needs to know of a scene and a vehicle."""

    scene: Scene
    airframe: Airframe
    obstacles: Obstacles
    field: DistanceField
    is_reachable: np.ndarray
    """Cells of the field that the vehicle can fly to from the start."""
    limits: FlightLimits
    method: Literal["optimise", "primitives"] = "optimise"
    """How plans are made: see `PlannerCfg`."""

    @property
    def radius_m(self) -> float:
        """Of a sphere about the centre of mass that holds rotors and soles."""
        frame = self.airframe
        return max(frame.collision_radius_m, math.hypot(frame.leg_spread_m, frame.leg_length_m))

    def clearance_m(self, points_enu_m: np.ndarray) -> np.ndarray:
        """Distance between the vehicle's sphere at some points and the nearest obstacle."""
        return self.obstacles.signed_distance(points_enu_m)[0] - self.radius_m

    @property
    def planner(self) -> PlannerCfg:
        """How plans are made for the vehicle."""
        return PlannerCfg(vehicle_radius_m=self.radius_m, method=self.method)

    def plan(self, start: FlatReference, goal_enu_m: Vector3) -> Trajectory:
        """A certified trajectory through free space.

        Raises:
            PlanningError: Saying why there is none.
        """
        return plan_trajectory(
            start,
            goal_enu_m,
            self.field,
            self.obstacles,
            self.limits,
            self.airframe.quadrotor,
            self.planner,
        )

    def replan(
        self,
        previous: Trajectory,
        at_time_s: float,
        *,
        moving: MovingObstacles = NOTHING_MOVES,
        start: FlatReference | None = None,
    ) -> Trajectory:
        """A certified trajectory for the rest of a plan, past what moves.

        Args:
            previous: A plan by `plan` or by this.
            at_time_s: Time of that plan from which the new one takes over.
            moving: What moves, predicted from then on.
            start: Where the vehicle is then; None for where the plan has it.

        Raises:
            PlanningError: Saying why there is none.
        """
        return replan(
            previous,
            at_time_s,
            self.obstacles,
            self.limits,
            self.airframe.quadrotor,
            self.planner,
            moving=moving,
            start=start,
        )

    def leg(
        self,
        start_enu_m: Vector3,
        goal_enu_m: Vector3,
        yaw_rad: float,
        speed_mps: float | None = None,
    ) -> Trajectory:
        """A straight line from rest to rest, not certified, up or down at `speed_mps` at most."""
        limits = self.limits
        if speed_mps is not None:
            limits = replace(limits, speed_vertical_mps=speed_mps)
        return plan_leg(start_enu_m, goal_enu_m, yaw_rad, limits, self.airframe.quadrotor)

    def hover_point(self, area: InteractionArea) -> Vector3 | None:
        """Where to look at an area from: above it, free all the way down; None if nowhere."""
        x, y, z = area.centroid
        for height_m in HOVER_HEIGHTS_M:
            point = (x, y, z + height_m)
            if not self.field.contains(np.array(point)):
                continue
            if not self.is_reachable[tuple(self.field.cells(np.array(point)))]:
                continue
            # From where the sphere touches the surface up.
            heights = np.arange(self.radius_m + 2 * _DESCENT_MARGIN_M, height_m, 0.1)
            column = np.column_stack(
                [np.full_like(heights, x), np.full_like(heights, y), z + heights]
            )
            room_m = self.clearance_m(np.vstack([column, [point]]))
            if room_m[-1] >= _HOVER_MARGIN_M and np.all(room_m >= _DESCENT_MARGIN_M):
                return point
        return None


@dataclass(frozen=True, kw_only=True, eq=False)
class Mission:
    """A flight that was planned."""

    surroundings: Surroundings
    area: InteractionArea
    alternates: tuple[InteractionArea, ...]
    """Areas to try when the first turns out not to be safe, best first."""
    takeoff_enu_m: Vector3
    """Where the take-off ends, above the start."""
    hover_enu_m: Vector3
    """From where the area is looked at."""
    trajectory: Trajectory
    """From the end of the take-off to the hover point."""


def survey(scene: Scene, airframe: Airframe, limits: FlightLimits | None = None) -> Surroundings:
    """Obstacles and free space of a scene, for a vehicle.

    Raises:
        MissionError: If the vehicle cannot leave the start.
    """
    primitives = scene_primitives(scene)
    voxels = build_distance_field(scene, FIELD_RESOLUTION_M, primitives)
    radius_m = max(
        airframe.collision_radius_m, math.hypot(airframe.leg_spread_m, airframe.leg_length_m)
    )
    try:
        flood = reachable(voxels, scene.start_position_enu_m, radius_m)
    except NoFreeSpaceError as error:
        raise MissionError(str(error)) from None
    return Surroundings(
        scene=scene,
        airframe=airframe,
        obstacles=scene_obstacles(scene, primitives),
        field=distance_field(voxels),
        is_reachable=flood,
        limits=FlightLimits() if limits is None else limits,
    )


def plan_mission(
    scene: Scene, airframe: Airframe, *, seed: int = 0, area: InteractionArea | None = None
) -> Mission:
    """Choose a landing area (unless one is given) and plan the way to it.

    Args:
        scene: Where to fly.
        airframe: What flies.
        seed: Of the choice among good areas.
        area: Where to land, if that is settled.

    Raises:
        MissionError: If no area suits the vehicle, or none can be flown to.
    """
    surroundings = survey(scene, airframe)
    takeoff = takeoff_point(surroundings)
    start = FlatReference(position_enu_m=takeoff, yaw_rad=scene.start_yaw_rad)
    candidates = [area] if area is not None else rank_areas(scene, airframe, seed)
    reason = f"no landing area suits class {airframe.drone_class}"
    for index, candidate in enumerate(candidates[:_MAX_ATTEMPTS]):
        hover = surroundings.hover_point(candidate)
        if hover is None:
            reason = f"area {candidate.id} has no free place to hover above it"
            continue
        try:
            trajectory = surroundings.plan(start, hover)
        except PlanningError as error:
            reason = f"area {candidate.id}: {error}"
            continue
        return Mission(
            surroundings=surroundings,
            area=candidate,
            alternates=tuple(candidates[index + 1 : index + 1 + _MAX_ATTEMPTS]),
            takeoff_enu_m=takeoff,
            hover_enu_m=hover,
            trajectory=trajectory,
        )
    raise MissionError(f"scene {scene.scene_id}, {airframe.name}: {reason}")


def takeoff_point(surroundings: Surroundings) -> Vector3:
    """Where to rise to from the start before flying on.

    Raises:
        MissionError: If something is above the start.
    """
    x, y, z = surroundings.scene.start_position_enu_m
    for height_m in TAKEOFF_HEIGHTS_M:
        heights = np.arange(surroundings.radius_m + 2 * _DESCENT_MARGIN_M, height_m + 0.1, 0.1)
        column = np.column_stack([np.full_like(heights, x), np.full_like(heights, y), z + heights])
        room_m = surroundings.clearance_m(column)
        if np.all(room_m >= _DESCENT_MARGIN_M) and room_m[-1] >= _HOVER_MARGIN_M:
            return (x, y, z + height_m)
    raise MissionError(
        f"start {surroundings.scene.start_position_enu_m} has something above it; "
        f"valid: {_HOVER_MARGIN_M} m of room at one of {TAKEOFF_HEIGHTS_M} m above the start"
    )


def rank_areas(scene: Scene, airframe: Airframe, seed: int) -> list[InteractionArea]:
    """Landing areas for the vehicle's class, best first: far, elevated, roomy, under the open sky.

    The seed settles the order among areas that are about as good.
    """
    fits = [
        area
        for area in scene.landing_areas
        if _CLASSES.index(area.drone_class) >= _CLASSES.index(airframe.drone_class)
    ]
    start = scene.start_position_enu_m
    chance = np.random.default_rng(seed).uniform(0.0, _LUCK, len(fits)).tolist()
    score = {area.id: luck + _appeal(scene, area) for area, luck in zip(fits, chance, strict=True)}

    def is_near(area: InteractionArea) -> bool:
        return math.dist(area.centroid, start) < FAR_ENOUGH_M

    return sorted(fits, key=lambda area: (is_near(area), -score[area.id], area.id))


def _appeal(scene: Scene, area: InteractionArea) -> float:
    bearer = None if area.object_id is None else scene.object_by_id[area.object_id]
    is_indoor = bearer is not None and bearer.domain == "indoor"
    is_elevated = area.centroid[2] - scene.start_position_enu_m[2] > 1.5
    is_pad = bearer is not None and bearer.category == "landing_pad"
    return 1.0 * is_elevated + 0.8 * is_pad + 0.5 * min(area.radius, 2.0) - 2.0 * is_indoor
