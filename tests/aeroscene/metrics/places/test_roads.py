import math

import pytest

from aeroscene.metrics.places.roads import (
    idle_bridges,
    lights_off_roads,
    stranded_boats,
    wrong_way_vehicles,
)
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of, turned


def road(yaw_deg=0.0, x=0.0, y=0.0, length=60):
    return ("road", box((x, y, 0.02), (length, 7, 0.04), yaw_deg))


def vehicle(x, y, yaw_deg, category="car"):
    return (category, box((x, y, 0.8), (4.2, 1.8, 1.5), yaw_deg))


def wrong(*rows):
    return wrong_way_vehicles(TopView(scene_of(*rows))).tolist()


@pytest.mark.parametrize("category", ["car", "van", "truck", "bus"])
def test_vehicles_drive_on_the_right(category):
    assert wrong(road(), vehicle(5, -1.7, 0, category)) == [False]
    assert wrong(road(), vehicle(5, 1.7, 180, category)) == [False]
    assert wrong(road(), vehicle(5, 1.7, 0, category)) == [True]
    assert wrong(road(), vehicle(5, -1.7, 180, category)) == [True]


@pytest.mark.parametrize("yaw_deg", [0, 30, 135, 180, 250])
@pytest.mark.parametrize("reverse_deg", [0, 180])
def test_whichever_way_the_road_lies_and_is_headed(yaw_deg, reverse_deg):
    c, s = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    for side, is_wrong in ((-1.7, False), (1.7, True)):
        spot = (10 * c - side * s, 10 * s + side * c)
        car = vehicle(*spot, yaw_deg + 10)
        assert wrong(road(yaw_deg + reverse_deg), car) == [is_wrong]


def test_a_vehicle_across_the_road_is_wrong_and_one_off_it_is_not_judged():
    assert wrong(road(), vehicle(5, -1.7, 90)) == [True]
    assert wrong(road(), vehicle(5, -1.7, 40)) == [False]
    assert wrong(road(), vehicle(5, 9, 0)) == []


def test_on_a_crossing_the_road_that_it_heads_along_counts():
    crossing = (road(), road(90))
    # Northwards on the east side of the road to the north, left of the middle of the other.
    assert wrong(*crossing, vehicle(1.7, 1.7, 90)) == [False]
    assert wrong(*crossing, vehicle(-1.7, 1.7, 90)) == [True]
    assert wrong(*crossing, vehicle(1.7, -1.7, 0), vehicle(1.7, 1.7, 0)) == [False, True]


@pytest.mark.parametrize(("gap_m", "is_off"), [(0.5, False), (2.9, False), (3.1, True)])
def test_traffic_lights_stand_at_a_road(gap_m, is_off):
    light = ("traffic_light", box((0, 3.5 + gap_m + 0.2, 1.5), (0.4, 0.4, 3)))
    assert lights_off_roads(TopView(scene_of(road(), light))).tolist() == [is_off]
    assert lights_off_roads(TopView(scene_of(light))).tolist() == [True]


def boats(x, *water):
    boat = ("boat", box((x, 0, 0.8), (6, 2, 1.5), 10.0))
    return stranded_boats(TopView(scene_of(boat, *water))).tolist()


def test_boats_lie_on_water():
    basin = ("water", box((0, 0, 0.1), (20, 20, 0.2)))
    paving = ("plaza", box((20, 0, 0.1), (20, 20, 0.2)))
    assert boats(0, basin, paving) == [False]
    assert boats(20, basin, paving) == [True]
    assert boats(7.5, basin, paving) == [True]
    assert boats(0, paving) == [True]


def test_a_boat_may_lie_on_two_waters():
    halves = [("water", box((x, 0, 0.1), (20, 20, 0.2))) for x in (-10, 10)]
    assert boats(0, *halves) == [False]
    assert boats(0, halves[0]) == [True]


@pytest.mark.parametrize("crossed", ["road", "water"])
def test_bridges_cross_something(crossed):
    bridge = ("bridge", box((0, 0, 2.5), (16, 2.4, 5), 90.0))
    for y, is_idle in ((0, False), (8, False), (14, True)):
        way = (crossed, box((0, y, 0.02), (60, 7, 0.04)))
        assert idle_bridges(TopView(scene_of(bridge, way))).tolist() == [is_idle]
    lawn = ("lawn", box((0, 0, 0.02), (60, 60, 0.04)))
    assert idle_bridges(TopView(scene_of(bridge, lawn))).tolist() == [True]


def test_a_turned_scene_is_judged_alike():
    rows = (road(), vehicle(5, -1.7, 0), vehicle(15, 1.7, 0))
    for quarters in range(4):
        view = TopView(turned(scene_of(*rows), quarters))
        assert wrong_way_vehicles(view).tolist() == [False, True]
