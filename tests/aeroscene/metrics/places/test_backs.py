import math

import pytest

from aeroscene.metrics.places.backs import backs_off_walls
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

HOUSE = ("house", box((0, 0, 1.5), (10, 8, 3)))
"""Its outer walls are 0.25 m thick: inside it reaches from -4.75 to 4.75 and from -3.75 to 3.75."""


def wall(z=1.5):
    """A wall across the house."""
    return ("wall", box((0, 0, z), (0.12, 7.5, 3)), 0)


def off(*rows):
    return backs_off_walls(TopView(scene_of(*rows))).tolist()


def shelf(x, yaw_deg=0.0, z=1.0, category="shelf"):
    return (category, box((x, 1.0, z), (0.4, 1.2, 2.0), yaw_deg), 0)


@pytest.mark.parametrize("category", ["shelf", "cabinet", "wardrobe", "counter", "fridge", "stove"])
def test_furniture_has_its_back_to_the_outer_wall(category):
    # The inner face of the outer wall is at -4.75.
    assert off(HOUSE, shelf(-4.5, category=category)) == [False]
    assert off(HOUSE, shelf(-4.2, category=category)) == [True]
    assert off(HOUSE, shelf(-4.5, yaw_deg=180.0, category=category)) == [True]


def test_furniture_has_its_back_to_a_wall_of_its_own_storey():
    assert off(HOUSE, wall(), shelf(0.3)) == [False]
    assert off(HOUSE, wall(), shelf(0.6)) == [True]
    assert off(HOUSE, wall(), shelf(-0.3, yaw_deg=180.0)) == [False]
    assert off(HOUSE, wall(z=6.0), shelf(0.3)) == [True]


def test_chairs_need_no_wall():
    assert off(HOUSE, ("chair", box((0, 0, 0.5), (0.5, 0.5, 0.9)), 0)) == []


@pytest.mark.parametrize("yaw_deg", [20.0, 110.0, 200.0])
def test_the_whole_scene_may_be_turned(yaw_deg):
    c, s = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    house = ("house", box((0, 0, 1.5), (10, 8, 3), yaw_deg))
    for x, is_off in ((-4.5, False), (-4.0, True)):
        spot = (x * c - s, x * s + c, 1.0)
        assert off(house, ("shelf", box(spot, (0.4, 1.2, 2.0), yaw_deg), 0)) == [is_off]
