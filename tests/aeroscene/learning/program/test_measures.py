"""Extents from what they count from, whatever the values."""

import math

import pytest

from aeroscene.learning.program.measures import Surroundings, size_and_base
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw

LOT = OrientedBox((0.0, 0.0, 0.02), quat_from_yaw(0.0), (30.0, 20.0, 0.04))
BY_ITSELF, A_SHARE, LESS = range(3)


def size_m(values, references):
    around = Surroundings(LOT, LOT)
    return size_and_base(around, [0.0, *values], [0, *references], 0.0, is_on_top=True)[0]


def test_what_is_half_as_thick_as_its_bearer_is_so_however_thin_that_is():
    """Bays painted on a parking lot are 2 cm thick, not the 5 cm that were least once."""
    found_m = size_m([0.0, 0.0, math.log(0.5)], [A_SHARE, A_SHARE, A_SHARE])
    assert found_m == (30.0, 20.0, 0.02)


@pytest.mark.parametrize(("value", "least_m"), [(-40.0, 0.05), (-29.0, 1.0)])
def test_what_is_some_metres_less_than_another_has_an_extent_left(value, least_m):
    assert size_m([value, 0.0, 0.0], [LESS, BY_ITSELF, BY_ITSELF])[0] == least_m
