"""Plans in large scenes: found about a coarse way, proved by all obstacles, as good as others."""

import math

import numpy as np
import pytest

from aeroscene.solids import field_cache, wide_field
from aeroscene.sources import load_scene
from autonomy.mapping import GivenMap, WideMap
from autonomy.mapping.coarse_path import coarse_path
from autonomy.planning import PlanningError
from flightsim.vehicles import airframe_by_name
from scenarios.mission.goals import fitting_areas, is_indoor
from scenarios.mission.mission import plan_mission
from scenarios.tasks.recipe import Recipe
from scenarios.tasks.sampler import Sampler


@pytest.fixture
def everything_is_wide(monkeypatch):
    """Every scene is planned in as if it were a large one."""
    monkeypatch.setattr(wide_field, "MOST_WHOLE_CELLS", 0)
    yield
    field_cache.forget()


@pytest.fixture(scope="module")
def scene_42():
    return load_scene("corpus:42")


@pytest.fixture(scope="module")
def iris():
    return airframe_by_name("iris")


def test_ways_across_are_as_quick_as_in_a_whole_map_and_are_proved(scene_42, iris, request):
    start = scene_42.start_position_enu_m
    fit = fitting_areas(scene_42, iris)
    far = sorted(fit, key=lambda area: -math.dist(area.centroid, start))[:3]
    wholes = [plan_mission(scene_42, iris, area=area) for area in far]
    request.getfixturevalue("everything_is_wide")
    for area, whole in zip(far, wholes, strict=True):
        wide = plan_mission(scene_42, iris, area=area)
        assert isinstance(whole.surroundings.map, GivenMap)
        assert isinstance(wide.surroundings.map, WideMap)
        assert whole.trajectory.duration_s > 8.0
        assert wide.hover_enu_m == whole.hover_enu_m
        assert wide.trajectory.duration_s <= 1.1 * whole.trajectory.duration_s
        # The proof in the other map's terms too.
        assert whole.surroundings.clearance_m(wide.path_enu_m(0.05)[1:]).min() > 0.05


@pytest.mark.usefixtures("everything_is_wide")
def test_it_plans_into_rooms_through_doors_that_large_cells_close(iris, scene_42):
    indoors = [a for a in scene_42.landing_areas if is_indoor(scene_42, a)]
    planned = 0
    for area in indoors[:4]:
        try:
            planned += plan_mission(scene_42, iris, area=area).area == area
        except ValueError:
            continue
    assert planned


@pytest.mark.usefixtures("everything_is_wide")
def test_a_goal_off_the_map_is_refused(scene_42, iris):
    mission = plan_mission(scene_42, iris)
    x, y, _ = scene_42.extent_max_enu_m
    start = mission.trajectory.sample(0.0)
    with pytest.raises(PlanningError, match="outside the map"):
        mission.surroundings.plan(start, (x + 50.0, y, 5.0))


@pytest.mark.usefixtures("everything_is_wide")
def test_tasks_are_drawn_and_graded_in_large_scenes(scene_42, iris):
    task = Sampler("42", scene_42, iris, Recipe()).task(0)
    assert task.area >= 0


@pytest.mark.usefixtures("everything_is_wide")
def test_the_coarse_way_joins_its_ends_in_short_steps(scene_42, iris):
    mission = plan_mission(scene_42, iris)
    known = mission.surroundings.map
    ends = np.array([mission.takeoff_enu_m, mission.hover_enu_m])
    way = coarse_path(known.coarse, ends, known.radius_m)
    assert np.allclose(way[[0, -1]], ends)
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < 2.0
