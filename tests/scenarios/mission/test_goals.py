"""Starts and goals: drawn fairly, named by number or place, refused with what is valid."""

import collections
import dataclasses

import pytest

from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.goals import GoalError, draw_goals, find_area, with_start
from scenarios.mission.mission import plan_mission
from tests.scenarios.landing_scenes import (
    CONTAINER,
    ON_CONTAINER,
    ON_LAWN,
    UNDER_THE_START,
    rectangle,
    thing,
    yard,
)

IRIS, HUMMINGBIRD = AIRFRAMES["iris"], AIRFRAMES["hummingbird"]
N_DRAWS = 400


def two_indoors_of_eight():
    """A yard with a slab indoors that bears two areas, beside six outdoors."""
    slab = thing(80, "crate", (-8.0, 0.0, 0.01), (4.0, 4.0, 0.02))
    slab = dataclasses.replace(slab, domain="indoor")
    indoors = [rectangle(n, (-9.0 + n - 20, 0.0, 0.02), (0.5, 0.5), 80) for n in (20, 22)]
    outdoors = [rectangle(n, (n - 30.0, 12.0, 0.0), (0.5, 0.5), None) for n in range(30, 36)]
    plain = yard(areas=())
    areas = (*indoors, *outdoors)
    return dataclasses.replace(plain, objects=(*plain.objects, slab), interaction_areas=areas)


def test_goals_are_drawn_indoors_as_often_as_outdoors_and_evenly_within_each():
    scene = two_indoors_of_eight()
    firsts = collections.Counter(draw_goals(scene, IRIS, seed)[0].id for seed in range(N_DRAWS))
    # Four standard deviations of a binomial.
    assert firsts[20] + firsts[22] == pytest.approx(N_DRAWS / 2, abs=40)
    assert firsts[20] == pytest.approx(N_DRAWS / 4, abs=35)
    for number in range(30, 36):
        assert firsts[number] == pytest.approx(N_DRAWS / 12, abs=22)


def test_every_area_comes_once_and_the_same_seed_draws_the_same():
    scene = two_indoors_of_eight()
    drawn = draw_goals(scene, IRIS, 5)
    assert sorted(area.id for area in drawn) == [20, 22, *range(30, 36)]
    assert drawn == draw_goals(scene, IRIS, 5)


def test_what_the_vehicle_stands_on_or_does_not_fit_on_is_no_goal():
    assert set(draw_goals(yard(), HUMMINGBIRD, 0)) == {ON_CONTAINER, ON_LAWN}
    away = dataclasses.replace(yard(), start_position_enu_m=(-3.0, -3.0, 0.0))
    assert set(draw_goals(away, HUMMINGBIRD, 0)) == {ON_CONTAINER, ON_LAWN, UNDER_THE_START}
    assert set(draw_goals(away, IRIS, 0)) == {ON_CONTAINER, ON_LAWN}


def test_an_area_that_cannot_be_reached_is_left_out_however_it_is_drawn():
    inside = rectangle(6, (9.0, 0.0, 1.0), (0.5, 0.5), CONTAINER)
    scene = yard(areas=(inside, ON_LAWN))
    firsts = {draw_goals(scene, IRIS, seed)[0].id for seed in range(10)}
    assert firsts == {inside.id, ON_LAWN.id}
    for seed in range(4):
        assert plan_mission(scene, IRIS, seed=seed).area == ON_LAWN
    assert plan_mission(scene, IRIS, seed=0, map_source="onboard").area == ON_LAWN


def test_an_area_is_found_by_its_number():
    assert find_area(yard(), IRIS, 1, "area") is ON_LAWN


@pytest.mark.parametrize(
    ("number", "says"),
    [
        (7, "area 7 is not in scene yard; valid: 0, 1"),
        (2, "area 2 is for class small, iris is of class medium; valid: 0, 1"),
    ],
)
def test_other_numbers_are_refused_with_those_that_are_valid(number, says):
    with pytest.raises(GoalError, match=says):
        find_area(yard(), IRIS, number, "area")


def test_a_start_is_a_point_or_an_area():
    assert with_start(yard(), IRIS, "1.5,-2,0").start_position_enu_m == (1.5, -2.0, 0.0)
    assert with_start(yard(), IRIS, "area:1").start_position_enu_m == ON_LAWN.centroid


@pytest.mark.parametrize(
    ("start", "says"),
    [
        ("area:x", "start 'area:x' names no area; valid: area:ID, or x,y,z"),
        ("area:9", "start area 9 is not in scene yard; valid: 0, 1"),
        ("area:2", "start area 2 is for class small"),
        ("1,2", "start '1,2' is no place; valid: area:ID, or x,y,z"),
        ("1,2,nan", "start '1,2,nan' is no place"),
        ("99,0,0", "start '99,0,0' is outside of scene yard"),
    ],
)
def test_other_starts_are_refused_with_what_is_valid(start, says):
    with pytest.raises(GoalError, match=says):
        with_start(yard(), IRIS, start)
