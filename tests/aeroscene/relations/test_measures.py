import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.relations import Kind, scene_relations
from aeroscene.relations.measures import (
    pinned_error,
    relation_shares,
    strewn,
)
from aeroscene.scene.box import quat_from_yaw
from tests.aeroscene.relations.rooms import dining, office


def test_chance_pins_little(scenes):
    rng = np.random.default_rng(5)
    real, chance = relation_shares(scenes), relation_shares([strewn(s, rng) for s in scenes])
    assert real.pinned > 0.3 > 0.12 > chance.pinned
    assert real.explained > chance.explained + 0.2
    assert real.in_rows > 0.08 > 0.02 > chance.in_rows


def test_pinned_places_are_off_by_centimetres(scenes):
    error = pinned_error(scenes)
    assert error.before_m > 1.0
    assert error.after_m < 0.05


def test_half_of_the_chairs_turned_are_no_longer_seated(scenes):
    def turned(scene):
        objects = list(scene.objects)
        chairs = [index for index, obj in enumerate(objects) if obj.category == "chair"]
        for index in chairs[::2]:
            box = objects[index].bbox
            bbox = replace(box, q=quat_from_yaw(box.yaw_rad + math.radians(50)))
            objects[index] = replace(objects[index], bbox=bbox)
        return replace(scene, objects=tuple(objects), interaction_areas=())

    before, after = relation_shares(scenes), relation_shares(map(turned, scenes))
    n_chairs = sum(obj.category == "chair" for scene in scenes for obj in scene.objects)
    assert before.pinned - after.pinned > 0.35 * n_chairs / before.n_objects


@pytest.mark.parametrize("fault", [{"turned_deg": 50.0}, {"shift_m": 1.0}])
def test_chairs_turned_or_moved_off_their_table_are_not_seated(fault):
    def n_seated(scene):
        seats = [unit for unit in scene_relations(scene) if unit.relation.kind == Kind.SEAT]
        return sum(len(unit.members) for unit in seats)

    assert n_seated(dining()) == 4
    assert n_seated(dining(**fault)) == 2


def test_desks_out_of_their_row_are_in_none():
    off_m = (0.5, 0.0, -0.3, 0.5, -0.5, 0.6, 0.4, -0.4)
    even, uneven = office(), office(off_m)
    assert relation_shares([even]).in_rows == 1.0
    assert relation_shares([uneven]).in_rows == 0.0


def test_desks_of_other_sizes_are_a_row_but_not_of_equals():
    scene = office()
    desks = [
        replace(obj, bbox=replace(obj.bbox, s=(0.8, 1.4 + 0.04 * (index % 2), 0.74)))
        for index, obj in enumerate(scene.objects[1:])
    ]
    scene = replace(scene, objects=(scene.objects[0], *desks))
    assert relation_shares([scene]).in_rows == 0.0
    assert len(scene_relations(scene)) == 1
