from __future__ import annotations

from dataclasses import replace

import pytest

from aeroscene.feasibility import validity
from aeroscene.scene import Scene
from tests.aeroscene.feasibility.scenes import BENCH, CUP, LAWN, TABLE, garden, thing, unsettled


def test_corpus_scenes_are_wholly_valid(scene: Scene):
    verdict = validity(scene)
    assert verdict.is_valid.all()


def test_noise_makes_objects_invalid(scene_42: Scene):
    verdict = validity(unsettled(scene_42, 0.3, seed=1))
    assert 0.05 < verdict.is_valid.mean() < 0.7


@pytest.mark.parametrize(
    ("changed", "flaw"),
    [
        (thing(BENCH, "bench", (-6.0, 0.0, 0.46), (0.6, 1.8, 0.8), LAWN), "is_free"),
        (thing(BENCH, "bench", (-6.0, -5.0, 0.9), (0.6, 1.8, 0.8), LAWN), "is_standing"),
        (thing(BENCH, "bench", (-6.0, -5.0, 0.42), (0.6, 1.8, 0.8), LAWN), "is_sunk"),
        (thing(BENCH, "bench", (-6.0, -17.0, 0.4), (0.6, 1.8, 0.8), LAWN), "is_away"),
    ],
)
def test_each_flaw_is_told_apart(changed, flaw):
    scene = garden(changed)
    row = [obj.id for obj in scene.objects].index(BENCH)
    verdict = validity(scene)
    assert not verdict.is_valid[row]
    flaws = {
        "is_free": not verdict.is_free[row],
        "is_standing": not verdict.is_standing[row],
        "is_sunk": bool(verdict.is_sunk[row]),
        "is_away": bool(verdict.is_away[row]),
    }
    assert flaws[flaw]
    others = [obj.id not in {BENCH, TABLE, CUP} for obj in scene.objects]
    assert verdict.is_valid[others].all()


def test_a_touch_is_no_overlap():
    beside = thing(BENCH, "bench", (-5.105, 0.0, 0.46), (0.6, 1.8, 0.8), LAWN)
    assert validity(garden(beside)).is_free.all()


def test_an_empty_scene_has_no_flaws():
    assert not len(validity(replace(garden(), objects=())).is_valid)
