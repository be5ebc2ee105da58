import numpy as np
import pytest

from aeroscene.metrics.arrays import scene_arrays
from aeroscene.metrics.damage import jittered
from aeroscene.metrics.features import layout_features
from tests.aeroscene.conftest import SAMPLE, cached_scene
from tests.aeroscene.metrics.scenes import box, scene_of, turned


def features(*scenes):
    return layout_features([scene_arrays(scene) for scene in scenes])


def test_each_block_has_norm_one():
    square = (features(*(cached_scene(index) for index in SAMPLE)) ** 2).sum(axis=1)
    assert square == pytest.approx(7.0)


def test_a_disturbed_scene_is_nearer_than_another_one_and_farther_the_more():
    scene, rng = cached_scene(42), np.random.default_rng(0)
    others = [jittered(scene, rng, spread_m=spread) for spread in (0.02, 0.1, 0.5)]
    points = features(scene, *others, cached_scene(311))
    apart = ((points[1:] - points[0]) ** 2).sum(axis=1)
    assert (np.diff(apart) > 0).all()


def test_a_scene_may_be_turned_by_quarters():
    scene = scene_of(
        ("lawn", box((3, -2, 0.05), (20, 10, 0.1))),
        ("tree", box((5, -1, 3), (2, 2, 6)), 0),
        ("bench", box((6, -4, 0.5), (0.5, 1.5, 0.9), 30.0), 0),
    )
    assert features(turned(scene, 1)) == pytest.approx(features(scene))


@pytest.mark.parametrize("count", [0, 1, 2])
def test_the_smallest_scenes_have_features_too(count):
    rows = [("tree", box((9.0 * i, 0, 3), (2, 2, 6))) for i in range(count)]
    (row,) = features(scene_of(*rows))
    assert np.isfinite(row).all()
