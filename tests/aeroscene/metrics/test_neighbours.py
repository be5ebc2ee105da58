"""What nobody sees has no part in how a scene is judged; what everybody sees has."""

import math

import numpy as np
import pytest

from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.neighbours import neighbours_of
from aeroscene.metrics.orientation import TurnFrequencies
from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.catalogue import TWO_SIDED
from aeroscene.solids.shapes.build import object_parts
from aeroscene.solids.shapes.look import Look
from tests.aeroscene.conftest import SAMPLE, cached_scene
from tests.aeroscene.metrics.scenes import box, scene_of

_CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def beside_wall(wall_deg, bed_deg=0.0, nudge=0.0):
    return scene_of(
        ("room", box((0, 0, 1.5), (4, 3, 3))),
        ("roof", box((nudge, -nudge, 3.1), (4.3, 3.3, 0.2))),
        ("wall", box((2.1, 0, 1.5), (0.15, 3, 3), wall_deg)),
        ("bed", box((0.5, 0.2, 0.5), (2.0, 1.6, 0.9), bed_deg)),
    )


def relations(scene):
    near = neighbours_of(scene_arrays(scene))
    return np.stack([near.second, near.place, near.heading]).tolist()


def test_which_way_a_wall_faces_is_not_seen_and_which_way_a_bed_does_is():
    assert relations(beside_wall(180.0)) == relations(beside_wall(0.0))
    assert relations(beside_wall(90.0)) != relations(beside_wall(0.0))
    assert relations(beside_wall(0.0, bed_deg=180.0)) != relations(beside_wall(0.0))


def test_rounding_says_nothing_about_things_on_top_of_each_other():
    assert relations(beside_wall(0.0, nudge=1e-9)) == relations(beside_wall(0.0))
    assert relations(beside_wall(0.0, nudge=0.2)) != relations(beside_wall(0.0))


def test_orientation_is_judged_by_what_is_seen():
    usual = TurnFrequencies.of_arrays([scene_arrays(beside_wall(0.0))] * 40)
    plain, flipped, averted = (
        usual.plausibility(scene_arrays(beside_wall(*degrees)))
        for degrees in ((0.0,), (180.0,), (0.0, 180.0))
    )
    assert flipped == plain < averted - 0.3


def corners(category, size_m, attributes):
    parts = object_parts(category, Look(size_m, attributes, 0))
    found = [
        (np.array(part.vertices_m) if part.kind == "mesh" else _CORNERS * part.size_m)
        @ rotation_matrix(part.quat_wxyz).T
        + part.position_m
        for part in parts
    ]
    return np.concatenate(found)


def is_seen_twice(points_m, others_m):
    apart = np.linalg.norm(points_m[:, None] - others_m[None], axis=2)
    return bool(apart.min(axis=1).max() < 0.03)


def test_two_sided_things_look_the_same_after_half_a_turn_and_others_do_not():
    one_sided = dict.fromkeys(("chair", "car", "stairs", "shelf"), 0)
    for number in SAMPLE:
        for obj in cached_scene(number).objects:
            points_m = corners(obj.category, obj.bbox.s, obj.attributes)
            turned = dict(obj.attributes)
            if obj.category == "wall":
                turned |= {
                    name: -float(value)
                    for name, value in turned.items()
                    if name in {"door_offset_m", "window_offset_m"}
                }
            turned_m = corners(obj.category, obj.bbox.s, turned) * (-1.0, -1.0, 1.0)
            if obj.category in TWO_SIDED:
                assert is_seen_twice(points_m, turned_m), obj
            elif obj.category in one_sided:
                one_sided[obj.category] += not is_seen_twice(points_m, turned_m)
    assert min(one_sided.values()) > 0
    assert {*one_sided}.isdisjoint(TWO_SIDED)


@pytest.mark.parametrize("turn_deg", [0.0, 37.0, 90.0, 180.0, 271.0])
def test_neighbours_see_the_same_however_the_whole_is_turned(turn_deg):
    plain = beside_wall(0.0, bed_deg=30.0)
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    rows = []
    for obj in plain.objects:
        x, y, z = obj.bbox.p
        yaw_deg = math.degrees(obj.bbox.yaw_rad) + turn_deg
        rows.append((obj.category, box((c * x - s * y, s * x + c * y, z), obj.bbox.s, yaw_deg)))
    assert relations(scene_of(*rows)) == relations(plain)
