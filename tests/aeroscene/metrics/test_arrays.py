import numpy as np
import pytest

from aeroscene.metrics.arrays import NO_PARENT, scene_arrays
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.metrics.scenes import box, scene_of


def test_rows_say_what_the_objects_say():
    scene = cached_scene(42)
    arrays = scene_arrays(scene)
    assert arrays.n_objects == len(scene.objects)
    for row, obj in enumerate(scene.objects):
        assert arrays.category[row] == obj.category_id - 1
        assert arrays.is_coarse[row] == obj.is_coarse
        assert arrays.yaw_rad[row] == pytest.approx(obj.bbox.yaw_rad)
        above = {10**6, *scene.ancestors(obj.id)}
        ids = [scene.objects[i].id for i in np.flatnonzero(arrays.is_ancestor[:, row])]
        assert set(ids) == above - {10**6}


def test_a_region_is_the_nearest_coarse_ancestor():
    scene = scene_of(
        ("room", box((0, 0, 2), (8, 8, 4))),
        ("table", box((0, 0, 0.4), (1, 1, 0.8)), 0),
        ("cup", box((0, 0, 0.85), (0.1, 0.1, 0.1)), 1),
        ("tree", box((20, 0, 2), (2, 2, 4))),
    )
    assert scene_arrays(scene).region.tolist() == [NO_PARENT, 0, 0, NO_PARENT]


def test_a_scene_of_nothing_has_arrays_of_nothing():
    arrays = scene_arrays(scene_of())
    assert arrays.centre_enu_m.shape == arrays.size_m.shape == (0, 3)
    assert arrays.is_ancestor.shape == (0, 0)
