"""Lights without a road and boats ashore are given up; the others stay."""

import math

import pytest

from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.strays import drop_strays
from tests.aeroscene.feasibility.scenes import garden, thing

ROAD, LIGHT, WATER, BOAT = 20, 21, 22, 23


def left_after(*things):
    layout = layout_of(garden(*things))
    drop_strays(layout)
    return {obj.id for obj in layout.remaining()} & {each.id for each in things}


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8])
@pytest.mark.parametrize(("away_m", "stays"), [(4.5, True), (6.9, True), (7.3, False)])
def test_lights_stand_at_a_road(away_m, stays, yaw_rad):
    road = thing(ROAD, "road", (0.0, 0.0, 0.02), (40.0, 8.0, 0.04), yaw_rad=yaw_rad)
    at = (-math.sin(yaw_rad) * away_m, math.cos(yaw_rad) * away_m, 1.6)
    light = thing(LIGHT, "traffic_light", at, (0.1, 0.1, 3.2), yaw_rad=yaw_rad)
    assert left_after(road, light) == ({ROAD, LIGHT} if stays else {ROAD})


def test_without_a_road_no_light_stays():
    assert left_after(thing(LIGHT, "traffic_light", (0.0, 0.0, 1.6), (0.3, 0.3, 3.2))) == set()


@pytest.mark.parametrize(("x_m", "stays"), [(0.0, True), (3.1, True), (3.5, False), (20.0, False)])
def test_boats_lie_on_water(x_m, stays):
    water = thing(WATER, "water", (0.0, 0.0, 0.02), (10.0, 10.0, 0.04))
    boat = thing(BOAT, "boat", (x_m, 0.0, 0.5), (4.0, 2.0, 1.0), WATER)
    assert left_after(water, boat) == ({WATER, BOAT} if stays else {WATER})
