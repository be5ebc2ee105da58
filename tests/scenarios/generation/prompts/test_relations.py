"""Every relation holds where it should, and no longer once a fault is put in by hand."""

import math
from typing import get_args

import pytest

from scenarios.generation.prompts.demands import numbers_of
from scenarios.generation.prompts.finder import Finder
from scenarios.generation.prompts.relations import within
from scenarios.generation.prompts.wishes import Relation, RelationName
from tests.aeroscene.metrics.scenes import box, scene_of, turned

HOUSE = ("house", box((0, 0, 2), (8, 10, 4)))
ROAD = ("road", box((0, 0, 0.02), (40, 7, 0.04)))
TABLE = ("table", box((0, 0, 0.37), (1.2, 2, 0.74)))
CANOPY = ("canopy", box((0, 0, 1.5), (6, 6, 3)))
POND = ("water", box((0, 0, 0.1), (8, 8, 0.2)))


def car(x, y, yaw_deg=0.0, z=0.8):
    return ("car", box((x, y, z), (4.2, 1.8, 1.5), yaw_deg))


def bench(x, y, yaw_deg=0.0):
    return ("bench", box((x, y, 0.4), (0.6, 1.8, 0.8), yaw_deg))


def cup(x, y, z=0.79):
    return ("cup", box((x, y, z), (0.1, 0.1, 0.1)))


def tree(x, y):
    return ("tree", box((x, y, 3), (3, 3, 6)))


def crate(x, y, z=0.5):
    return ("crate", box((x, y, z), (1, 1, 1)))


def chimney(z):
    return ("chimney", box((1, 1, z), (0.8, 0.8, 2)))


# Relation, thing, host, other objects and those that stand so; then what is there with a fault.
CASES = (
    ("on", "cup", "table", [TABLE, cup(0.2, 0.5)], [TABLE, cup(0.2, 1.5)], 0),
    ("on", "cup", "table", [TABLE, cup(0.2, 0.5)], [TABLE, cup(0.2, 0.5, 2.0)], 0),
    ("on", "car", "road", [ROAD, car(5, 1)], [ROAD, car(5, 5)], 0),
    ("on", "chimney", "house", [HOUSE, chimney(5)], [HOUSE, chimney(1)], 0),
    ("on_roof", "chimney", "house", [HOUSE, chimney(5.2)], [HOUSE, chimney(2.5)], 0),
    (
        "over",
        "bridge",
        "road",
        [ROAD, ("bridge", box((0, 0, 2.5), (3, 12, 5)))],
        [ROAD, ("bridge", box((0, 10, 2.5), (3, 12, 5)))],
        0,
    ),
    ("under", "crate", "canopy", [CANOPY, crate(1, 1)], [CANOPY, crate(1, 5)], 0),
    ("under", "crate", "canopy", [CANOPY, crate(1, 1)], [CANOPY, crate(1, 1, 3.5)], 0),
    (
        "inside",
        "crate",
        "container",
        [("container", box((0, 0, 1.3), (6, 2.4, 2.6))), crate(1, 0)],
        [("container", box((0, 0, 1.3), (6, 2.4, 2.6))), crate(1, 0, 3.1)],
        0,
    ),
    ("next_to", "car", "house", [HOUSE, car(8, 0)], [HOUSE, car(10, 0)], 0),
    ("near", "car", "house", [HOUSE, car(10, 0)], [HOUSE, car(17, 0)], 0),
    ("near", "car", "house", [HOUSE, car(10, 0)], [HOUSE, car(10, 0, z=6.0)], 0),
    ("in_front_of", "car", "house", [HOUSE, car(9, 3)], [HOUSE, car(-9, 3)], 0),
    ("in_front_of", "car", "house", [HOUSE, car(9, 3)], [HOUSE, car(9, 9)], 0),
    ("behind", "car", "house", [HOUSE, car(-9, 0)], [HOUSE, car(9, 0)], 0),
    ("behind", "car", "house", [HOUSE, car(-9, 0)], [HOUSE, car(-24, 0)], 0),
    ("facing", "bench", "water", [POND, bench(7, 0, 180)], [POND, bench(7, 0, 0)], 0),
    ("facing", "bench", "water", [POND, bench(7, 0, 180)], [POND, bench(7, 0, 90)], 0),
    (
        "along",
        "tree",
        "road",
        [ROAD, tree(-8, 5), tree(0, 5), tree(8, 5)],
        [ROAD, tree(-8, 5), tree(0, 5), tree(8, 15)],
        0,
    ),
    (
        "along",
        "tree",
        "road",
        [ROAD, tree(-8, 5), tree(0, 5), tree(8, 5)],
        [ROAD, tree(-3, 5), tree(0, 5), tree(3, 5)],
        0,
    ),
    (
        "around",
        "tree",
        "water",
        [POND, tree(7, 0), tree(0, 7), tree(-7, 0)],
        [POND, tree(7, 0), tree(7, 3), tree(-7, 0)],
        0,
    ),
    (
        "between",
        "tree",
        "house",
        [HOUSE, ("house", box((30, 0, 2), (8, 10, 4))), tree(15, 2)],
        [HOUSE, ("house", box((30, 0, 2), (8, 10, 4))), tree(15, 12)],
        0,
    ),
    (
        "between",
        "tree",
        "house",
        [HOUSE, ("house", box((30, 0, 2), (8, 10, 4))), tree(15, 2)],
        [HOUSE, tree(15, 2)],
        0,
    ),
)


