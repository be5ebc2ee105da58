"""Where several vehicles stand at first."""

import itertools
import math

import pytest

from aeroscene.sources import load_scene
from flightsim.vehicles import airframe_by_name
from flightsim.world import WorldError, build_world
from flightsim.world.starts import APART_M, place_vehicles
from tests.flightsim.handmade import empty_scene, solid

IRIS = airframe_by_name("iris")


def places(n, *solids):
    return [v.stand_enu_m for v in place_vehicles(empty_scene(), [IRIS] * n, solids)]


def test_the_first_stands_on_the_start_and_the_others_apart():
    found = places(9)
    assert found[0] == (0.0, 0.0, 0.0)
    assert min(math.dist(a, b) for a, b in itertools.combinations(found, 2)) >= APART_M
    assert max(math.hypot(x, y) for x, y, _ in found) < 6.0


def test_nobody_stands_in_something_or_behind_it():
    wall = solid("box", (2.0, 0.0, 1.5), (0.2, 60.0, 3.0))
    crate = solid("box", (-3.0, 0.0, 0.2), (1.0, 1.0, 0.4))
    for x, y, z in places(6, wall, crate)[1:]:
        assert x < 1.5
        assert math.hypot(x + 3.0, y) > 1.0
        assert z == pytest.approx(0.0, abs=1e-9)


def test_a_low_ceiling_is_no_place_to_start():
    roof = solid("box", (5.0, 0.0, 1.5), (8.0, 60.0, 0.1))
    assert all(x < 1.0 for x, _, _ in places(5, roof))


def test_more_vehicles_than_the_start_has_room_for_are_refused_in_a_line():
    with pytest.raises(WorldError, match=r"^vehicles 90: .* has room for \d+ .*; valid: 1 to \d+$"):
        build_world(load_scene("42"), *[IRIS] * 90)


def test_every_vehicle_rests_where_it_was_put():
    for world in build_world(load_scene("42"), IRIS, airframe_by_name("crazyflie")).views:
        at = world.qpos_address
        x, y, z = world.scene.start_position_enu_m
        stands = (x, y, z + world.airframe.leg_length_m)
        assert math.dist(world.rest_qpos[at : at + 3], stands) < 0.1
