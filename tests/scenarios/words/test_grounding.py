"""What fits a description is decided by geometry, with a margin wherever words are vague."""

from dataclasses import replace

import pytest

from scenarios.words.goal import Beside, Between, Description, Has, Nearest, On, Toward
from scenarios.words.grounding import Truth, fits, the_one
from scenarios.words.site import site_of
from tests.scenarios.words.car_park import BENCH, car, scene_of, thing

RED, BLUE = Description(kind="car", colour="red"), Description(kind="car", colour="blue")
KIOSK = Description(kind="kiosk")


def fitting(description, *objects):
    """Truth under the id of each object that a description fits."""
    found = fits(description, site_of(scene_of(*objects)))
    return {place.objects[0].id: truth for place, truth in found.items()}


def with_link(link, kind="car"):
    return Description(kind=kind, links=(link,))


def test_a_colour_is_that_of_the_rendered_paint():
    assert fitting(RED, car(1, "red", (0, 0)), car(2, "blue", (9, 0))) == {1: Truth.YES}


def test_a_colour_that_may_be_taken_for_another_is_no_ground_to_tell_two_apart():
    assert fitting(RED, car(1, "red", (0, 0)), car(2, "orange", (9, 0)))[2] is Truth.MAYBE


def test_of_two_colours_either_may_be_meant():
    van = thing(2, "van", (9, 0), (6, 2, 2.6), colour="red", form="parcel")
    for colour, truth in (("red", Truth.MAYBE), ("white", Truth.MAYBE), ("blue", Truth.NO)):
        found = fitting(Description(kind="van", colour=colour), van)
        assert found.get(2, Truth.NO) is truth


def test_a_kind_that_may_be_taken_for_another_is_no_ground_either():
    van = thing(2, "van", (9, 0), (5, 2, 2), colour="red")
    assert fitting(RED, car(1, "red", (0, 0)), van)[2] is Truth.MAYBE
    assert the_one(RED, site_of(scene_of(car(1, "red", (0, 0)), van))) is None


@pytest.mark.parametrize(
    ("gap_m", "truth"), [(1.0, Truth.YES), (4.0, Truth.MAYBE), (8.0, Truth.NO)]
)
def test_beside_has_a_margin(gap_m, truth):
    kiosk = thing(2, "kiosk", (2.0 + gap_m + 1.5, 0), (3, 3, 3))
    found = fitting(with_link(Beside(KIOSK)), car(1, "red", (0, 0)), kiosk)
    assert found.get(1, Truth.NO) is truth


@pytest.mark.parametrize(
    ("direction", "place", "truth"),
    [
        ("north", (0, 12), Truth.YES),
        ("east", (12, 0), Truth.YES),
        ("south", (0, -12), Truth.YES),
        ("west", (-12, 0), Truth.YES),
        ("north", (10, 12), Truth.MAYBE),
        ("north", (12, 0), Truth.NO),
        ("north", (0, 60), Truth.MAYBE),
    ],
)
def test_directions_are_those_of_the_compass(direction, place, truth):
    kiosk = thing(2, "kiosk", (0, 0), (3, 3, 3))
    found = fitting(with_link(Toward(direction, KIOSK)), car(1, "red", place), kiosk)
    assert found.get(1, Truth.NO) is truth


def test_what_stands_between_two_is_near_the_middle_of_the_line():
    ends = (car(2, "blue", (-15, 0)), thing(3, "kiosk", (15, 0), (3, 3, 3)))
    between = with_link(Between(BLUE, KIOSK))
    assert fitting(between, car(1, "red", (0, 0)), *ends)[1] is Truth.YES
    assert fitting(between, car(1, "red", (0, 8)), *ends)[1] is Truth.MAYBE
    assert 1 not in fitting(between, car(1, "red", (0, 40)), *ends)


def test_the_nearest_is_clearly_nearer_than_the_next():
    kiosk = thing(3, "kiosk", (0, 0), (3, 3, 3))
    nearest = with_link(Nearest(KIOSK))
    clear = fitting(nearest, car(1, "red", (6, 0)), car(2, "red", (20, 0)), kiosk)
    assert clear == {1: Truth.YES}
    close = fitting(nearest, car(1, "red", (6, 0)), car(2, "red", (-6.5, 0)), kiosk)
    assert close == {1: Truth.MAYBE, 2: Truth.MAYBE}


def test_a_count_is_exact_and_more_is_not_surely_wrong():
    lawn = thing(1, "lawn", (0, 0), (20, 20, 0.05))
    two = with_link(Has(2, "bench"), "lawn")
    benches = [thing(i, "bench", (3 * i - 8, 0), BENCH, z=0.05) for i in (2, 3, 4)]
    assert 1 not in fitting(two, lawn, *benches[:1])
    assert fitting(two, lawn, *benches[:2]) == {1: Truth.YES}
    assert fitting(two, lawn, *benches) == {1: Truth.MAYBE}


def test_what_stands_half_on_a_place_counts_for_neither():
    lawn = thing(1, "lawn", (0, 0), (20, 20, 0.05))
    bench = thing(2, "bench", (0, 10), BENCH, z=0.05)
    assert fitting(with_link(Has(1, "bench"), "lawn"), lawn, bench) == {1: Truth.MAYBE}
    on = Description(kind="bench", links=(On(Description(kind="lawn")),))
    assert fitting(on, lawn, bench) == {2: Truth.MAYBE}


def test_a_relation_to_something_that_is_not_unique_fits_nothing():
    two = [thing(i, "kiosk", (4.5 * (2 * i - 5), 0), (3, 3, 3)) for i in (2, 3)]
    assert fitting(with_link(Beside(KIOSK)), car(1, "red", (0, 0)), *two) == {}


def test_what_stands_on_the_first_object_of_a_scene_stands_surely_on_nothing_else():
    lawn = thing(0, "lawn", (0, 0), (12, 12, 0.1))
    plaza = thing(1, "plaza", (0, 0), (8, 8, 0.1))
    bench = replace(thing(2, "bench", (0, 0), BENCH, z=0.1), parent_id=0)
    on_plaza = with_link(On(Description(kind="plaza")), kind="bench")
    assert fitting(on_plaza, lawn, plaza, bench) == {2: Truth.MAYBE}
