from __future__ import annotations

import math

import pytest

from aeroscene.feasibility import FeasibilityCfg, make_feasible
from aeroscene.feasibility.doors import fit_openings
from aeroscene.feasibility.layout import layout_of
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import LAWN, garden, thing


def fitted(size, **attributes):
    layout = layout_of(garden(thing(9, "wall", (0.0, 0.0, 1.5), size, **attributes)))
    fit_openings(layout)
    attributes = layout.object(len(layout.objects) - 1).attributes
    return {name: float(value) for name, value in attributes.items()}


def test_doors_of_the_corpus_stay_as_they_are():
    layout = layout_of(cached_scene(311))
    fit_openings(layout)
    assert not layout.attributes


def test_a_door_keeps_within_its_wall():
    door = fitted((0.12, 4.0, 3.0), door_m=2.25, door_offset_m=3.0, door_height_m=3.4)
    assert abs(door["door_offset_m"]) + door["door_m"] / 2 < 2.0
    assert door["door_height_m"] < 3.0


def test_a_narrow_door_becomes_wide_enough_to_fly_through():
    assert fitted((0.12, 4.0, 3.0), door_m=0.6, door_offset_m=0.0)["door_m"] >= 1.6


def test_a_narrow_door_is_widened_no_further_than_its_wall_permits():
    door = fitted((0.12, 1.8, 3.0), door_m=1.4, door_offset_m=0.3)
    assert door["door_m"] == pytest.approx(1.5)
    assert abs(door["door_offset_m"]) + door["door_m"] / 2 < 0.9


def test_a_wall_too_short_for_its_door_loses_it():
    assert "door_m" not in fitted((0.12, 0.25, 3.0), door_m=2.25, door_offset_m=0.0)


def test_furniture_leaves_the_air_before_a_door_free():
    wall = thing(9, "wall", (0.0, 0.0, 1.56), (0.12, 4.0, 3.0), LAWN, door_m=1.5)
    crate = thing(10, "crate", (0.9, 0.2, 0.56), (1.0, 1.0, 1.0), LAWN)
    scene = make_feasible(garden(wall, crate), FeasibilityCfg(is_validated=False)).scene
    x, y, _ = scene.object_by_id[10].bbox.p
    assert abs(x) >= 1.3 + 0.5 - 0.01 or abs(y) >= 0.85 + 0.5 - 0.01


def bedroom(width_m, *furniture):
    """A room with a door in its western wall, and what stands in it."""
    half = width_m / 2
    walls = [
        thing(30, "wall", (-half - 0.06, 0.0, 1.56), (0.12, 3.0, 3.0), LAWN, door_m=1.5),
        thing(31, "wall", (half + 0.06, 0.0, 1.56), (0.12, 3.0, 3.0), LAWN),
        thing(32, "wall", (0.0, 1.56, 1.56), (width_m, 0.12, 3.0), LAWN),
        thing(33, "wall", (0.0, -1.56, 1.56), (width_m, 0.12, 3.0), LAWN),
    ]
    room = thing(34, "room", (0.0, 0.0, 1.56), (width_m, 3.0, 3.0), LAWN)
    return garden(*walls, room, *furniture)


def within(scene, row, width_m):
    """How far an object's box is from the western wall; it is in its room."""
    box = scene.object_by_id[row].bbox
    c, s = abs(math.cos(box.yaw_rad)), abs(math.sin(box.yaw_rad))
    reach_m = (c * box.s[0] + s * box.s[1]) / 2
    assert abs(box.p[0]) + reach_m <= width_m / 2 + 0.01
    return box.p[0] - reach_m + width_m / 2


@pytest.mark.parametrize(("width_m", "least_m"), [(5.0, 1.2), (2.9, 0.25)])
def test_a_bed_leaves_a_door_the_air_that_its_room_has(width_m, least_m):
    bed = thing(40, "bed", (-0.2, 0.0, 0.36), (2.1, 1.8, 0.6), 34)
    feasible = make_feasible(bedroom(width_m, bed), FeasibilityCfg(is_validated=False))
    assert within(feasible.scene, 40, width_m) >= least_m - 0.01


def test_a_bed_without_a_place_takes_that_of_what_is_smaller():
    bed = thing(40, "bed", (0.2, 0.0, 0.36), (2.1, 1.8, 0.6), 34)
    stands = [
        thing(41 + n, "nightstand", (1.1, y, 0.36), (0.4, 0.5, 0.6), 34)
        for n, y in enumerate((0.8, -0.8))
    ]
    feasible = make_feasible(bedroom(2.9, bed, *stands), FeasibilityCfg(is_validated=False))
    for row in (40, 41, 42):
        within(feasible.scene, row, 2.9)
