"""Buildings look at their street with the side that has the door."""

import math

import pytest

from aeroscene.metrics.places.fronts import averted_fronts
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

ROAD = ("road", box((0, 0, 0.02), (60, 8, 0.04)))
ALLEY = ("sidewalk", box((0, 34, 0.02), (60, 2, 0.04)))


def averted(yaw_deg, *ground, turn_deg=0.0):
    """A house 6 m north of the road, whose front looks along its yaw; all of it turned."""

    def turned(name, found):
        c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
        (x, y, z), size, own_deg = found
        return name, box((c * x - s * y, s * x + c * y, z), size, own_deg + turn_deg)

    house = ("house", ((0, 15, 3), (10, 10, 6), yaw_deg))
    flat = [(name, (each.p, each.s, 0.0)) for name, each in ground]
    return averted_fronts(TopView(scene_of(*(turned(*each) for each in (house, *flat))))).tolist()


@pytest.mark.parametrize("turn_deg", [0.0, 30.0])
@pytest.mark.parametrize(("yaw_deg", "is_averted"), [(-90, False), (90, True), (0, True)])
def test_fronts_look_at_the_road(yaw_deg, is_averted, turn_deg):
    assert averted(yaw_deg, ROAD, turn_deg=turn_deg) == [is_averted]


def test_of_two_streets_the_nearer_counts():
    assert averted(90, ROAD, ALLEY) == [True]
    assert averted(-90, ROAD, ALLEY) == [False]
    lane = ("sidewalk", box((0, 27, 0.02), (60, 2, 0.04)))
    assert averted(90, ROAD, lane) == [False]


def test_without_a_street_nothing_is_judged():
    assert averted(0) == []
    assert averted(0, ("road", box((0, 80, 0.02), (60, 8, 0.04)))) == []


def test_rooms_of_houses_have_no_front():
    inner = ("building", box((0, 15, 3), (4, 4, 3)), 0)
    outer = ("building", box((0, 15, 3), (10, 10, 6), -90.0))
    found = averted_fronts(TopView(scene_of(outer, inner, ROAD)))
    assert found.tolist() == [False]
