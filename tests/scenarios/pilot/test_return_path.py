"""The way home that an autopilot would fly without a map: free, or under something."""

import dataclasses

from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.mission import plan_mission
from scenarios.pilot.return_path import is_return_path_free
from tests.scenarios.landing_scenes import ON_CONTAINER, thing, yard

ABOVE_AREA, ABOVE_START = (9.0, 0.0, 5.0), (0.0, 0.0, 2.0)
SLAB = (4.0, 4.0, 0.3)


def world(*objects):
    scene = yard()
    scene = dataclasses.replace(scene, objects=(*scene.objects, *objects))
    return plan_mission(scene, AIRFRAMES["iris"], area=ON_CONTAINER).surroundings


def test_in_the_open_the_way_home_is_free():
    assert is_return_path_free(world(), ABOVE_AREA, ABOVE_START)


def test_under_a_roof_it_is_not_nor_where_something_is_above_home_or_between():
    for center in ((9.0, 0.0, 7.0), (0.0, 0.0, 7.0), (4.5, 0.0, 9.0)):
        roofed = world(thing(40, "container", center, SLAB))
        assert not is_return_path_free(roofed, ABOVE_AREA, ABOVE_START), center


def test_what_stands_lower_than_the_vehicle_on_the_way_is_no_matter():
    low = world(thing(40, "container", (4.5, 0.0, 2.0), (1.0, 1.0, 2.0)))
    assert is_return_path_free(low, ABOVE_AREA, ABOVE_START)
