"""Clutter: more loose things, and still a scene that is sound."""

import numpy as np
import pytest

from aeroscene.feasibility import make_feasible
from aeroscene.feasibility.wishes.clutter import USUAL, cluttered
from aeroscene.scene.catalogue import LOOSE
from aeroscene.validation import validate
from tests.aeroscene.conftest import cached_scene


def loose(scene):
    return [obj for obj in scene.objects if obj.category in LOOSE]


@pytest.mark.parametrize("index", [42, 311])
def test_a_cluttered_scene_is_sound_and_keeps_what_was_there(index):
    scene = cached_scene(index)
    raw = cluttered(scene, 3.0, np.random.default_rng(1))
    n_more = len(raw.objects) - len(scene.objects)
    assert n_more >= 2 * USUAL
    assert raw.objects[: len(scene.objects)] == scene.objects
    found = make_feasible(raw)
    assert found.report.rejection is None
    assert not validate(found.scene)
    assert len(loose(found.scene)) >= len(loose(scene)) + 0.9 * n_more


def test_things_lie_on_open_ground_and_floors_and_are_of_real_sizes():
    scene = cached_scene(311)
    raw = cluttered(scene, 4.0, np.random.default_rng(2))
    more = raw.objects[len(scene.objects) :]
    hosts = {scene.object_by_id[obj.parent_id].category for obj in more}
    assert hosts <= {"room", "lawn", "plaza", "parking_lot", "sidewalk"}
    assert {obj.category for obj in more} == LOOSE
    for obj in more:
        host = scene.object_by_id[obj.parent_id].bbox
        offset = np.subtract(obj.bbox.p, host.p)[:2]
        c, s = np.cos(host.yaw_rad), np.sin(host.yaw_rad)
        local = np.abs([c * offset[0] + s * offset[1], c * offset[1] - s * offset[0]])
        assert (local < np.array(host.s[:2]) / 2).all()
        assert max(obj.bbox.s) <= 1.4


def test_once_is_no_clutter_and_the_same_seed_throws_the_same():
    scene = cached_scene(42)
    assert cluttered(scene, 1.0, np.random.default_rng(0)) is scene
    one, two = (cluttered(scene, 2.0, np.random.default_rng(5)) for _ in range(2))
    assert one == two
    assert one != cluttered(scene, 2.0, np.random.default_rng(6))
