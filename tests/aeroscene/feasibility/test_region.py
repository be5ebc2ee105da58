"""Regions of scenes: what lies in them, and which are none."""

from __future__ import annotations

import math

import pytest

from aeroscene.feasibility.region import Region
from aeroscene.scene import SceneError
from tests.aeroscene.feasibility.scenes import garden

CORNER = Region(low_enu_m=(-20.0, -20.0, -math.inf), high_enu_m=(0.0, 5.0, math.inf))


@pytest.mark.parametrize(
    ("point", "is_in"),
    [
        ((-6.0, 0.0, 0.4), True),
        ((0.0, 5.0, 99.0), True),
        ((0.1, 0.0, 0.4), False),
        ((-6.0, 5.1, 0.4), False),
        ((-20.1, 0.0, 0.4), False),
    ],
)
def test_region_holds_what_is_between_its_corners(point, is_in):
    assert CORNER.holds(point) == is_in


def test_region_with_heights_holds_what_is_between_them():
    region = Region(low_enu_m=(-20.0, -20.0, 0.0), high_enu_m=(20.0, 20.0, 3.0))
    assert region.holds((0.0, 0.0, 2.9))
    assert not region.holds((0.0, 0.0, 3.1))
    assert not region.holds((0.0, 0.0, -0.1))


def test_a_box_reaches_in_with_any_part_but_not_by_a_touch():
    lawn, home, *_ = garden().objects
    assert CORNER.is_over(lawn.bbox)
    assert not CORNER.is_over(home.bbox)
    beside = Region(low_enu_m=(15.0, -20.0, -math.inf), high_enu_m=(20.0, 5.0, math.inf))
    assert not beside.is_over(lawn.bbox)


def test_share_is_that_of_the_ground_plan():
    assert CORNER.share_of(garden()) == pytest.approx(20 * 25 / (40 * 50))
    beside = Region(low_enu_m=(30.0, 0.0, -math.inf), high_enu_m=(40.0, 5.0, math.inf))
    assert beside.share_of(garden()) == 0.0


def test_text_is_what_a_user_writes():
    assert str(CORNER) == "-20,-20,0,5"
    region = Region(low_enu_m=(-1.5, 0.0, 0.0), high_enu_m=(2.0, 3.25, 4.0))
    assert str(region) == "-1.5,0,2,3.25,0,4"


@pytest.mark.parametrize(
    ("low", "high", "message"),
    [
        ((5.0, 0.0, 0.0), (-5.0, 1.0, 1.0), "from 5 to -5 along x; valid: finite metres, the low"),
        ((0.0, 1.0, 0.0), (5.0, 1.0, 1.0), "from 1 to 1 along y"),
        ((0.0, 0.0, 4.0), (5.0, 1.0, 1.0), "from 4 to 1 along z"),
        ((-math.inf, 0.0, 0.0), (5.0, 1.0, 1.0), "from -inf to 5 along x"),
        ((0.0, 0.0, 0.0), (math.nan, 1.0, 1.0), "from 0 to nan along x"),
    ],
)
def test_what_is_no_region_is_refused(low, high, message):
    with pytest.raises(SceneError, match=message):
        Region(low_enu_m=low, high_enu_m=high)
