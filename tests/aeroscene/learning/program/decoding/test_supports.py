"""Boats float, bridges cross something, traffic has lanes, plates have chairs, rooms their own."""

import math

import pytest

from aeroscene.learning.program.decoding.draft.supports import drawn_in, laid_for, mended
from aeroscene.relations.plane import Place, Rectangle
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw
from tests.aeroscene.feasibility.scenes import thing

WATER = thing(0, "water", (0.0, 0.0, 0.02), (20.0, 10.0, 0.04))
ROAD = thing(1, "road", (0.0, 20.0, 0.02), (40.0, 8.0, 0.04))


def box(x_m, y_m, size_m, yaw_rad=0.0):
    return OrientedBox((x_m, y_m, 0.5), quat_from_yaw(yaw_rad), size_m)


def test_boats_go_to_water_or_away():
    boat = (6.0, 2.0, 1.0)
    afloat = box(3.0, 2.0, boat)
    assert mended("boat", [afloat], [WATER, ROAD]) == [afloat]
    (found,) = mended("boat", [box(9.0, 8.0, boat)], [WATER, ROAD])
    assert found.p[:2] == pytest.approx((7.0, 4.0))
    assert mended("boat", [box(0.0, 20.0, boat)], [ROAD]) == []
    (turned,) = mended("boat", [box(0.0, 12.0, (12.0, 2.0, 1.0), math.pi / 2)], [WATER])
    assert math.remainder(turned.yaw_rad, math.pi) == pytest.approx(0.0, abs=1e-9)


def test_bridges_cross_the_nearest_water_or_road():
    bridge = (4.0, 14.0, 1.0)
    over = box(5.0, 0.0, bridge)
    assert mended("bridge", [over], [WATER]) == [over]
    (found,) = mended("bridge", [box(0.0, 45.0, bridge)], [WATER, ROAD])
    assert found.p[:2] == (0.0, 20.0)
    assert mended("bridge", [over], []) == []


@pytest.mark.parametrize(
    ("y_m", "yaw_rad", "found_m"),
    [
        (20.1, 0.0, 20.0 - 8.0 * 0.145),
        (20.1, math.pi, 20.0 + 8.0 * 0.145),
        (19.9, math.pi / 2 + 0.1, 20.0 + 8.0 * 0.145),
        (18.0, 0.0, 18.0),
        (26.0, 0.0, 26.0),
    ],
)
def test_vehicles_leave_the_middle_of_the_road_to_the_right(y_m, yaw_rad, found_m):
    (found,) = mended("car", [box(3.0, y_m, (4.2, 1.8, 1.5), yaw_rad)], [WATER, ROAD])
    assert found.p[:2] == pytest.approx((3.0, found_m))


def test_plates_need_a_chair_before_them():
    plates = [box(x, 0.0, (0.3, 0.3, 0.02)) for x in (0.0, 2.0)]
    chair = thing(5, "chair", (-0.6, 0.0, 0.5), (0.5, 0.5, 0.9))
    assert laid_for(plates, [chair, WATER]) == plates[:1]
    assert laid_for(plates, [WATER]) == []


def test_what_is_in_a_room_has_its_middle_in_one_of_its_tiles():
    tiles = [
        Rectangle(Place(0.0, 0.0, 0.0), (2.0, 1.5)),
        Rectangle(Place(4.0, 0.0, math.pi / 2), (1.0, 2.0)),
    ]
    bed, reaches_over = box(0.5, 0.0, (2.0, 1.6, 0.5)), box(1.8, 0.0, (1.0, 0.4, 0.5))
    next_door, long = box(3.0, 0.5, (0.4, 0.4, 0.5)), box(0.3, -2.0, (9.0, 0.4, 0.5))
    assert drawn_in([bed, reaches_over, next_door], tiles) == [bed, reaches_over, next_door]
    (beside,) = drawn_in([box(0.3, 1.7, (0.6, 0.4, 0.5), 0.1)], tiles)
    assert beside.p[0] == pytest.approx(0.3)
    assert beside.p[1] == pytest.approx(1.5 - 0.2 * math.cos(0.1) - 0.3 * math.sin(0.1))
    assert beside.q == quat_from_yaw(0.1)
    (along,) = drawn_in([long], tiles)
    assert along.p[:2] == pytest.approx((0.0, -1.3))


def test_a_group_goes_in_as_a_whole_and_without_what_is_outside_even_then():
    room = [Rectangle(Place(0.0, 0.0, 0.0), (3.0, 2.0))]
    row = [box(x_m, 2.3, (1.0, 0.4, 0.5)) for x_m in (1.0, 2.0, 3.0)]
    assert [each.p[:2] for each in drawn_in(row, room)] == [
        pytest.approx((x_m, 1.8)) for x_m in (0.5, 1.5, 2.5)
    ]
    too_long = [box(float(x_m), 0.0, (1.0, 0.4, 0.5)) for x_m in range(-5, 6)]
    assert drawn_in(too_long, room) == too_long[2:-2]
