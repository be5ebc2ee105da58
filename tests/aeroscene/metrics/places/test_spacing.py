import math

import numpy as np
import pytest

from aeroscene.metrics.places.spacing import uneven_spacing
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

ROOM = ("room", box((0, 0, 1.5), (30, 30, 3)))


def desk(x, y, yaw_deg=0.0, category="desk", parent=0):
    return (category, box((x, y, 0.4), (0.8, 1.6, 0.75), yaw_deg), parent)


def unevenness(*rows):
    return uneven_spacing(TopView(scene_of(ROOM, *rows))).tolist()


@pytest.mark.parametrize("category", ["desk", "table"])
def test_equal_spacing_is_even_and_one_that_is_moved_is_not(category):
    even = [desk(0, y, category=category) for y in (0, 2, 4)]
    assert unevenness(*even) == pytest.approx([0.0])
    moved = [*even[:2], desk(0, 5, category=category)]
    assert unevenness(*moved) == pytest.approx([0.5 / 2.5])


@pytest.mark.parametrize("yaw_deg", [0.0, 33.0, 120.0])
def test_rows_run_across_and_behind_each_other(yaw_deg):
    c, s = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    places = [(2.0 * i, 2.5 * j) for i in range(3) for j in range(4)]
    grid = [desk(c * u - s * v, s * u + c * v, yaw_deg) for u, v in places]
    assert unevenness(*grid) == pytest.approx([0.0] * 7, abs=1e-9)


def test_two_are_no_row_nor_are_others_and_what_is_elsewhere():
    row = [desk(0, y) for y in (0, 2, 5)]
    assert len(unevenness(*row)) == 1
    assert unevenness(*row[:2]) == []
    assert unevenness(*row[:2], desk(0, 5, category="table")) == []
    assert unevenness(*row[:2], desk(0, 5, yaw_deg=180.0)) == []
    assert unevenness(*row[:2], desk(0.7, 5)) == []
    assert unevenness(*row[:2], ("room", box((0, 0, 5), (9, 9, 3))), desk(0, 5, parent=3)) == []
    assert unevenness(*row[:2], ("bench", box((0, 5, 0.4), (0.8, 1.6, 0.75)), 0)) == []


def test_the_order_of_the_objects_does_not_matter():
    places = [0.0, 1.5, 4.0, 5.0]
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(4)
        (value,) = unevenness(*(desk(0, places[i]) for i in order))
        assert value == pytest.approx(np.std([1.5, 2.5, 1.0]) / (5 / 3))
