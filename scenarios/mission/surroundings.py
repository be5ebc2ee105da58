"""What is known of the place that a vehicle flies in: solids, free space, plans through it."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from aeroscene.solids.freespace import NoFreeSpaceError
from autonomy.mapping import Map
from autonomy.perception.depth_image import DepthImage
from autonomy.planning import (
    NOTHING_MOVES,
    DistanceField,
    FlightLimits,
    MovingObstacles,
    Obstacles,
    PlannerCfg,
    Trajectory,
    brake,
    plan_leg,
    replan,
)
from autonomy.planning.openings import Opening
from autonomy.types import FlatReference, Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.mission import legs
from scenarios.mission.hovering import hover_columns
from scenarios.mission.maps import given_map, unseen_map

FIELD_RESOLUTION_M = 0.25
HOVER_MARGIN_M = 0.4
DESCENT_MARGIN_M = 0.1
MapSource = Literal["truth", "onboard"]
"""Where the map of a flight comes from."""


class MissionError(ValueError):
    """A scene in which the vehicle has no mission; says why."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """What planning needs to know of a scene and a vehicle."""

    scene: Scene
    airframe: Airframe
    map: Map
    """Where the obstacles are: given, or growing with what the vehicle sees."""
    limits: FlightLimits
    method: Literal["optimise", "primitives"] = "optimise"
    """How plans are made: see `PlannerCfg`."""

    @property
    def is_known(self) -> bool:
        """Whether the whole map was given; else it grows with each image."""
        return self.map.is_given

    @property
    def obstacles(self) -> Obstacles:
        """What the vehicle must not touch: of a growing map all that was not seen free nearby."""
        return self.map.obstacles

    @property
    def field(self) -> DistanceField:
        """Distances to these obstacles."""
        return self.map.field

    def observe(self, image: DepthImage) -> None:
        """Take a depth image into the map, of any camera; nothing where the map is known.

        A cell counts as free from the second image on that shows it so.
        """
        self.map.observe(image)

    @functools.cached_property
    def openings(self) -> Sequence[Opening]:
        """Doors, windows and other narrow ways of a map that was given, found when asked for."""
        return self.map.find_openings()

    @property
    def radius_m(self) -> float:
        """Of a sphere about the centre of mass that holds rotors and soles."""
        return _radius_m(self.airframe)

    def clearance_m(self, points_enu_m: np.ndarray) -> np.ndarray:
        """Distance between the vehicle's sphere at some points and the nearest obstacle."""
        about = self.map.obstacles_about(points_enu_m)
        return about.signed_distance(points_enu_m)[0] - self.radius_m

    @property
    def planner(self) -> PlannerCfg:
        """How plans are made for the vehicle."""
        return PlannerCfg(vehicle_radius_m=self.radius_m, method=self.method)

    def plan(self, start: FlatReference, goal_enu_m: Vector3) -> Trajectory:
        """A certified trajectory through free space.

        Where the map grows, it may end short of the goal, at rest within what was seen free, or
        be a turn on the spot to look there: plan again from on the way, when more was seen.

        Raises:
            PlanningError: Saying why there is none.
        """
        return self.map.plan(start, goal_enu_m, self.limits, self.airframe.quadrotor, self.planner)

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

    def certified_leg(
        self,
        start_enu_m: Vector3,
        goal_enu_m: Vector3,
        yaw_rad: float,
        speed_mps: float | None = None,
        *,
        moving: MovingObstacles = NOTHING_MOVES,
        exempt_m: float = 0.0,
    ) -> Trajectory:
        """A straight line from rest to rest that is proved as any other plan.

        Args:
            start_enu_m: Where the vehicle rests.
            goal_enu_m: Where it shall rest.
            yaw_rad: Where it looks.
            speed_mps: Up or down at most; None for the limit.
            moving: What moves, predicted from now on.
            exempt_m: Up to so much of the way the map is not asked about, for the way up from a
                surface that the vehicle stands on; no more of it than needed is left out.

        Raises:
            PlanningError: If the line is not free or a limit is broken.
        """
        return legs.certified(
            functools.partial(self.leg, yaw_rad=yaw_rad, speed_mps=speed_mps),
            (start_enu_m, goal_enu_m),
            self.obstacles,
            self.limits,
            self.airframe.quadrotor,
            self.planner,
            moving=moving,
            exempt_m=exempt_m,
        )

    def brake(
        self,
        previous: Trajectory,
        at_time_s: float,
        *,
        moving: MovingObstacles = NOTHING_MOVES,
        start: FlatReference | None = None,
    ) -> Trajectory:
        """A certified trajectory to rest as soon as possible, aside where something comes along.

        Args:
            previous: Any trajectory.
            at_time_s: Time of it from which the new one takes over.
            moving: What moves, predicted from then on.
            start: Where the vehicle is then; None for where the trajectory has it.

        Raises:
            PlanningError: If no stop can be proved.
        """
        return brake(
            previous,
            at_time_s,
            self.obstacles,
            self.limits,
            self.airframe.quadrotor,
            self.planner,
            moving=moving,
            start=start,
        )

    def hover_point(self, area: InteractionArea) -> Vector3 | None:
        """Where to look at an area from: above it, free all the way down; None if nowhere.

        Where the map grows, what was not seen yet counts as free: ask again when nearer.
        """
        # A cell that was seen occupied reaches above the surface in it.
        lift_m = 0.0 if self.is_known else FIELD_RESOLUTION_M
        for column in hover_columns(area.centroid, self.radius_m + 2 * DESCENT_MARGIN_M + lift_m):
            x, y, z = column[-1].tolist()
            if not self.field.contains(column[-1]) or not self.map.may_be_reached((x, y, z)):
                continue
            room_m = self.map.distance_to_seen_m(column) - self.radius_m
            if room_m[-1] >= HOVER_MARGIN_M and np.all(room_m >= DESCENT_MARGIN_M):
                return (x, y, z)
        return None


def survey(
    scene: Scene,
    airframe: Airframe,
    limits: FlightLimits | None = None,
    *,
    map_source: MapSource = "truth",
) -> Surroundings:
    """Obstacles and free space of a scene, for a vehicle.

    Args:
        scene: Where to fly.
        airframe: What flies.
        limits: Of the motion; None for the usual ones.
        map_source: "truth" gives the scene's own map, "onboard" one that knows the flight volume
            and the air above the start, and grows with what the vehicle sees.

    Raises:
        MissionError: If the vehicle cannot leave the start.
    """
    limits = FlightLimits() if limits is None else limits
    if map_source == "onboard":
        return Surroundings(
            scene=scene,
            airframe=airframe,
            map=unseen_map(scene, airframe, FIELD_RESOLUTION_M),
            limits=limits,
        )
    try:
        given = given_map(scene, _radius_m(airframe), FIELD_RESOLUTION_M)
    except NoFreeSpaceError as error:
        raise MissionError(str(error)) from None
    return Surroundings(scene=scene, airframe=airframe, map=given, limits=limits)


def _radius_m(airframe: Airframe) -> float:
    legs_m = math.hypot(airframe.leg_spread_m, airframe.leg_length_m)
    return max(airframe.collision_radius_m, legs_m)
