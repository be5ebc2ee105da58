"""Surroundings of a vehicle as planning knows them: obstacles, free space and plans through it.

A given map and a growing one answer the same questions, so the pilot plans through this one class
and does not know which it has. The object is frozen: a new margin or limit makes a new one.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from aeroscene.solids.freespace import NoFreeSpaceError
from autonomy.mapping import Agenda, Map, plan_within
from autonomy.perception.depth_image import DepthImage
from autonomy.planning import (
    NOTHING_MOVES,
    Craft,
    DistanceField,
    FlightLimits,
    Method,
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
from scenarios.mission.hover_points import hover_columns, slanting_lines
from scenarios.mission.maps import given_map, unseen_map

FIELD_RESOLUTION_M = 0.25
# Room that the sphere must have at a hover point, and on a straight path down from it.
HOVER_MARGIN_M = 0.4
DESCENT_MARGIN_M = 0.1
MapSource = Literal["truth", "onboard"]
"""Source of the map of a flight: the scene itself, or the vehicle's own images."""


class MissionError(ValueError):
    """The vehicle has no mission in a scene; the message says why."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """Knowledge of a scene and a vehicle for planning."""

    scene: Scene
    airframe: Airframe
    map: Map
    """Map of the obstacles: given, or growing with what the vehicle sees."""
    limits: FlightLimits
    method: Method = "optimise"
    """Planner that turns a searched path into a trajectory."""
    margin_m: float = 0.0
    """Distance that plans keep from obstacles if there is room and if it is more than usual: the
    distance that the vehicle strays from its plans."""
    agenda: Agenda = field(default_factory=Agenda)
    """Memory of planning from plan to plan in a growing map."""

    @property
    def is_known(self) -> bool:
        """True if the whole map is given; else it grows with each image."""
        return self.map.is_given

    @property
    def obstacles(self) -> Obstacles:
        """Obstacles to avoid; in a growing map everything nearby that was not seen free."""
        return self.map.obstacles

    @property
    def field(self) -> DistanceField:
        """Distances to the obstacles, cell by cell."""
        return self.map.field

    def observe(self, image: DepthImage, position_enu_m: Vector3, *, is_ahead: bool = True) -> None:
        """Add a depth image of any camera to a growing map; a given map ignores it.

        A cell counts as free from the second image that shows it free, or when the vehicle fills
        it.

        Args:
            image: The image.
            position_enu_m: Position of the vehicle that takes it.
            is_ahead: True if the camera that looks ahead has taken it.
        """
        self.map.observe(image, is_ahead=is_ahead)
        self.map.be_at(position_enu_m, self.craft.keep_m, self.airframe.leg_length_m)

    @functools.cached_property
    def openings(self) -> Sequence[Opening]:
        """Doors, windows and other narrow passages of a given map, found on first use."""
        return self.map.find_openings()

    @property
    def radius_m(self) -> float:
        """Radius of the sphere around the centre of mass that contains rotors and soles."""
        return sphere_radius_m(self.airframe)

    @property
    def lift_m(self) -> float:
        """Height by which cells that were seen as occupied may extend above the surface in them."""
        return 0.0 if self.is_known else FIELD_RESOLUTION_M

    def clearance_m(self, points_enu_m: np.ndarray) -> np.ndarray:
        """Distance from the vehicle's sphere at several positions to the nearest obstacle, m."""
        return self.map.distance_m(points_enu_m) - self.radius_m

    @property
    def planner(self) -> PlannerCfg:
        """Planner settings for the vehicle, with the wider margin first if there is one."""
        usual = PlannerCfg(vehicle_radius_m=self.radius_m, method=self.method)
        # Margins are tried in turn, so the wider one goes before the usual ones.
        if self.margin_m <= usual.margins_m[0]:
            return usual
        return replace(usual, margins_m=(self.margin_m, *usual.margins_m))

    @property
    def craft(self) -> Craft:
        """The vehicle that plans are made for."""
        return Craft(self.limits, self.airframe.quadrotor, self.planner)

    def plan(self, start: FlatReference, goal_enu_m: Vector3) -> Trajectory:
        """Plan a certified trajectory through free space.

        In a growing map it may end short of the goal, at rest within the known free space, or be a
        turn on the spot to look there. Replan on the way when more was seen.

        Raises:
            PlanningError: If there is none, with the reason.
        """
        return plan_within(self.map, self.agenda, start, goal_enu_m, self.craft)

    def replan(
        self,
        previous: Trajectory,
        at_time_s: float,
        *,
        moving: MovingObstacles = NOTHING_MOVES,
        start: FlatReference | None = None,
    ) -> Trajectory:
        """Plan a certified trajectory for the rest of a plan, around movers.

        See `autonomy.planning.replan` for the arguments.

        Raises:
            PlanningError: If there is none, with the reason.
        """
        return replan(previous, at_time_s, self.obstacles, self.craft, moving=moving, start=start)

    def leg(
        self,
        start_enu_m: Vector3,
        goal_enu_m: Vector3,
        yaw_rad: float,
        speed_mps: float | None = None,
    ) -> Trajectory:
        """Return a straight line from rest to rest, not certified.

        Args:
            start_enu_m: Position at rest before.
            goal_enu_m: Position at rest after.
            yaw_rad: Heading of the vehicle.
            speed_mps: Greatest vertical speed; None for the limit.
        """
        limits = self.limits
        if speed_mps is not None:
            # Legs are mostly upright, so the vertical limit sets their speed.
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
        """Return a straight line from rest to rest, certified like any other plan.

        Args:
            start_enu_m: Position at rest before.
            goal_enu_m: Position at rest after.
            yaw_rad: Heading of the vehicle.
            speed_mps: Greatest vertical speed; None for the limit.
            moving: Movers, predicted from now on.
            exempt_m: Length of the line that may be exempt from the map, for leaving a surface that
                the vehicle stands on; no more than necessary is exempt.

        Raises:
            PlanningError: If the line is not free or breaks a limit.
        """
        return legs.certified(
            functools.partial(self.leg, yaw_rad=yaw_rad, speed_mps=speed_mps),
            (start_enu_m, goal_enu_m),
            self.obstacles,
            self.craft,
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
        """Plan a certified stop as soon as possible, stepping aside for approaching movers.

        See `autonomy.planning.brake` for the arguments.

        Raises:
            PlanningError: If no stop can be certified.
        """
        return brake(previous, at_time_s, self.obstacles, self.craft, moving=moving, start=start)

    def hover_point(self, area: InteractionArea) -> Vector3 | None:
        """Return a hover point from which a straight path down to an area is free, else None.

        It is above the area, or aslant if a roof or a wall leaves no room to hover there. In a
        growing map, unseen space counts as free: ask again when nearer.
        """
        # Aslant only in a given map: unseen space of a growing one counts as free.
        above = self.hover_above(area)
        if above is not None or not self.is_known:
            return above
        return self._first_free(slanting_lines(area.centroid, self._lowest_m))

    def hover_above(self, area: InteractionArea) -> Vector3 | None:
        """A hover point straight above an area, with free air all the way down, else None."""
        return self._first_free(hover_columns(area.centroid, self._lowest_m))

    @property
    def _lowest_m(self) -> float:
        """Height above a surface from which on the air must be free, m."""
        return self.radius_m + 2 * DESCENT_MARGIN_M + self.lift_m

    def _first_free(self, ways: Iterable[np.ndarray]) -> Vector3 | None:
        """The upper end of the first line (n, 3) that is free and has room to hover there."""
        for way in ways:
            x, y, z = way[-1].tolist()
            if not self.field.contains(way[-1]) or not self.map.may_be_reached((x, y, z)):
                continue
            # Unseen cells do not count as obstacles here, otherwise a growing map had no hover
            # points.
            room_m = self.map.distance_to_seen_m(way) - self.radius_m
            if room_m[-1] >= HOVER_MARGIN_M and np.all(room_m >= DESCENT_MARGIN_M):
                return (x, y, z)
        return None


def survey(
    scene: Scene,
    airframe: Airframe,
    limits: FlightLimits | None = None,
    *,
    map_source: MapSource = "truth",
    method: Method = "optimise",
) -> Surroundings:
    """Build the surroundings of a vehicle in a scene.

    Args:
        scene: Scene to fly in.
        airframe: Vehicle that flies.
        limits: Limits of the motion; None for the usual ones.
        map_source: "truth" gives the scene's own map, "onboard" one that knows the flight volume
            and the air above the start, and grows with what the vehicle sees.
        method: Planner that turns a searched path into a trajectory.

    Raises:
        MissionError: If the vehicle cannot leave the start.
    """
    limits = FlightLimits() if limits is None else limits
    try:
        if map_source == "onboard":
            known: Map = unseen_map(scene, airframe, FIELD_RESOLUTION_M)
        else:
            known = given_map(scene, sphere_radius_m(airframe), FIELD_RESOLUTION_M)
    # Callers know missions, not maps.
    except NoFreeSpaceError as error:
        raise MissionError(str(error)) from None
    return Surroundings(scene=scene, airframe=airframe, map=known, limits=limits, method=method)


def sphere_radius_m(airframe: Airframe) -> float:
    """Return the radius of the sphere around the centre of mass that contains rotors and soles."""
    # Soles may be farther from the centre than the rotors' tips.
    legs_m = math.hypot(airframe.leg_spread_m, airframe.leg_length_m)
    return max(airframe.collision_radius_m, legs_m)
