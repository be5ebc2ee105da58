"""Tasks by number: always the same, within the recipe, of the grade whose turn it is."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from aeroscene.sources import load_scene
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim import vehicles
from flightsim.plant.timed_failures import parse_failures
from flightsim.vehicles.catalogue import AIRFRAMES, airframe_by_name
from scenarios.mission.goals import fitting_areas, is_indoor
from scenarios.mission.surroundings import sphere_radius_m
from scenarios.tasks.path_difficulty import (
    GRADES,
    MOST_POINTS,
    THIRDS,
    PathFigures,
    least_navigation_s,
)
from scenarios.tasks.reach import NoTaskError
from scenarios.tasks.recipe import Recipe
from scenarios.tasks.sampler import MOST_SHARE, Sampler
from scenarios.words.goal_choice import choose_goal
from tests.scenarios.landing_scenes import field, thing

IRIS = AIRFRAMES["iris"]
SHIPPED = Path(vehicles.__file__).parent / "shipped" / "iris.toml"
RECIPE = Recipe(
    wind_mps=(1.0, 2.0),
    gust_mps=(0.0, 3.0),
    gnss=("rtk", "standard"),
    depth_camera=("exact", "d435"),
    map=("truth", "onboard"),
    draws=2,
)


@pytest.fixture(scope="module")
def scene():
    return load_scene("7")


def test_a_task_depends_on_its_number_alone(scene):
    """Not on what was drawn before, nor on the process."""
    one, other = Sampler("7", scene, IRIS, RECIPE), Sampler("7", scene, IRIS, RECIPE)
    first = [one.task(n) for n in range(6)]
    assert [other.task(n) for n in (5, 0, 3)] == [first[5], first[0], first[3]]
    reseeded = Sampler("7", scene, IRIS, dataclasses.replace(RECIPE, seed=1))
    assert [reseeded.task(n) for n in range(6)] != first
    assert [task.trial_id for task in first[:2]] == ["7/iris/0", "7/iris/1"]


def test_a_vehicle_from_a_file_has_its_tasks_by_name_and_is_found_by_its_path(scene, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(SHIPPED.read_text())
    mine = airframe_by_name(str(path))
    task = Sampler("7", scene, mine, RECIPE).task(1)
    assert dataclasses.replace(task, vehicle="iris") == Sampler("7", scene, IRIS, RECIPE).task(1)
    assert task.trial_id == f"7/{path}/1"
    assert airframe_by_name(task.cfg().bench.vehicle) == mine


def test_tasks_keep_to_the_recipe(scene):
    sampler = Sampler("7", scene, IRIS, RECIPE)
    tasks = [sampler.task(n) for n in range(24)]
    areas = {area.id: area for area in fitting_areas(scene, IRIS)}
    starts = {scene.start_position_enu_m, *(area.centroid for area in areas.values())}
    for task in tasks:
        assert task.start in starts
        assert task.start != areas[task.area].centroid
        assert 1.0 <= task.wind_mps <= 2.0
        assert 0.0 <= task.gust_mps <= 3.0
        assert task.way.way_m > 0.0
    for name in ("gnss", "depth_camera", "map"):
        assert {getattr(task, name) for task in tasks} == set(getattr(RECIPE, name))
    assert len({task.seed for task in tasks}) == len(tasks)
    assert len({task.start for task in tasks}) > 2
    own = Sampler("7", scene, IRIS, dataclasses.replace(RECIPE, start=("own",))).task(0)
    assert (own.start, own.start_yaw_rad) == (scene.start_position_enu_m, scene.start_yaw_rad)


def test_grades_follow_from_the_thirds():
    middle = {name: (low + high) / 2 for name, (low, high) in THIRDS.items()}
    easy = {name: low for name, (low, _) in THIRDS.items()}
    hard = {name: high + (high - low) for name, (low, high) in THIRDS.items()}
    assert [PathFigures(**each).points for each in (easy, middle, hard)] == [0, 4, 8]
    assert PathFigures(**easy).grade == "easy"
    assert PathFigures(**hard).grade == "hard"
    assert list(MOST_POINTS) == list(GRADES)


def test_a_wall_with_a_gap_makes_a_way_harder():
    """Longer, narrower, with more about it, and through an opening."""
    recipe = Recipe(start=("own",))
    scene = field()
    walls = (
        thing(30, "wall", (10.0, 7.9, 6.0), (0.4, 14.2, 12.0)),
        thing(31, "wall", (10.0, -7.9, 6.0), (0.4, 14.2, 12.0)),
        thing(32, "wall", (10.0, 0.0, 7.2), (0.4, 1.6, 9.6)),
    )
    walls = tuple(dataclasses.replace(wall, scene_id="field") for wall in walls)
    walled = dataclasses.replace(scene, objects=(*scene.objects, *walls))
    free = Sampler("field", scene, IRIS, recipe).task(0).way
    narrow = Sampler("field", walled, IRIS, recipe).task(0).way
    assert narrow.corridor_m < 1.7 < free.corridor_m
    assert (narrow.openings, free.openings) == (1, 0)
    assert narrow.clutter > free.clutter
    assert narrow.way_m > free.way_m
    assert narrow.points > free.points


@pytest.mark.parametrize(("ends", "sides"), [("indoor", {True}), ("outdoor", {False})])
def test_both_ends_lie_where_the_recipe_says(ends, sides):
    mixed = load_scene("6")
    recipe = dataclasses.replace(RECIPE, start=("area",), ends=ends, draws=1)
    tasks = [Sampler("6", mixed, AIRFRAMES["hummingbird"], recipe).task(n) for n in range(3)]
    areas = {area.id: area for area in mixed.interaction_areas}
    begun = {area.centroid: area for area in mixed.interaction_areas}
    assert {is_indoor(mixed, areas[task.area]) for task in tasks} == sides
    assert {is_indoor(mixed, begun[task.start]) for task in tasks} == sides


def test_a_way_through_leads_in_or_out():
    mixed = load_scene("6")
    recipe = dataclasses.replace(RECIPE, start=("area",), ends="through", draws=1)
    areas = {area.id: area for area in mixed.interaction_areas}
    begun = {area.centroid: area for area in mixed.interaction_areas}
    for number in range(3):
        task = Sampler("6", mixed, AIRFRAMES["hummingbird"], recipe).task(number)
        assert is_indoor(mixed, areas[task.area]) != is_indoor(mixed, begun[task.start])


def test_the_hull_decides_what_can_be_reached():
    """A gap that the sphere fits through joins both sides, though planners keep away from it."""
    radius_m = sphere_radius_m(IRIS)
    for gap_m, is_wide in ((2 * radius_m + 1.0, True), (2 * radius_m - 0.1, False)):
        half_m = (30.0 - gap_m) / 2
        walls = tuple(
            thing(30 + i, "wall", (10.0, s * (gap_m + half_m) / 2, 6.0), (0.4, half_m, 12.0))
            for i, s in enumerate((-1, 1))
        )
        lid = thing(32, "wall", (10.0, 0.0, 7.2), (0.4, gap_m, 9.6))
        walls = tuple(dataclasses.replace(wall, scene_id="field") for wall in (*walls, lid))
        scene = dataclasses.replace(field(), objects=(*field().objects, *walls))
        sampler = Sampler("field", scene, IRIS, Recipe(start=("own",)))
        if is_wide:
            assert sampler.task(0).way.corridor_m < gap_m + 0.3
        else:
            with pytest.raises(NoTaskError):
                sampler.task(0)


def test_failures_are_drawn_within_their_bounds(scene):
    words = ("gnss+vio=off@2:8", "motor=slow@3")
    recipe = dataclasses.replace(RECIPE, failures=words, draws=1)
    sampler = Sampler("7", scene, IRIS, recipe)
    found = [parse_failures(sampler.task(n).failures, 4) for n in range(8)]
    assert {each[0].part for each in found} == {"gnss", "motor"}
    for first, *others in found:
        assert 2.0 <= first.after_s <= 8.0
        assert {each.after_s for each in others} <= {first.after_s}
        assert (first.part == "motor") == (not others)
    # What else is drawn does not depend on it.
    usual = Sampler("7", scene, IRIS, dataclasses.replace(RECIPE, draws=1)).task(0)
    assert dataclasses.replace(sampler.task(0), failures="none") == usual


def test_light_is_drawn_in_words_and_moves_no_other_draw(scene):
    recipe = dataclasses.replace(RECIPE, light=("dusk, fog 80 m", "random"), season=("winter",))
    lit, plain = Sampler("7", scene, IRIS, recipe), Sampler("7", scene, IRIS, RECIPE)
    tasks, words = [lit.task(n) for n in range(8)], set()
    for number, task in enumerate(tasks):
        default = {"light": "afternoon", "season": "summer"}
        assert dataclasses.replace(task, **default) == plain.task(number)
        assert task.season == "winter"
        # A seed that drew the light need not draw it again: the words say which it was.
        bench = task.cfg().bench
        assert bench.light == task.light == str(bench.weather) != "random"
        words.add(task.light)
    assert "dusk, fog 80 m" in words
    assert len(words) > 2


def test_a_vehicle_without_the_motor_that_fails_has_no_task(scene):
    recipe = dataclasses.replace(RECIPE, failures=("motor6=off@3",), draws=1)
    with pytest.raises(NoTaskError, match="iris: fail 'motor6=off@3': part 'motor6' is unknown"):
        Sampler("7", scene, IRIS, recipe).task(0)


def test_a_race_allows_multiples_of_the_least_time(scene):
    recipe = dataclasses.replace(RECIPE, navigation_within=2.0, draws=1)
    task = Sampler("7", scene, IRIS, recipe).task(0)
    least_s = least_navigation_s(task.way.way_m, IRIS)
    assert task.navigation_limit_s == pytest.approx(2.0 * least_s, abs=0.01)
    assert task.cfg().navigation_limit_s == task.navigation_limit_s


def test_ways_are_as_long_where_only_cells_about_them_are_computed(scene, monkeypatch):
    recipe = dataclasses.replace(RECIPE, draws=1)
    usual = Sampler("7", scene, IRIS, recipe).task(0)
    for module in ("scenarios.tasks.reach", "scenarios.mission.maps"):
        monkeypatch.setattr(f"{module}.is_wide", lambda *_: True)
    sampler = Sampler("7", scene, IRIS, recipe)
    wide = sampler.task(0)
    assert sampler._reach.wide is not None
    assert (wide.start, wide.area) == (usual.start, usual.area)
    assert wide.way.way_m == pytest.approx(usual.way.way_m, rel=0.1)


def test_a_scene_that_leads_nowhere_is_named():
    scene = dataclasses.replace(field(), interaction_areas=())
    with pytest.raises(NoTaskError, match="scene field, iris: free space joins no start"):
        Sampler("field", scene, IRIS, Recipe()).task(0)


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
def test_the_least_time_is_that_of_full_tilt_there_and_back(vehicle):
    airframe = AIRFRAMES[vehicle]
    craft = airframe.quadrotor
    way_m, time_s = 30.0, least_navigation_s(30.0, airframe)
    thrust_mps2 = craft.max_thrust_n / craft.mass_kg
    tilt_rad = math.acos(GRAVITY_MPS2 / thrust_mps2)
    # Integrated in steps: forwards for half of the time, backwards for the other.
    step_s = time_s / 20_000
    signs = np.repeat([1.0, -1.0], 10_000)
    speeds_mps = np.cumsum(signs * thrust_mps2 * math.sin(tilt_rad)) * step_s
    assert speeds_mps[-1] == pytest.approx(0.0, abs=1e-6)
    assert np.sum(speeds_mps) * step_s == pytest.approx(way_m, rel=1e-3)


def test_a_goal_in_words_is_one_that_chance_does_not_find():
    scene, hummingbird = load_scene("45"), AIRFRAMES["hummingbird"]
    recipe = Recipe(goals=("relation",), draws=1)
    tasks = [Sampler("45", scene, hummingbird, recipe).task(trial) for trial in (0, 0, 1)]
    assert tasks[0] == tasks[1]
    n_areas = len(fitting_areas(scene, hummingbird))
    for task in tasks[1:]:
        assert task.text
        assert task.area in task.goal_areas
        assert len(task.goal_areas) <= MOST_SHARE * n_areas
        goal = choose_goal(
            task.place(scene),
            hummingbird,
            asked="relation",
            seed=task.seed,
            area=next(area for area in scene.landing_areas if area.id == task.area),
        )
        # The run of the task draws the same text.
        assert goal.text == task.text


def test_goals_in_words_change_nothing_else_of_a_task(scene):
    plain = Sampler("7", scene, IRIS, Recipe(draws=1)).task(3)
    assert (plain.goal, plain.text, plain.goal_areas) == ("area", None, (plain.area,))
    with pytest.raises(NoTaskError, match="that a text of grade naming names alone"):
        Sampler("field", field(), IRIS, Recipe(goals=("naming",), draws=1)).task(0)
