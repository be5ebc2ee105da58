"""Passages: doors and corridors, measured and widened."""

import dataclasses

import numpy as np
import pytest

from aeroscene.feasibility import FeasibilityCfg, make_feasible
from aeroscene.feasibility.wishes.passages import narrowest, passages, too_narrow, widened
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id
from tests.aeroscene.conftest import cached_scene


def part(number, category, centre, size, yaw_rad=0.0, **attributes):
    return SceneObject(
        id=number,
        scene_id="hall",
        parent_id=None,
        category_id=category_id(category),
        bbox=OrientedBox(centre, quat_from_yaw(yaw_rad), size),
        domain="indoor",
        attributes=attributes,
    )


def hall(*objects):
    return Scene(
        scene_id="hall",
        domain="indoor",
        seed=0,
        extent_min_enu_m=(-20.0, -20.0, 0.0),
        extent_max_enu_m=(20.0, 20.0, 4.0),
        start_position_enu_m=(0.0, 0.0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=0.0,
        longitude_deg=0.0,
        altitude_m=0.0,
        objects=objects,
    )


def corridor(yaw_rad=0.0):
    return part(0, "room", (0.0, 0.0, 1.5), (12.0, 3.0, 3.0), yaw_rad, use="corridor")


@pytest.mark.parametrize("yaw_rad", [0.0, 0.7, 2.0])
def test_a_corridor_is_as_wide_as_its_narrowest_place(yaw_rad):
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)

    def wall(along_m, across_m, size, z=1.5):
        centre = (c * along_m - s * across_m, s * along_m + c * across_m, z)
        return part(1, "wall", centre, size, yaw_rad)

    free = corridor(yaw_rad)
    assert narrowest(hall(free)).width_m == pytest.approx(3.0, abs=0.06)
    nib = wall(1.0, 1.0, (0.2, 1.0, 3.0))
    assert narrowest(hall(free, nib)).width_m == pytest.approx(2.0, abs=0.06)
    closed = wall(1.0, 0.0, (0.2, 3.0, 3.0))
    assert narrowest(hall(free, closed)).width_m < 0.2
    at_the_end = wall(5.9, 0.0, (0.2, 3.0, 3.0))
    assert narrowest(hall(free, at_the_end)).width_m == pytest.approx(3.0, abs=0.06)
    above = wall(1.0, 0.0, (0.2, 3.0, 0.5), 2.75)
    assert narrowest(hall(free, above)).width_m == pytest.approx(3.0, abs=0.06)


def test_other_rooms_and_walls_without_doors_are_no_passages():
    room = part(0, "room", (0.0, 0.0, 1.5), (12.0, 3.0, 3.0), use="office")
    wall = part(1, "wall", (0.0, 0.0, 1.5), (0.2, 3.0, 3.0))
    assert list(passages(hall(room, wall))) == []
    assert narrowest(hall(room, wall)) is None
    assert too_narrow(hall(room, wall), 2.0) is None


def test_a_narrow_door_is_named_and_widened():
    scene = hall(part(7, "wall", (0.0, 0.0, 1.5), (0.2, 5.0, 3.0), door_m=0.9))
    assert too_narrow(scene, 0.9) is None
    reason = "the door of object 7 is 0.90 m wide; valid: at least 1.8 m"
    assert too_narrow(scene, 1.8) == reason
    wide = widened(scene, 1.8)
    assert wide.objects[0].attributes["door_m"] == 1.8
    assert too_narrow(wide, 1.8) is None
    assert widened(wide, 1.0) == wide
    solid = hall(part(7, "wall", (0.0, 0.0, 1.5), (0.2, 5.0, 3.0)))
    assert widened(solid, 1.8) == solid


def test_a_door_that_its_wall_is_too_short_for_takes_the_scene_away():
    scene = cached_scene(311)
    doors = [p for p in passages(scene) if p.what == "door"]
    least_m = 0.2 + max(door.width_m for door in doors)
    asked = widened(scene, least_m)
    wide = make_feasible(asked, FeasibilityCfg(least_passage_m=least_m))
    short = [wall for wall in scene.objects if wall.id in {door.object_id for door in doors}]
    short_m = min(wall.bbox.s[1] for wall in short)
    is_possible = short_m >= least_m + 0.3
    assert (wide.report.rejection is None) == is_possible
    narrow = make_feasible(scene, FeasibilityCfg(least_passage_m=least_m))
    assert f"m wide; valid: at least {least_m:g} m" in str(narrow.report.rejection)
    assert make_feasible(scene, FeasibilityCfg(least_passage_m=0.5)).report.rejection is None
    assert dataclasses.asdict(FeasibilityCfg())["least_passage_m"] == 0.0
