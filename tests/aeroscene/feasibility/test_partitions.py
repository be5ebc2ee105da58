from __future__ import annotations

import numpy as np
import pytest

from aeroscene.feasibility.layout import Layout, layout_of
from aeroscene.feasibility.partitions import merge_walls
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import garden, thing

HOUSE, FIRST, SECOND = 19, 20, 21


def walls(*second: float, yaw_rad: float = 0.0) -> tuple[Layout, int, int]:
    """A house with a wall of 6 m along y through its middle, and another one: x, y, length, z."""
    x, y, length, z = second
    layout = layout_of(
        garden(
            thing(HOUSE, "house", (60.0, 0.0, 2.0), (10.0, 20.0, 4.0)),
            thing(FIRST, "wall", (60.0, 0.0, 1.7), (0.12, 6.0, 3.0), HOUSE),
            thing(SECOND, "wall", (60.0 + x, y, z), (0.12, length, 3.0), HOUSE, yaw_rad),
        )
    )
    rows = {obj.id: row for row, obj in enumerate(layout.objects)}
    return layout, rows[FIRST], rows[SECOND]


@pytest.mark.parametrize("yaw_rad", [0.0, np.pi])
def test_a_wall_that_runs_beside_another_continues_it_in_line(yaw_rad):
    layout, first, second = walls(0.12, 4.0, 5.0, 1.7, yaw_rad=yaw_rad)
    merge_walls(layout)
    assert layout.is_present[[first, second]].all()
    boxes = layout.boxes
    assert boxes.centre_m[second, 0] == pytest.approx(60.0)
    assert boxes.centre_m[second, 1] - boxes.half_m[second, 1] == pytest.approx(3.0, abs=0.001)
    assert boxes.centre_m[second, 1] + boxes.half_m[second, 1] == pytest.approx(6.5)
    assert boxes.half_m[first, 1] == pytest.approx(3.0)


def test_a_wall_away_from_the_line_of_another_keeps_its_own_line():
    layout, _, second = walls(0.9, 4.0, 5.0, 1.7)
    merge_walls(layout)
    assert layout.boxes.centre_m[second, 0] == pytest.approx(60.9)
    assert layout.boxes.half_m[second, 1] == pytest.approx(1.75, abs=0.001)


@pytest.mark.parametrize("offset_m", [0.12, 0.9])
def test_of_two_walls_side_by_side_one_is_left(offset_m):
    layout, first, second = walls(offset_m, 0.5, 5.5, 1.7)
    merge_walls(layout)
    assert layout.is_present[first]
    assert not layout.is_present[second]


@pytest.mark.parametrize(
    ("second", "yaw_rad"),
    [
        ((1.5, 0.0, 5.0, 1.7), 0.0),
        ((0.12, 5.3, 5.0, 1.7), 0.0),
        ((0.12, 0.0, 5.0, 4.8), 0.0),
        ((0.12, 0.0, 5.0, 1.7), np.pi / 2),
    ],
    ids=["a corridor away", "end to end", "a storey above", "across"],
)
def test_other_walls_stay(second, yaw_rad):
    layout, _, _ = walls(*second, yaw_rad=yaw_rad)
    before = layout.boxes.copy()
    merge_walls(layout)
    assert layout.is_present.all()
    np.testing.assert_array_equal(layout.boxes.centre_m, before.centre_m)
    np.testing.assert_array_equal(layout.boxes.half_m, before.half_m)


@pytest.mark.parametrize("index", [42, 311, 320])
def test_walls_of_the_corpus_stay(index):
    layout = layout_of(cached_scene(index))
    before = layout.boxes.copy()
    merge_walls(layout)
    assert layout.is_present.all()
    np.testing.assert_array_equal(layout.boxes.half_m, before.half_m)
