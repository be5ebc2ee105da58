"""Draws tasks from a recipe: trial N of a scene and a vehicle is always the same.

Every kind of draw has its own random stream, named by scene, vehicle and trial. So a trial does not
depend on those drawn before it, and a new field of the recipe leaves all other draws as they were.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, TypeVar

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from aeroscene.solids.field_cache import cached_distance_field
from aeroscene.solids.shapes import scene_primitives
from autonomy.planning.openings import Opening, find_openings
from autonomy.types import Vector3
from flightsim.draws import generator
from flightsim.looks.weather import RANDOM, Weather, draw_weather, parse_weather
from flightsim.plant.timed_failures import TimedFailureError, parse_failures
from flightsim.vehicles import Airframe
from flightsim.world import WorldError, build_world
from scenarios.mission.goals import draw_goals, fitting_areas, is_indoor
from scenarios.mission.obstacles import distance_field, scene_obstacles
from scenarios.mission.surroundings import FIELD_RESOLUTION_M
from scenarios.tasks.drawn_failures import draw_failures
from scenarios.tasks.path_difficulty import (
    GRADES,
    Grade,
    PathFigures,
    least_navigation_s,
    measure_path,
)
from scenarios.tasks.reach import NoTaskError, Reach
from scenarios.tasks.recipe import Range, Recipe
from scenarios.tasks.task import Task
from scenarios.words.goal import Grade as GoalGrade
from scenarios.words.goal_choice import fitting
from scenarios.words.goal_drawing import WordGoal, draw_goal

_MOST_DRAWS = 60
"""Draws of a start and an area for one trial, including pairs that no free space joins."""
_SEEDS = 2**31
MOST_SHARE = 0.05
"""Greatest share of the fitting areas that may belong to the place that a text means: a pilot that
lands anywhere must not be right more often."""
_MOST_PATHS = 4
"""Number of nearest areas of such a place to which paths are measured."""
_KEPT_SCENES = 2  # of openings, which take seconds to find
_T = TypeVar("_T")


Side = Literal["indoor", "outdoor"]


class _Start(NamedTuple):
    """Start of a flight."""

    position_enu_m: Vector3
    yaw_rad: float
    side: Side


class _Asked(NamedTuple):
    """Text that a trial asks for."""

    grade: GoalGrade
    seed: int


class Sampler:
    """Draws the tasks of one vehicle in one scene, and keeps its measurements for the next ones."""

    def __init__(
        self, name: str, scene: Scene, airframe: Airframe, recipe: Recipe, family: str = ""
    ) -> None:
        """Prepare to draw.

        Args:
            name: Name by which the scene is opened.
            scene: The scene.
            airframe: Vehicle that flies.
            recipe: Distributions of the tasks.
            family: Name of the recipe among those of a suite.
        """
        self._family = family
        self._name = name
        self._scene = scene
        self._airframe = airframe
        self._recipe = recipe
        self._reach = Reach.from_scene(scene, airframe)
        self._places: dict[Vector3, Vector3 | None] = {}
        """Place of the vehicle's sphere above each start; None if it cannot stand there, or not
        rise."""
        self._goals: dict[tuple[int, _Asked], WordGoal | None] = {}
        self._paths: dict[tuple[Vector3, int], PathFigures | None] = {}

    def task(self, trial: int) -> Task:
        """Return the task of a trial by its number.

        Args:
            trial: Number of the trial, from 0.

        Raises:
            NoTaskError: If free space joins none of the drawn starts and areas.
        """
        recipe, scene_id = self._recipe, self._scene.scene_id
        stream = (self._airframe.name, trial)
        rng = generator(recipe.seed, scene_id, "conditions", *stream)
        seed = int(rng.integers(_SEEDS))
        kind = _one(generator(recipe.seed, scene_id, "goal kind", *stream), recipe.goals)
        asked = None if kind == "area" else _Asked(kind, seed)
        path_draws = generator(recipe.seed, scene_id, "way", *stream)
        start, area, path = self._draw_path(trial, path_draws, asked)
        goal = None if asked is None else self._goal(area, asked)
        weather = self._draw_weather(generator(recipe.seed, scene_id, "light", *stream))
        # Fields that draw from `rng` do so in this order: a new one must come last, or tasks
        # change.
        return Task(
            family=self._family,
            scene=self._name,
            vehicle=self._airframe.vehicle,
            trial=trial,
            seed=seed,
            start=start.position_enu_m,
            start_yaw_rad=start.yaw_rad,
            area=area.id,
            goal=kind,
            text=None if goal is None else goal.text,
            goal_areas=(area.id,) if goal is None else tuple(each.id for each in goal.areas),
            time_limit_s=recipe.time_limit_s,
            wind_mps=_within(rng, recipe.wind_mps),
            wind_from_deg=round(float(rng.uniform(0.0, 360.0)), 1),
            turbulence=_one(rng, recipe.turbulence),
            gust_mps=_within(rng, recipe.gust_mps),
            traffic=_one(rng, recipe.traffic),
            gnss=_one(rng, recipe.gnss),
            depth_camera=_one(rng, recipe.depth_camera),
            map=_one(rng, recipe.map),
            aiding=_one(rng, recipe.aiding),
            failures=self._draw_failures(rng),
            light=str(weather),
            season=weather.season,
            navigation_limit_s=self._navigation_limit_s(path),
            way=path,
        )

    def _draw_weather(self, rng: np.random.Generator) -> Weather:
        season, light = _one(rng, self._recipe.season), _one(rng, self._recipe.light)
        if light.strip().lower() == RANDOM:
            return draw_weather(rng, season)
        return parse_weather(light, season)

    def _draw_failures(self, rng: np.random.Generator) -> str:
        """Draw the failures of a task.

        Raises:
            NoTaskError: If the vehicle lacks the part.
        """
        n_rotors = len(self._airframe.motors)
        failures = draw_failures(_one(rng, self._recipe.failures), rng, n_rotors)
        try:
            parse_failures(failures, n_rotors)
        except TimedFailureError as error:
            raise NoTaskError(f"{self._airframe.name}: {error}") from None
        return failures

    def _navigation_limit_s(self, path: PathFigures) -> float | None:
        within = self._recipe.navigation_within
        if within is None:
            return None
        return round(within * least_navigation_s(path.way_m, self._airframe), 2)

    def _draw_path(
        self, trial: int, rng: np.random.Generator, asked: _Asked | None
    ) -> tuple[_Start, InteractionArea, PathFigures]:
        """Draw start, area and path: of the grade whose turn it is, else the nearest to it."""
        # Grades by turns, so that any first trials of a scene have all of them.
        wanted = self._recipe.difficulty[trial % len(self._recipe.difficulty)]
        found: list[tuple[_Start, InteractionArea, PathFigures]] = []
        for _ in range(_MOST_DRAWS):
            start, seed = self._draw_start(rng), int(rng.integers(_SEEDS))
            area = None if start is None else self._draw_area(start, seed, asked)
            if start is None or area is None:
                continue
            if (nearest := self._nearest_path(start, area, asked)) is None:
                continue
            area, path = nearest
            found.append((start, area, path))
            if path.grade == wanted or len(found) == self._recipe.draws:
                break
        if not found:
            raise NoTaskError(
                f"scene {self._scene.scene_id}, {self._airframe.name}: free space joins no start "
                f"to a {self._recipe.target} area for class {self._airframe.drone_class}"
                + ("" if asked is None else f" that a text of grade {asked.grade} names alone")
                + ("" if self._recipe.ends == "any" else f" with ends {self._recipe.ends}")
            )
        return min(found, key=lambda each: _steps_between(each[2].grade, wanted))

    def _draw_start(self, rng: np.random.Generator) -> _Start | None:
        """Draw a start that the recipe allows; None if the draw falls on none."""
        kind = _one(rng, self._recipe.start)
        areas = [
            area
            for area in fitting_areas(self._scene, self._airframe)
            if self._recipe.ends in {"any", "through", self._side(area)}
        ]
        # Drawn in any case, so that both kinds of start use the same number of draws.
        place, yaw_rad = int(rng.integers(_SEEDS)), float(rng.uniform(-math.pi, math.pi))
        own: Side = "indoor" if self._scene.domain == "indoor" else "outdoor"
        if (kind == "own" or not areas) and self._recipe.ends in {"any", "through", own}:
            scene = self._scene
            return _Start(scene.start_position_enu_m, scene.start_yaw_rad, own)
        if not areas:
            return None
        area = areas[place % len(areas)]
        return _Start(area.centroid, round(yaw_rad, 3), self._side(area))

    def _draw_area(self, start: _Start, seed: int, asked: _Asked | None) -> InteractionArea | None:
        """Return the first area that a seed draws for a start and the recipe allows, else None."""
        # From the drawn start, because the area under it is left out.
        scene = self._from(start.position_enu_m)
        drawn = draw_goals(scene, self._airframe, seed, self._recipe.target)
        goals = [goal for goal in drawn if self._may_end(start, goal)]
        if asked is not None:
            # A generator: texts are made only until one fits.
            goals = (goal for goal in goals if self._has_text(start, goal, asked))
        return next(iter(goals), None)

    def _has_text(self, start: _Start, area: InteractionArea, asked: _Asked) -> bool:
        """Return whether a text names only the place of an area, and chance hardly finds it."""
        goal = self._goal(area, asked)
        if goal is None:
            return False
        n_areas = len(fitting_areas(self._scene, self._airframe))
        stands_there = any(math.dist(start.position_enu_m, a.centroid) < 1e-6 for a in goal.areas)
        return len(goal.areas) <= MOST_SHARE * n_areas and not stands_there

    def _goal(self, area: InteractionArea, asked: _Asked) -> WordGoal | None:
        """The goal in words for the place of an area, as the run of the task draws it too."""
        key = (area.id, asked)
        if key not in self._goals:
            goal = draw_goal(self._scene, area, asked.grade, asked.seed)
            self._goals[key] = None if goal is None else fitting(goal, self._airframe)
        return self._goals[key]

    def _nearest_path(
        self, start: _Start, area: InteractionArea, asked: _Asked | None
    ) -> tuple[InteractionArea, PathFigures] | None:
        """Return the area with the shortest path among those on which a landing is a success."""
        goal = None if asked is None else self._goal(area, asked)
        areas = [area] if goal is None else goal.areas
        # Only a few paths are searched; the straight distance selects them.
        near = sorted(areas, key=lambda each: math.dist(each.centroid, start.position_enu_m))
        paths = [(each, self._path(start.position_enu_m, each)) for each in near[:_MOST_PATHS]]
        found = [(each, path) for each, path in paths if path is not None]
        return min(found, key=lambda each: each[1].way_m, default=None)

    def _may_end(self, start: _Start, area: InteractionArea) -> bool:
        ends, side = self._recipe.ends, self._side(area)
        return side != start.side if ends == "through" else ends in {"any", side}

    def _side(self, area: InteractionArea) -> Side:
        return "indoor" if is_indoor(self._scene, area) else "outdoor"

    def _path(self, start: Vector3, area: InteractionArea) -> PathFigures | None:
        """Return the figures of the path from a start to an area; None if there is none."""
        key = (start, area.id)
        if key not in self._paths:
            self._paths[key] = self._measured(start, area)
        return self._paths[key]

    def _measured(self, start: Vector3, area: InteractionArea) -> PathFigures | None:
        begin, end = self._place(start), self._reach.place_above(area.centroid)
        corners = None if begin is None or end is None else self._reach.shortest_path(begin, end)
        if corners is None:
            return None
        if (wide := self._reach.wide) is not None:
            return measure_path(self._reach, corners, wide.openings_about)
        return measure_path(self._reach, corners, lambda _: _openings(self._scene))

    def _place(self, start: Vector3) -> Vector3 | None:
        """The place of the sphere above a start; None if it cannot stand there, or not rise."""
        if start not in self._places:
            self._places[start] = self._reach.place_above(start)
            try:
                # The world refuses a start on which the vehicle cannot stand.
                build_world(self._from(start), self._airframe)
            except WorldError:
                self._places[start] = None
        return self._places[start]

    def _from(self, start: Vector3) -> Scene:
        """Return the scene with another start."""
        return replace(self._scene, start_position_enu_m=start)


@functools.lru_cache(maxsize=_KEPT_SCENES)
def _openings(scene: Scene) -> Sequence[Opening]:
    """Return the openings of a scene; kept, because they take seconds and serve all vehicles."""
    primitives = scene_primitives(scene)
    voxels = cached_distance_field(scene, FIELD_RESOLUTION_M, primitives)
    return find_openings(distance_field(voxels), scene_obstacles(scene, primitives))


def _one(rng: np.random.Generator, words: Sequence[_T]) -> _T:
    return words[int(rng.integers(len(words)))]


def _within(rng: np.random.Generator, bounds: Range) -> float:
    return round(float(rng.uniform(*bounds)), 2)


def _steps_between(grade: Grade, wanted: Grade) -> int:
    return abs(GRADES.index(grade) - GRADES.index(wanted))
