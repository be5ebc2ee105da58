import numpy as np
import pytest

from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.collision import collision_rate, collisions, overlaps, total
from aeroscene.metrics.damage import jittered
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.metrics.scenes import box, moved, scene_of


def found(scene, among):
    return collisions(overlaps(scene_arrays(scene)), among)


ROOM = scene_of(
    ("building", box((0, 0, 2), (10, 10, 4))),
    ("room", box((0, 0, 2), (9, 9, 3.8)), 0),
    ("wall", box((0, 0, 2), (0.2, 3, 3.8)), 1),
    ("table", box((0.5, 0, 0.4), (1, 1, 0.8)), 1),
    ("cup", box((0.05, 1, 1), (0.1, 0.1, 0.1)), 1),
    ("tree", box((20, 0, 3), (2, 2, 6))),
)
"""The table reaches 10 cm into the wall, the cup is all within it."""


def test_rate_is_the_share_of_all_pairs_above_an_iou_of_a_hundredth():
    assert collision_rate(ROOM) == 2 / 15  # building and room, wall and table


def test_family_is_counted_only_where_it_is_asked_for():
    for among, n_pairs, n_colliding in (
        ("all", 15, 2),
        ("not parent and child", 11, 1),
        ("strangers", 8, 1),
    ):
        each = found(ROOM, among)
        assert each.n_collisions == n_colliding
        assert each.rate == n_colliding / n_pairs
    assert found(ROOM, "strangers").object_share == 2 / 6
    assert found(ROOM, "all").object_share == 4 / 6


def test_what_iou_is_too_coarse_for_is_found_by_depth():
    strangers = found(ROOM, "strangers")
    assert strangers.deep_object_share == 3 / 6
    assert strangers.mean_depth_m == pytest.approx(0.1)


def test_rows_and_columns_of_the_pairs_do_not_depend_on_the_place():
    far = moved(ROOM, np.tile([13.0, -7.0, 0.0], (6, 1)))
    assert found(far, "all").rate == found(ROOM, "all").rate


def test_a_corpus_scene_has_no_collision_among_strangers_and_a_jittered_one_has():
    scene, rng = cached_scene(42), np.random.default_rng(0)
    real = found(scene, "strangers")
    assert (real.n_collisions, real.n_deep_objects) == (0, 0)
    assert found(scene, "all").n_collisions > 0
    shares = [
        found(jittered(scene, rng, spread_m=m), "strangers").deep_object_share for m in (0.1, 0.5)
    ]
    assert 0.1 < shares[0] < shares[1]


def test_rates_are_averaged_over_scenes_and_objects_counted_over_all():
    alone = scene_of(("tree", box((0, 0, 3), (2, 2, 6))), ("tree", box((9, 0, 3), (2, 2, 6))))
    both = total([found(ROOM, "all"), found(alone, "all")])
    assert both.rate == pytest.approx((2 / 15 + 0) / 2)
    assert both.object_share == 4 / 8
    assert both.scene_share == 1 / 2


@pytest.mark.parametrize("rows", [(), (("tree", box((0, 0, 3), (2, 2, 6))),)])
def test_a_scene_without_pairs_has_no_collisions(rows):
    none = found(scene_of(*rows), "all")
    assert (none.rate, none.object_share, none.mean_depth_m) == (0.0, 0.0, 0.0)
