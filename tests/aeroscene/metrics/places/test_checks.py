"""The checks on real scenes: hardly a fault, and of what is spoilt by half they find half."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from aeroscene.metrics.places.checks import CHECKS, place_figures
from aeroscene.metrics.places.top_view import TopView
from aeroscene.scene.catalogue import BACKED, BUILDINGS
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.metrics.places.faults import (
    changed,
    every,
    halves,
    scaled,
    shifted,
    strewn,
    turned_by,
    without,
)
from tests.aeroscene.metrics.scenes import scene_of
from tests.aeroscene.relations.rooms import office

NUMBERS = (5, 7, 26, 44, 62, 63, 69, 86, 108, 120, 145, 148)
"""Corpus scenes in which every check finds something to judge."""
BY_KEY = {check.key: check for check in CHECKS}


@cache
def real_scenes():
    """Not at import: every process of a test run imports this module."""
    return [cached_scene(number) for number in NUMBERS]


@pytest.fixture(scope="module")
def real():
    return place_figures(real_scenes())


def spoilt(key, spoil):
    return BY_KEY[key].figure([TopView(spoil(scene)) for scene in real_scenes()])


# Park paths lie apart, screens have two ends, bleachers end at a wall, rows of shelves stand free;
# twelve scenes have fewer rows than all.
OWN_LIMITS = {
    "averted_fronts": 20.0,
    "patches": 2.0,
    "loose_wall_ends": 20.0,
    "dead_end_stairs": 25.0,
    "backs_off_walls": 50.0,
    "lone_plates": 20.0,
    "in_rows": 8.0,
}


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.key)
def test_real_scenes_reach_the_goals_or_have_their_reasons(check, real):
    limit = OWN_LIMITS.get(check.key, check.goal)
    value = real[check.key]
    assert value >= limit if check.better == "higher" else value <= limit


VEHICLES = ("car", "van", "truck", "bus")
AWAY = shifted(300.0, 300.0)


@pytest.mark.parametrize(
    ("key", "categories", "change"),
    [
        ("averted_chairs", ("chair",), turned_by(180.0)),
        ("averted_chairs", ("chair",), turned_by(90.0)),
        ("averted_screens", ("laptop", "monitor"), turned_by(180.0)),
        ("wrong_way_vehicles", VEHICLES, turned_by(180.0)),
        ("wrong_way_vehicles", VEHICLES, turned_by(90.0)),
        ("lights_off_roads", ("traffic_light",), AWAY),
        ("stranded_boats", ("boat",), AWAY),
        ("dead_end_stairs", ("stairs",), AWAY),
        ("dead_end_stairs", ("stairs",), turned_by(180.0)),
        ("remote_parking", ("parking_lot",), AWAY),
        ("idle_bridges", ("bridge",), AWAY),
        ("lone_plates", ("plate",), AWAY),
        ("loose_wall_ends", ("wall",), shifted(0.0, 0.0, 90.0)),
        ("backs_off_walls", BACKED, shifted(0.8)),
    ],
)
def test_of_real_things_half_of_which_are_spoilt_half_are_found(key, categories, change, real):
    views = [TopView(changed(*each, change)) for each in halves(real_scenes(), *categories)]
    sound = 100 - real[key]
    assert BY_KEY[key].figure(views) == pytest.approx(real[key] + sound / 2, abs=0.2 * sound)


@pytest.mark.parametrize("turn_deg", [90.0, 180.0])
def test_buildings_that_are_turned_look_elsewhere(real, turn_deg):
    views = [
        TopView(changed(*each, turned_by(turn_deg))) for each in halves(real_scenes(), *BUILDINGS)
    ]
    assert BY_KEY["averted_fronts"].figure(views) > 2 * real["averted_fronts"]


def test_rooms_without_half_of_the_walls_are_open(real):
    assert real["closed_outline"] == pytest.approx(100.0)
    views = [TopView(without(*each)) for each in halves(real_scenes(), "wall")]
    assert 50.0 < BY_KEY["closed_outline"].figure(views) < 95.0


def test_paving_that_is_torn_apart_is_in_patches(real):
    def torn(scene):
        paving = every(scene, "road", "sidewalk", "plaza", "parking_lot")
        return changed(scene, paving, scaled(0.8, 0.8))

    assert spoilt("patches", torn) > 3 * real["patches"]


def test_ground_that_has_shrunk_leaves_gaps(real):
    def shrunk(scene):
        grounds = ("road", "sidewalk", "lawn", "plaza", "parking_lot", "water", "terrain")
        return changed(scene, every(scene, *grounds), scaled(0.8, 0.8))

    assert real["covered_site"] > 95.0
    assert spoilt("covered_site", shrunk) < 85.0


def test_desks_out_of_line_are_uneven(real):
    views = [
        TopView(changed(*each, shifted(0.45, 0.45)))
        for each in halves(real_scenes(), "desk", "table")
    ]
    assert real["uneven_desks"] < 0.01
    assert BY_KEY["uneven_desks"].figure(views) > 0.05


def test_objects_anywhere_in_their_parents_have_no_order(real):
    rng = np.random.default_rng(3)
    views = [TopView(strewn(scene, rng)) for scene in real_scenes()]
    for key in ("pinned", "in_rows"):
        assert BY_KEY[key].figure(views) < real[key] / 4


@pytest.mark.parametrize(
    ("off_m", "width_steps_m", "in_rows"),
    [((), 0.0, 100.0), ((0.5, 0.0, -0.3, 0.5, -0.5, 0.6, 0.4, -0.4), 0.0, 0.0), ((), 0.04, 0.0)],
)
def test_desks_out_of_line_or_of_other_sizes_are_no_row_of_equals(off_m, width_steps_m, in_rows):
    scene = office(off_m)
    desks = [
        replace(obj, bbox=replace(obj.bbox, s=(0.8, 1.4 + width_steps_m * (index % 2), 0.74)))
        for index, obj in enumerate(scene.objects[1:])
    ]
    view = TopView(replace(scene, objects=(scene.objects[0], *desks)))
    assert BY_KEY["in_rows"].figure([view]) == in_rows


def test_without_anything_to_judge_there_is_no_figure():
    figures = place_figures([scene_of()])
    assert set(figures) == {check.key for check in CHECKS}
    assert all(math.isnan(value) for value in figures.values())


def test_scenes_weigh_by_what_is_judged_in_them():
    check = BY_KEY["averted_chairs"]
    views = [TopView(scene) for scene in real_scenes()]
    values = [value for view in views for value in check.judge(view)]
    assert check.figure(views) == pytest.approx(100 * sum(values) / len(values))
