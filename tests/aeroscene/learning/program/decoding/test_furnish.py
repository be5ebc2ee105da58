"""Programs decoded beside objects that stand already."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.learning.program import decode, encode
from aeroscene.learning.program.decoding.draft import Given
from aeroscene.learning.program.decoding.furnish import furnish
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import LAWN, garden, thing


def with_given(number, is_given):
    """A scene's program, of which the objects that are chosen are given; and the scene."""
    scene = cached_scene(number)
    encoded = encode(scene)
    kept = tuple(obj for obj in scene.objects if is_given(obj))
    known = {obj.id for obj in kept}
    ids = {token: own for token, own in enumerate(encoded.object_ids) if own and set(own) <= known}
    kept = tuple(obj for obj in kept if any(obj.id in own for own in ids.values()))
    given = Given(replace(scene, objects=kept, interaction_areas=()), ids)
    return scene, given, encoded.program


@pytest.mark.parametrize("number", [7, 42, 311])
def test_what_is_all_given_is_what_comes_out(number):
    scene, given, program = with_given(number, lambda _: True)
    made = furnish(program, given, scene.scene_id, scene.seed)
    assert made.objects == scene.objects
    assert made.start_position_enu_m == scene.start_position_enu_m


@pytest.mark.parametrize("number", [7, 42, 311])
def test_fine_objects_come_back_beside_given_coarse_ones(number):
    scene, given, program = with_given(number, lambda obj: obj.is_coarse)
    made = furnish(program, given, "again", 5)
    n = len(given.scene.objects)
    assert [replace(o, scene_id=scene.scene_id) for o in made.objects[:n]] == list(
        given.scene.objects
    )
    assert (made.scene_id, made.seed) == ("again", 5)
    assert min(obj.id for obj in made.objects[n:]) > max(obj.id for obj in given.scene.objects)
    wanted = np.array([obj.bbox.p for obj in scene.objects if not obj.is_coarse])
    found = np.array([obj.bbox.p for obj in made.objects[n:]])
    assert len(found) == len(wanted)
    away_m = np.linalg.norm(found[:, None] - wanted, axis=2).min(axis=1)
    assert np.median(away_m) < 0.01
    assert (away_m < 0.3).mean() > 0.97


def test_chairs_without_room_at_a_given_table_are_left_out():
    """A table that is drawn would move with its chair to where both have room."""
    chair = thing(10, "chair", (-6.95, 0.0, 0.51), (0.5, 0.5, 0.9), LAWN)
    scene = garden(chair)
    encoded = encode(scene)
    ids = {token: own for token, own in enumerate(encoded.object_ids) if own and own != (10,)}
    crate = thing(11, "crate", (-7.1, 0.0, 0.56), (1.0, 1.0, 1.0), LAWN)
    for kept, categories in ((garden(), ["chair"]), (garden(crate), [])):
        made = furnish(encoded.program, Given(kept, ids), "garden", 0)
        assert made.objects[: len(kept.objects)] == kept.objects
        assert [obj.category for obj in made.objects[len(kept.objects) :]] == categories


@pytest.mark.parametrize(
    ("side_m", "categories"), [(25.0, ["tree"]), (30.0, [])], ids=["room at the edge", "no room"]
)
def test_what_has_no_room_anywhere_and_would_stand_deep_in_others_is_left_out(side_m, categories):
    tree = thing(10, "tree", (10.0, 2.0, 2.06), (2.0, 2.0, 4.0), LAWN)
    encoded = encode(garden(tree))
    ids = {token: own for token, own in enumerate(encoded.object_ids) if own and own != (10,)}
    hall = thing(11, "warehouse", (0.0, 0.0, 3.06), (side_m, side_m, 6.0), LAWN)
    kept = garden(hall)
    made = furnish(encoded.program, Given(kept, ids), "garden", 0)
    assert [obj.category for obj in made.objects[len(kept.objects) :]] == categories


@pytest.mark.parametrize("tiles", [(0, 0), (0, 1)], ids=["one room", "two rooms"])
def test_only_the_tiles_of_one_room_are_no_obstacle_to_each_other(tiles):
    """A table reaches over the line between two tiles, and stays where it was drawn."""
    rooms = [
        thing(i, "room", (4.0 * i, i, 1.5), (4.0, 6.0 - 2.0 * i, 3.0), room=tile)
        for i, tile in enumerate(tiles)
    ]
    table = thing(2, "table", (1.7, 0.0, 0.375), (1.6, 1.6, 0.75), 0)
    scene = replace(garden(), objects=(*rooms, table), domain="indoor")
    scene = replace(scene, objects=tuple(replace(o, domain="indoor") for o in scene.objects))
    encoded = encode(scene)
    made = decode(encoded.program).scene
    (found,) = [obj.bbox.p for obj in made.objects if obj.category == "table"]
    assert (found == pytest.approx(table.bbox.p, abs=0.01)) == (tiles == (0, 0))
