import math

import numpy as np
import pytest

from aeroscene.metrics.consistency import coarse_to_fine_consistency, mean_consistency
from aeroscene.metrics.damage import jittered
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.metrics.scenes import box, scene_of


def measured(*fine, yaw_deg=0.0):
    room = ("room", box((0, 0, 2), (6, 8, 4), yaw_deg))
    tower = ("tower", box((30, 0, 10), (6, 6, 20)))
    return coarse_to_fine_consistency(scene_of(room, tower, *fine))


def test_inside_its_region_a_fine_object_is_where_it_belongs():
    inside = measured(("table", box((2.9, -3.9, 0.4), (1, 1, 0.8)), 0))
    assert (inside.border, inside.astray_share) == (0.0, 0.0)


@pytest.mark.parametrize("yaw_deg", [0.0, 90.0, 180.0])
def test_outside_it_the_distance_to_the_border_counts_in_half_diagonals(yaw_deg):
    half = {0.0: 3.0, 90.0: 4.0, 180.0: 3.0}[yaw_deg]
    outside = measured(("table", box((half + 2.5, 0, 0.4), (1, 1, 0.8)), 0), yaw_deg=yaw_deg)
    assert outside.border == pytest.approx(2.5 / 5.0)
    assert outside.astray_share == 1.0


def test_things_upon_things_belong_to_the_coarse_region_below():
    table = ("table", box((0, 0, 0.4), (1, 1, 0.8)), 0)
    on_it, away = (
        ("cup", box((0.4, 0, 0.9), (0.1, 0.1, 0.1)), 2),
        ("cup", box((9, 0, 1), (0.1,) * 3), 2),
    )
    assert measured(table, on_it).astray_share == 0.0
    assert measured(table, away).astray_share == 0.5


def test_the_centroid_is_that_of_the_nearest_coarse_object():
    near_tower = measured(("table", box((30, 3, 10), (1, 1, 0.8)), 0))
    assert near_tower.centroid == pytest.approx(3.0 / (math.hypot(6, 6, 20) / 2))


def test_without_a_coarse_ancestor_the_nearest_coarse_object_is_the_region():
    assert measured(("table", box((33.5, 0, 1), (1, 1, 0.8)))).astray_share == 1.0
    assert measured(("table", box((32.5, 0, 1), (1, 1, 0.8)))).astray_share == 0.0


def test_scenes_without_fine_or_without_coarse_objects_are_measured():
    assert measured().border == 0.0
    alone = coarse_to_fine_consistency(scene_of(("tree", box((0, 0, 20), (1, 1, 4)))))
    assert (alone.border, alone.centroid) == (0.0, 0.0)


def test_a_corpus_scene_is_consistent_and_a_jittered_one_the_less_the_more():
    scene, rng = cached_scene(42), np.random.default_rng(0)
    parts = [coarse_to_fine_consistency(jittered(scene, rng, spread_m=m)) for m in (0.0, 0.5, 2.0)]
    borders = [part.border for part in parts]
    assert borders[0] < 0.01 < 10 * borders[1] < 10 * borders[2]
    assert mean_consistency(parts).border == pytest.approx(np.mean(borders))
