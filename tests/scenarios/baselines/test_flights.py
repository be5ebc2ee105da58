"""The baselines fly: round what they can, and into what they are known to end in."""

import dataclasses
import math

import pytest

from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.baselines.named import pilot_of
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from scenarios.trials.limits import LIMITS
from scenarios.trials.verdict import Code, Fate
from tests.scenarios.landing_scenes import ON_LAWN, thing, yard

POLE, WALL = 30, 31


def beside(*objects, areas=(ON_LAWN,)):
    """The yard with more in it, and the lawn north-east as the only area."""
    scene = yard(areas=areas)
    return dataclasses.replace(scene, objects=(*scene.objects, *objects))


def fly(name, scene):
    pilot = pilot_of(name)
    cfg = pilot.brief(SitlCfg(area=ON_LAWN.id, bench=TestbenchCfg(speed="max")))
    with Sitl(cfg, scene=scene, pilot=pilot.make, has_network=False) as sitl:
        return sitl.run(), sitl


class Beside:
    """The straight-line pilot, which says that it chose a point south of the area's middle."""

    def __init__(self, aboard):
        self._pilot = pilot_of("straight").make(aboard)
        x, y, z = aboard.area.centroid
        self.touchdown_enu_m = (x, y - 0.3, z)

    def __getattr__(self, name):
        return getattr(self._pilot, name)


def test_the_touchdown_error_of_any_pilot_counts_from_its_chosen_point():
    cfg = SitlCfg(area=ON_LAWN.id, bench=TestbenchCfg(speed="max"))
    with Sitl(cfg, scene=beside(), pilot=Beside, has_network=False) as sitl:
        aside = sitl.run()
        place_m = sitl.bench.plant.truth.position_enu_m[:2]
    x, y, _ = ON_LAWN.centroid
    assert aside.touchdown_error_m == pytest.approx(math.dist(place_m, (x, y - 0.3)), abs=0.01)


# A little off the straight line from above the start to above the lawn.
TREE = thing(POLE, "container", (4.3, 4.3, 4.0), (1.0, 1.0, 8.0))


def test_the_field_leads_round_what_the_straight_line_hits():
    straight, _ = fly("straight", beside(TREE))
    assert straight.code == Code.CONTACT, straight.reason
    assert straight.fate == Fate.COLLIDED
    assert straight.contacts[0]["object_id"] == POLE
    assert straight.contacts[0]["speed_mps"] > 1.0
    first, _ = fly("potential", beside(TREE))
    again, _ = fly("potential", beside(TREE))
    assert first.code == Code.LANDED, first.reason
    assert first.least_clearance_m > 0.1
    assert again.state_hash == first.state_hash


def test_before_a_long_wall_the_field_has_a_minimum_and_the_pilot_says_so():
    wall = thing(WALL, "container", (4.5, 4.0, 5.0), (12.0, 0.5, 10.0), yaw_rad=2.41)
    result, _ = fly("potential", beside(wall))
    assert result.code == Code.GAVE_UP
    assert "rests in a local minimum" in result.reason
    assert result.contacts_before_touchdown == 0
    assert result.fate == Fate.LOST, "it hovers there until its battery is empty"
    assert result.sim_seconds > LIMITS.longest_fall_s


def test_without_room_above_the_area_the_field_has_no_goal():
    roof = thing(WALL, "container", (9.0, 8.0, 1.5), (4.0, 4.0, 1.0))
    with pytest.raises(TestbenchError, match="area 1 has no free place to hover above it"):
        fly("potential", beside(roof))


def test_our_pilot_flies_by_primitives_where_only_its_planner_differs():
    ours, by_optimiser = fly("demo", beside(TREE))
    theirs, by_primitives = fly("mueller", beside(TREE))
    for result in (ours, theirs):
        assert result.code == Code.LANDED, result.reason
        assert result.contacts_before_touchdown == 0
    optimised, strung = by_optimiser.pilot.mission, by_primitives.pilot.mission
    assert optimised.trajectory.corridor is not None
    assert strung.trajectory.corridor is None
    assert strung.surroundings.method == "primitives"
    assert strung.hover_enu_m == optimised.hover_enu_m
    assert theirs.state_hash != ours.state_hash
