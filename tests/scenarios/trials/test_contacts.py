"""Contacts: what is touched, by the true shapes, and for how long."""

import numpy as np
import pytest

from flightsim.environment.movers import MovingObstacle, ObstacleStates
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.trials.contacts import ContactFinder, MoverPoses
from scenarios.trials.flight_log import room_to_movers_m
from tests.scenarios.landing_scenes import TOP_M, yard
from tests.scenarios.trials.histories import flight

IRIS = AIRFRAMES["iris"]
LEG_M = IRIS.leg_length_m
ON_GROUND, ON_CONTAINER = (0.0, 5.0, LEG_M), (9.0, 0.0, TOP_M + LEG_M)
PERSON = MovingObstacle(kind="person", path_enu_m=((-5.0, 0.0, 0.0), (-5.0, 6.0, 0.0)), speed_mps=1)


@pytest.fixture(scope="module")
def world():
    return build_world(yard(), IRIS, traffic=(PERSON,))


def found(world, *segments, mover_at=(-5.0, 3.0, 0.0), since=0):
    history = flight(*segments)
    n = len(history)
    movers = MoverPoses(
        position_enu_m=np.broadcast_to(mover_at, (n, 1, 3)),
        quat_wxyz=np.broadcast_to((1.0, 0.0, 0.0, 0.0), (n, 1, 4)),
    )
    return ContactFinder(world).find(history, movers, np.arange(n) >= since)


def test_each_thing_is_named_with_its_times(world):
    contacts = found(world, (1, ON_GROUND, 1), (1, (0, 0, 5), 0), (2, ON_CONTAINER, 1))
    assert [(c.what, c.object_id) for c in contacts] == [
        ("the ground", None),
        ("object 1 (container)", 1),
    ]
    assert [c.category for c in contacts] == [None, "container"]
    assert contacts[1].time_s == pytest.approx(2.004)
    assert contacts[1].until_s == pytest.approx(4.0)
    assert contacts[1].position_enu_m[2] == pytest.approx(TOP_M, abs=0.01)


def test_a_graze_is_found_though_the_hull_is_free_again_at_the_end_of_the_tick(world):
    (graze,) = found(world, (0.004, (0.0, 5.0, LEG_M + 0.008), 1))
    assert graze.what == "the ground"
    assert found(world, (0.004, (0.0, 5.0, LEG_M + 0.012), 1)) == ()


def test_only_rows_that_count_and_touch_are_looked_at(world):
    assert found(world, (1, ON_GROUND, 0)) == ()
    late = found(world, (1, ON_GROUND, 1), since=200)
    assert late[0].time_s == pytest.approx(0.804)


def test_touches_that_are_apart_are_two(world):
    bounce = (0.3, (9.0, 0.0, TOP_M + 1.0), 0)
    short = (0.1, *bounce[1:])
    stand = (0.5, ON_CONTAINER, 1)
    assert len(found(world, stand, short, stand)) == 1
    assert len(found(world, stand, bounce, stand)) == 2


def test_a_mover_is_touched_where_it_was(world):
    at = (-5.0, 0.0, 1.0)
    assert found(world, (0.1, at, 1), mover_at=(-5.0, 0.0, 0.0))[0].what == "person_0"
    assert found(world, (0.1, at, 1)) == ()


@pytest.mark.parametrize(
    ("vehicle_enu_m", "gap_m"),
    [
        # A person is 0.32 m deep, 0.62 m wide and 1.76 m high.
        ((2.0, 0.0, 1.0), 2.0 - 0.16 - IRIS.collision_radius_m),
        ((0.0, -2.0, 1.0), 2.0 - 0.31 - IRIS.collision_radius_m),
        ((0.0, 0.0, 3.0), 3.0 - 1.76 - LEG_M),
        ((0.1, 0.1, 1.0), 0.0),
    ],
)
def test_room_to_movers_is_that_between_the_hulls(vehicle_enu_m, gap_m):
    person = ObstacleStates(
        kinds=("person",),
        position_enu_m=np.array([[0.0, 0.0, 0.88]]),
        velocity_enu_mps=np.zeros((1, 3)),
        yaw_rad=np.zeros(1),
        size_m=np.array([[0.32, 0.62, 1.76]]),
    )
    assert room_to_movers_m(np.array(vehicle_enu_m), IRIS, person) == pytest.approx(gap_m)
