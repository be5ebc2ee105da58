"""Where flights begin and end: only a surface to land on is touched down on."""

import dataclasses

import pytest

from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import GROUND_NAME
from scenarios.trials.bounds import Touched, bounds_of
from scenarios.trials.contacts import Contact
from scenarios.trials.figures import Goal
from scenarios.trials.score import score_flight
from scenarios.trials.verdict import Code, Ending, Fate, Verdict, judge
from tests.scenarios.trials.histories import AIR, AREA, BESIDE, LANDED, START, TICK_US, flight

IRIS = AIRFRAMES["iris"]
TABLE, ARMCHAIR, TREE, HOME = 5, 6, 7, 8
ON_TABLE = dataclasses.replace(AREA, object_id=TABLE)
BESIDE_TABLE = (13.0, 0.0, 1.0)
ENDING = Ending(word=Verdict(success=False, reason="flipped"), is_done=True)


def contact(time_s, until_s, object_id, height_m=2.0, category=None):
    what = GROUND_NAME if object_id is None else f"object {object_id}"
    return Contact(
        time_s=time_s + 1e-6 * TICK_US,
        until_s=until_s,
        what=what,
        object_id=object_id,
        position_enu_m=(0.0, 0.0, height_m),
        speed_mps=4.0,
        category=category,
    )


def judged(history, *contacts, home_id=None):
    goal = Goal(area=ON_TABLE, others=(ON_TABLE, BESIDE))
    touched = Touched(contacts=contacts, home_id=home_id)
    return judge(score_flight(history, IRIS, goal, touched), goal, ENDING)


def bounds(history, *contacts, home_id=None):
    touched = Touched(contacts=contacts, home_id=home_id)
    found = bounds_of(history, IRIS, ON_TABLE, (ON_TABLE, BESIDE), touched)
    return found.touchdown * 1e-6 * TICK_US, found.before


def test_a_collision_that_ends_the_flight_is_counted_with_what_when_and_how_fast():
    history = flight((1, START, 1), (5, AIR, 0), (0.3, AIR, 1), (1, (5.0, 0.0, 0.1), 1))
    tree, ground = contact(6.0, 6.3, TREE), contact(6.3, 7.3, None, 0.0)
    touchdown_s, before = bounds(history, tree, ground)
    assert before == (tree,)
    assert touchdown_s == pytest.approx(6.3, abs=0.01)
    found = judged(history, tree, ground)
    assert found.code is Code.CONTACT
    touch = "touched object 7 at 6.0 s and 4.0 m/s before touchdown"
    assert found.reason == f"{touch}; the pilot gave up: flipped"
    assert found.fate is Fate.COLLIDED


def test_a_vehicle_that_stays_in_a_tree_has_collided_with_it():
    history = flight((1, START, 1), (5, AIR, 0), (2, AIR, 1))
    tree = contact(6.0, 8.0, TREE)
    touchdown_s, before = bounds(history, tree)
    assert before == (tree,)
    assert touchdown_s == pytest.approx(6.0, abs=0.01)


def test_the_side_of_what_bears_the_area_is_no_place_to_land():
    history = flight((1, START, 1), (5, AIR, 0), (1, BESIDE_TABLE, 1))
    side = contact(6.0, 7.0, TABLE)
    assert bounds(history, side)[1] == (side,)


def test_an_armchair_beside_the_place_is_touched_before_the_table_is():
    low = (*LANDED[:2], LANDED[2] + 0.1)
    history = flight((1, START, 1), (5, AIR, 0), (0.1, low, 1), (2, LANDED, 1))
    armchair, table = contact(6.0, 6.1, ARMCHAIR), contact(6.1, 8.1, TABLE)
    touchdown_s, before = bounds(history, armchair, table)
    assert before == (armchair,)
    assert touchdown_s == pytest.approx(6.1, abs=0.01)
    assert bounds(history, dataclasses.replace(table, time_s=armchair.time_s))[1] == ()


@pytest.mark.parametrize(
    ("place", "touched"),
    [
        (LANDED, contact(6.0, 8.0, TABLE)),
        ((14.0, 0.0, START[2]), contact(6.0, 8.0, None, 0.0)),
        ((30.0, 0.0, START[2]), contact(6.0, 8.0, None, 0.0)),
        ((30.0, 0.0, START[2]), contact(6.0, 8.0, 9, 0.0, "lawn")),
        ((0.0, 0.0, START[2] + 3.0), contact(6.0, 8.0, HOME, 3.0)),
    ],
    ids=["the assigned area", "another area", "the ground", "a lawn", "home"],
)
def test_a_surface_to_land_on_is_no_collision(place, touched):
    history = flight((1, START, 1), (5, AIR, 0), (2, place, 1))
    touchdown_s, before = bounds(history, touched, home_id=HOME)
    assert before == ()
    assert touchdown_s == pytest.approx(6.0, abs=0.01)


def test_the_wall_of_what_it_started_from_is_a_collision():
    history = flight((1, START, 1), (5, AIR, 0), (2, (0.0, 0.0, 1.0), 1))
    wall = contact(6.0, 8.0, HOME, 1.3)
    assert bounds(history, wall, home_id=HOME)[1] == (wall,)


def test_the_wall_of_a_room_is_no_floor():
    history = flight((1, START, 1), (5, AIR, 0), (2, (30.0, 0.0, 1.0), 1))
    wall = contact(6.0, 8.0, 9, 1.3, "room")
    assert bounds(history, wall)[1] == (wall,)


def test_all_contacts_of_a_flight_that_ends_in_the_air_count():
    history = flight((1, START, 1), (5, AIR, 0), (0.1, AIR, 1), (3, AIR, 0))
    tree = contact(6.0, 6.1, TREE)
    assert bounds(history, tree) == (pytest.approx(9.1), (tree,))
    assert judged(history, tree).fate is Fate.COLLIDED


def test_each_flight_leaves_its_vehicle_down_broken_or_lost():
    table = contact(6.0, 8.0, TABLE)
    down = flight((1, START, 1), (5, AIR, 0), (2, LANDED, 1))
    assert judged(down, table).fate is Fate.SAFE_DOWN
    tilted = down.copy()
    tilted["quat_true_wxyz"][-300:] = (0.7, 0.7, 0.0, 0.0)
    assert judged(tilted, table).fate is Fate.COLLIDED
    hard = down.copy()
    hard["velocity_true_enu_mps"][1490:1500] = (0.0, 0.0, -3.0)
    assert judged(hard, table).fate is Fate.COLLIDED
    sliding = down.copy()
    sliding["velocity_true_enu_mps"][-50:] = (0.3, 0.0, 0.0)
    assert judged(sliding, table).fate is Fate.LOST
    assert judged(flight((1, START, 1), (5, AIR, 0))).fate is Fate.LOST
    assert judged(flight((3, START, 1))).fate is None
