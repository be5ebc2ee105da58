"""Draws tasks from a recipe: trial N of a scene and a vehicle is always the same."""

from __future__ import annotations

import functools
import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from jaxtyping import Float

from aeroscene.scene import InteractionArea, Scene
from aeroscene.solids.field_cache import kept_distance_field
from aeroscene.solids.shapes import scene_primitives
from autonomy.mapping import WideMap
from autonomy.planning import PlanningError
from autonomy.planning.openings import Opening, find_openings
from autonomy.types import Vector3
from flightsim.draws import generator
from flightsim.vehicles import Airframe
from flightsim.world import WorldError, build_world
from scenarios.mission.goals import draw_goals, fitting_areas
from scenarios.mission.mission import takeoff_point
from scenarios.mission.obstacles import distance_field, scene_obstacles
from scenarios.mission.surroundings import (
    FIELD_RESOLUTION_M,
    MissionError,
    Surroundings,
    survey,
)
from scenarios.tasks.recipe import Range, Recipe
from scenarios.tasks.task import Task
from scenarios.tasks.way import GRADES, Grade, WayFigures, measure_way

_MOST_DRAWS = 60
"""Draws of a start and an area for one trial, with those that no free space joins."""
_SEEDS = 2**31
_KEPT_SCENES = 2
_KEPT_GROUNDS = 4
"""Starts whose surroundings are kept: each holds as many cells as the scene."""
_T = TypeVar("_T")