def count(scene, relation, thing, host):
    demand = Relation(thing, relation=relation, host=host)
    ((_, n),) = numbers_of(scene, [demand])
    return n


@pytest.mark.parametrize(("relation", "thing", "host", "rows", "faulty", "left"), CASES)
@pytest.mark.parametrize("quarters", [0, 1])
def test_a_relation_holds_until_a_fault_is_put_in(
    relation, thing, host, rows, faulty, left, quarters
):
    there = sum(row[0] == thing for row in rows)
    assert count(turned(scene_of(*rows), quarters), relation, thing, host) == there
    assert count(turned(scene_of(*faulty), quarters), relation, thing, host) == left


def test_every_relation_has_a_case():
    assert {case[0] for case in CASES} == set(get_args(RelationName))


def test_what_a_host_bears_is_on_it_and_rooms_are_on_no_building():
    slope = ("roof", box((0, 0, 5), (8, 10, 2)))
    rows = [HOUSE, slope, ("chimney", box((1, 1, 5), (0.8, 0.8, 2)), 1)]
    assert count(scene_of(*rows), "on", "chimney", "roof") == 1
    room = ("room", box((0, 0, 1.5), (7, 9, 2.8)), 0)
    assert count(scene_of(HOUSE, room), "on", "room", "house") == 0
    assert count(scene_of(HOUSE, room), "inside", "room", "house") == 1


def test_nothing_is_next_to_itself_and_nothing_to_what_is_not_there():
    assert count(scene_of(HOUSE), "next_to", "house", "house") == 0
    assert count(scene_of(HOUSE), "next_to", "car", "house") == 0
    assert count(scene_of(car(0, 0)), "between", "car", "house") == 0


def test_a_turned_house_has_its_front_where_it_looks():
    for yaw_deg in (0, 37, 120, 250):
        yaw = math.radians(yaw_deg)
        rows = [("house", box((3, 4, 2), (8, 10, 4), yaw_deg))]
        rows += [car(3 + 10 * math.cos(yaw), 4 + 10 * math.sin(yaw))]
        assert count(scene_of(*rows), "in_front_of", "car", "house") == 1
        assert count(scene_of(*rows), "behind", "car", "house") == 0


def test_what_is_within_a_distance_may_stand_beneath():
    finder = Finder(scene_of(CANOPY, crate(1, 1), crate(5, 0), crate(9, 0), crate(1, 1, 9)))
    near = within(finder.instances("crate"), finder.instances("canopy"), 2.0)
    assert near[:, 0].tolist() == [True, True, False, False]
