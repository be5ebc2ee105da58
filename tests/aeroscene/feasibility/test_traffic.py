"""Vehicles are headed the way that their side of the road goes."""

import math

import numpy as np
import pytest

from aeroscene.feasibility.boxes import boxes_of
from aeroscene.feasibility.traffic import turns_with_traffic
from tests.aeroscene.feasibility.scenes import thing

ROAD, CAR = 20, 21


def turns(y_m: float, yaw_rad: float, road_rad: float = 0.0):
    c, s = math.cos(road_rad), math.sin(road_rad)
    road = thing(ROAD, "road", (0.0, 0.0, 0.02), (40.0, 8.0, 0.04), yaw_rad=road_rad)
    at = (-s * y_m, c * y_m, 0.8)
    car = thing(CAR, "car", at, (4.2, 1.8, 1.5), yaw_rad=road_rad + yaw_rad)
    objects = (road, car)
    return turns_with_traffic(objects, boxes_of(objects), np.ones(2, dtype=bool))


@pytest.mark.parametrize("road_rad", [0.0, 0.7, 3.0])
@pytest.mark.parametrize(
    ("y_m", "yaw_rad", "turn_rad"),
    [
        (-2.0, 0.0, None),
        (2.0, math.pi, None),
        (2.0, 0.0, math.pi),
        (-2.0, math.pi, -math.pi),
        (2.0, 0.1, math.pi),
        (-2.0, math.pi / 2, -math.pi / 2),
        (12.0, 0.0, None),
    ],
)
def test_traffic_keeps_to_the_right(y_m, yaw_rad, turn_rad, road_rad):
    found = turns(y_m, yaw_rad, road_rad)
    if turn_rad is None:
        assert found == []
    else:
        assert [row for row, _ in found] == [1]
        off_rad = math.remainder(found[0][1] - turn_rad, math.tau)
        assert off_rad == pytest.approx(0.0, abs=1e-9)


def test_what_has_gone_neither_turns_nor_is_a_road():
    objects = (
        thing(ROAD, "road", (0.0, 0.0, 0.02), (40.0, 8.0, 0.04)),
        thing(CAR, "car", (0.0, 2.0, 0.8), (4.2, 1.8, 1.5)),
    )
    boxes = boxes_of(objects)
    for is_present in ([True, False], [False, True]):
        assert turns_with_traffic(objects, boxes, np.array(is_present)) == []