class NoTaskError(ValueError):
    """A scene has no task for a vehicle; the message says why."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ground:
    """A start that the vehicle can stand on and leave."""

    world: Surroundings
    takeoff_enu_m: Vector3


class Sampler:
    """Draws the tasks of one vehicle in one scene, and keeps what it measured for the next ones."""

    def __init__(self, name: str, scene: Scene, airframe: Airframe, recipe: Recipe) -> None:
        """Prepare to draw.

        Args:
            name: Name by which the scene is opened.
            scene: The scene.
            airframe: Vehicle that flies.
            recipe: What is drawn from.
        """
        self._name = name
        self._scene = scene
        self._airframe = airframe
        self._recipe = recipe
        self._grounds: OrderedDict[Vector3, _Ground] = OrderedDict()
        self._barred: set[Vector3] = set()
        """Starts that the vehicle cannot stand on, or not leave."""
        self._ways: dict[tuple[Vector3, int], WayFigures | None] = {}

    def task(self, trial: int) -> Task:
        """Task of a trial by its number.

        Raises:
            NoTaskError: If free space joins none of the drawn starts and areas.
        """
        recipe, scene_id = self._recipe, self._scene.scene_id
        stream = (self._airframe.name, trial)
        start, yaw_rad, area, way = self._draw_way(
            trial, generator(recipe.seed, scene_id, "way", *stream)
        )
        rng = generator(recipe.seed, scene_id, "conditions", *stream)
        return Task(
            scene=self._name,
            vehicle=self._airframe.vehicle,
            trial=trial,
            seed=int(rng.integers(_SEEDS)),
            start=start,
            start_yaw_rad=yaw_rad,
            area=area.id,
            time_limit_s=recipe.time_limit_s,
            wind_mps=_within(rng, recipe.wind_mps),
            wind_from_deg=round(float(rng.uniform(0.0, 360.0)), 1),
            turbulence=_one(rng, recipe.turbulence),
            gust_mps=_within(rng, recipe.gust_mps),
            traffic=_one(rng, recipe.traffic),
            gnss=_one(rng, recipe.gnss),
            depth_camera=_one(rng, recipe.depth_camera),
            map=_one(rng, recipe.map),
            way=way,
        )

    def _draw_way(
        self, trial: int, rng: np.random.Generator
    ) -> tuple[Vector3, float, InteractionArea, WayFigures]:
        """Start, heading, area and way: of the grade whose turn it is, else the nearest to it."""
        wanted = self._recipe.difficulty[trial % len(self._recipe.difficulty)]
        found: list[tuple[Vector3, float, InteractionArea, WayFigures]] = []
        for _ in range(_MOST_DRAWS):
            start, yaw_rad = self._draw_start(rng)
            area = self._draw_area(start, int(rng.integers(_SEEDS)))
            way = None if area is None else self._way(start, area)
            if area is None or way is None:
                continue
            found.append((start, yaw_rad, area, way))
            if way.grade == wanted or len(found) == self._recipe.draws:
                break
        if not found:
            raise NoTaskError(
                f"scene {self._scene.scene_id}, {self._airframe.name}: free space joins no start "
                f"to a {self._recipe.target} area for class {self._airframe.drone_class}"
            )
        return min(found, key=lambda each: _steps_between(each[3].grade, wanted))

    def _draw_start(self, rng: np.random.Generator) -> tuple[Vector3, float]:
        kind = _one(rng, self._recipe.start)
        areas = fitting_areas(self._scene, self._airframe)
        place, yaw_rad = int(rng.integers(_SEEDS)), float(rng.uniform(-math.pi, math.pi))
        if kind == "own" or not areas:
            return self._scene.start_position_enu_m, self._scene.start_yaw_rad
        return areas[place % len(areas)].centroid, round(yaw_rad, 3)

    def _draw_area(self, start: Vector3, seed: int) -> InteractionArea | None:
        """The area that a seed draws for a start; None if there is none."""
        goals = draw_goals(self._from(start), self._airframe, seed, self._recipe.target)
        return goals[0] if goals else None

    def _way(self, start: Vector3, area: InteractionArea) -> WayFigures | None:
        """Figures of the way from a start to an area; None if there is none."""
        key = (start, area.id)
        if key not in self._ways:
            ground = self._ground(start)
            self._ways[key] = None if ground is None else self._measured(ground, area)
        return self._ways[key]

    def _measured(self, ground: _Ground, area: InteractionArea) -> WayFigures | None:
        hover = ground.world.hover_point(area)
        if hover is None:
            return None
        try:
            return measure_way(ground.world, ground.takeoff_enu_m, hover, self._openings(ground))
        except PlanningError:
            return None

    def _openings(self, ground: _Ground) -> Callable[[Float[np.ndarray, "n 3"]], Sequence[Opening]]:
        """Finds the openings of the scene: in a large one those about some points, else all."""
        known = ground.world.map
        if isinstance(known, WideMap):
            return known.openings_about
        return lambda _: _openings(self._scene)

    def _ground(self, start: Vector3) -> _Ground | None:
        """What is known of a start; None if the vehicle cannot stand there, or not leave it."""
        if start in self._barred:
            return None
        ground = self._grounds.pop(start, None)
        if ground is None:
            try:
                build_world(self._from(start), self._airframe)
                world = survey(self._from(start), self._airframe)
                ground = _Ground(world=world, takeoff_enu_m=takeoff_point(world))
            except (MissionError, WorldError):
                self._barred.add(start)
                return None
        self._grounds[start] = ground
        if len(self._grounds) > _KEPT_GROUNDS:
            self._grounds.popitem(last=False)
        return ground

    def _from(self, start: Vector3) -> Scene:
        """The scene with another start."""
        return replace(self._scene, start_position_enu_m=start)


@functools.lru_cache(maxsize=_KEPT_SCENES)
def _openings(scene: Scene) -> Sequence[Opening]:
    """Openings of a scene: seconds of work, and the same for every vehicle and start."""
    primitives = scene_primitives(scene)
    voxels = kept_distance_field(scene, FIELD_RESOLUTION_M, primitives)
    return find_openings(distance_field(voxels), scene_obstacles(scene, primitives))


def _one(rng: np.random.Generator, words: Sequence[_T]) -> _T:
    return words[int(rng.integers(len(words)))]


def _within(rng: np.random.Generator, bounds: Range) -> float:
    return round(float(rng.uniform(*bounds)), 2)


def _steps_between(grade: Grade, wanted: Grade) -> int:
    return abs(GRADES.index(grade) - GRADES.index(wanted))
