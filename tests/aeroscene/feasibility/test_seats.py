"""Chairs look at the table that they are drawn up to."""

import math

import numpy as np
import pytest

from aeroscene.feasibility.boxes import boxes_of
from aeroscene.feasibility.seats import tables_of, turns_to_tables
from tests.aeroscene.feasibility.scenes import GARDEN, LAWN, TABLE, thing

CHAIR = 20


def with_chair(x_m: float, y_m: float, yaw_rad: float, parent: int | None = LAWN):
    chair = thing(CHAIR, "chair", (x_m, y_m, 0.51), (0.5, 0.5, 0.9), parent, yaw_rad)
    objects = (*GARDEN, chair)
    return objects, boxes_of(objects), np.ones(len(objects), dtype=bool)


@pytest.mark.parametrize(
    ("x_m", "yaw_rad", "turn_rad"),
    [
        (-5.1, math.pi, None),
        (-6.9, 0.0, None),
        (-6.9, 0.3, None),
        (-6.9, math.pi, math.pi),
        (-5.1, math.pi / 2, math.pi / 2),
        (-3.0, 0.0, None),
    ],
)
def test_chairs_turn_to_the_table_that_they_are_at(x_m, yaw_rad, turn_rad):
    known = with_chair(x_m, 0.0, yaw_rad)
    found = turns_to_tables(*known)
    if turn_rad is None:
        assert found == []
    else:
        assert [row for row, _ in found] == [len(GARDEN)]
        off_rad = math.remainder(found[0][1] - turn_rad, math.tau)
        assert off_rad == pytest.approx(0.0, abs=1e-9)


def test_chairs_belong_to_a_table_of_their_own_parent():
    chairs, tables = tables_of(*with_chair(-5.1, 0.0, 0.0))
    assert (chairs.tolist(), tables.tolist()) == ([len(GARDEN)], [TABLE])
    assert not len(tables_of(*with_chair(-5.1, 0.0, 0.0, parent=None))[0])
