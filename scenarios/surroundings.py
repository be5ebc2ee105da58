"""What is known of the place that a vehicle flies in: solids, free space, plans through it."""

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
HOVER_MARGIN_M = 0.4
DESCENT_MARGIN_M = 0.1


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
            heights = np.arange(self.radius_m + 2 * DESCENT_MARGIN_M, height_m, 0.1)
            column = np.column_stack(
                [np.full_like(heights, x), np.full_like(heights, y), z + heights]
            )
            room_m = self.clearance_m(np.vstack([column, [point]]))
            if room_m[-1] >= HOVER_MARGIN_M and np.all(room_m >= DESCENT_MARGIN_M):
                return point
        return None


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
