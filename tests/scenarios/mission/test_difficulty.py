"""Difficulty: what is straight and wide is easy, what winds and is narrow is hard."""

import dataclasses

import pytest

from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.difficulty import (
    MOST_POINTS,
    THIRDS,
    Difficulty,
    Way,
    measure_difficulty,
    measure_paths,
)
from scenarios.mission.surroundings import MissionError
from tests.scenarios.landing_scenes import field, thing

IRIS = AIRFRAMES["iris"]


def maze():
    """The field with three walls to its ceiling, each open at the other side."""
    scene = field()
    walls = [
        thing(30 + n, "wall", (x, y, 6.0), (0.4, 25.0, 12.0))
        for n, (x, y) in enumerate(((10.0, 2.5), (17.0, -2.5), (24.0, 2.5)))
    ]
    walls = [dataclasses.replace(wall, scene_id="field") for wall in walls]
    return dataclasses.replace(scene, objects=(*scene.objects, *walls))


def test_a_maze_is_harder_than_the_field_that_it_stands_in():
    straight, winding = measure_paths(field(), IRIS)[0], measure_paths(maze(), IRIS)[0]
    assert straight.over_straight == pytest.approx(1.0, abs=1e-3)
    assert straight.quarter_turns < 0.2
    assert winding.over_straight > 1.2
    assert winding.quarter_turns > 3.0
    assert winding.seconds > straight.seconds
    assert 0 < winding.least_clearance_m < straight.least_clearance_m
    easy, hard = measure_difficulty(field(), IRIS), measure_difficulty(maze(), IRIS)
    assert easy.points < hard.points
    assert hard.grade == "hard"
    assert easy.grade != "hard"


def test_points_are_counted_from_easy_to_hard_and_classes_follow():
    order = {"easy": 0, "medium": 1, "hard": 2}
    easy = Way(**{name: low - (high - low) for name, (low, high) in THIRDS.items()})
    middle = Way(**{name: (low + high) / 2 for name, (low, high) in THIRDS.items()})
    hard = Way(**{name: high + (high - low) for name, (low, high) in THIRDS.items()})
    found = [Difficulty(n_ways=1, way=way) for way in (easy, middle, hard)]
    assert [each.points for each in found] == [0, 4, 8]
    assert [order[each.grade] for each in found] == [0, 1, 2]
    assert MOST_POINTS["easy"] < MOST_POINTS["medium"] < MOST_POINTS["hard"] == 8


def test_what_stands_in_the_document_is_the_grade_and_its_figures():
    plain = measure_difficulty(field(), IRIS).to_plain()
    assert plain["difficulty"] in MOST_POINTS
    assert plain["ways"] == 1
    assert set(THIRDS) < set(plain)


def test_a_scene_without_a_way_is_named():
    scene = dataclasses.replace(field(), interaction_areas=())
    with pytest.raises(MissionError, match="scene field: no landing area can be flown to"):
        measure_difficulty(scene, IRIS)
