"""Starts from geometry: where nobody made a pad."""

import math
from dataclasses import replace

import pytest

from aeroscene.areas.start import LEAST_RADIUS_M, grounds_of, start_places, with_start
from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import GARDEN, HOME, garden, thing
from tests.aeroscene.layouts.samples import house


def without_pad(*changed):
    scene = garden(*changed)
    return replace(scene, objects=tuple(obj for obj in scene.objects if obj.id != HOME))


def test_a_garden_without_a_pad_starts_on_its_lawn_with_somewhere_to_fly_to():
    scene = with_start(without_pad(), grounds_of(without_pad()))
    assert scene is not None
    x, y, z = scene.start_position_enu_m
    assert z in {0.06, 0.1}
    assert scene.landing_areas
    assert all(
        math.hypot(obj.bbox.p[0] - x, obj.bbox.p[1] - y) > 2
        for obj in scene.objects
        if obj.id in {2, 4}
    )


def test_nothing_free_gives_no_start():
    hut = thing(9, "container", (0.0, 2.5, 1.5), (40.0, 60.0, 3.0))
    scene = without_pad(hut)
    assert with_start(scene, grounds_of(scene)) is None


def test_a_low_roof_is_in_the_way_and_a_high_one_is_not():
    for height_m, count in ((1.5, 0), (5.0, 1)):
        roof = thing(9, "canopy", (0.0, 0.0, height_m + 0.1), (60.0, 60.0, 0.2))
        (lawn, *_), *_ = grounds_of(without_pad(roof))
        found = list(start_places((roof,), [lawn]))
        assert bool(found) == bool(count)


def test_floors_of_a_building_lie_within_it():
    scene = cached_scene(311)
    assert scene.domain == "indoor"
    floors, *_ = grounds_of(scene)
    shell = next(obj for obj in scene.objects if obj.parent_id is None)
    assert floors
    assert all(shell.id in ground.within for ground in floors)
    assert list(start_places(scene.objects, floors))
    # Taken for an obstacle, the building would leave no floor.
    blocked = [replace(ground, within=frozenset()) for ground in floors]
    assert not list(start_places(scene.objects, blocked))


def test_rooms_of_others_come_before_their_yard_and_lawns_before_rooms():
    scene, _ = make_flyable(neutral_layout(house()))
    floors, yard, roads = grounds_of(scene)
    assert (len(floors), len(yard), len(roads)) == (2, 4, 0)
    assert all(ground.height_m == pytest.approx(0.02) for ground in (*floors, *yard))
    outdoor = grounds_of(replace(scene, domain="mixed"))
    assert outdoor == (yard, roads, floors)


def test_discs_are_as_wide_as_said():
    (x, y, _), _ = next(start_places(GARDEN, grounds_of(without_pad())[0]))
    for obj in GARDEN[2:5]:
        reach = math.hypot(*obj.bbox.s[:2]) / 2
        assert math.hypot(obj.bbox.p[0] - x, obj.bbox.p[1] - y) > reach + LEAST_RADIUS_M
