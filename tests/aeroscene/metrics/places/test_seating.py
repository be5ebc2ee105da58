import math

import pytest

from aeroscene.metrics.places.seating import averted_chairs, lone_plates
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of


def table(category="table", x=0.0, z=0.37):
    return (category, box((x, 0, z), (0.9, 1.8, 0.74)))


def chair(x, y, yaw_deg, z=0.45):
    return ("chair", box((x, y, z), (0.5, 0.5, 0.9), yaw_deg))


def averted(*rows):
    return averted_chairs(TopView(scene_of(*rows))).tolist()


@pytest.mark.parametrize("category", ["table", "desk"])
@pytest.mark.parametrize(
    ("turn_deg", "is_off"),
    [(0, False), (40, False), (-40, False), (50, True), (-50, True), (90, True), (180, True)],
)
def test_a_chair_faces_its_table(category, turn_deg, is_off):
    rows = [table(category)]
    rows += [chair(-0.8, y, 0 + turn_deg) for y in (-0.6, 0.0, 0.6)]
    rows += [chair(0.8, 0.3, 180 + turn_deg), chair(0, 1.25, -90 + turn_deg)]
    assert averted(*rows) == [is_off] * 5


def test_chairs_in_the_middle_of_the_room_are_not_judged():
    assert averted(table(), chair(-1.1, 0, 180)) == [True]
    assert averted(table(), chair(-1.3, 0, 180)) == []
    assert averted(chair(0, 0, 0)) == []


def test_the_nearest_table_counts():
    first, second = table(x=0), table(x=1.9)
    # Between the two, its back to the one that is farther by a third of a metre.
    assert averted(first, second, chair(0.78, 0, 180)) == [False]
    assert averted(first, second, chair(1.12, 0, 180)) == [True]


def test_a_table_upstairs_does_not_count():
    assert averted(table(z=4), chair(-0.8, 0, 180)) == []


def wall(x, z=1.5):
    return ("wall", box((x, 0, z), (0.1, 6, 3)))


def test_a_table_behind_a_wall_does_not_count():
    assert averted(table(), chair(-0.95, 0, 180)) == [True]
    assert averted(table(), chair(-0.95, 0, 180), wall(-0.57)) == []
    assert averted(table(), chair(-0.95, 0, 180), wall(-0.57, z=6)) == [True]
    assert lone(table(), plate(-0.25, 0), chair(-0.95, 0, 0)) == [False]
    assert lone(table(), plate(-0.25, 0), chair(-0.95, 0, 0), wall(-0.57)) == [True]


def test_a_chair_under_the_table_faces_its_middle():
    assert averted(table(), chair(-0.4, 0, 0), chair(-0.4, 0, 180)) == [False, True]


def lone(*rows):
    return lone_plates(TopView(scene_of(*rows))).tolist()


def plate(x, y, z=0.75, parent=0):
    return ("plate", box((x, y, z), (0.25, 0.25, 0.02)), parent)


@pytest.mark.parametrize(("apart_m", "is_lone"), [(0.5, False), (0.89, False), (0.91, True)])
def test_a_plate_has_a_chair(apart_m, is_lone):
    y = math.sqrt(apart_m**2 - 0.4**2)
    assert lone(table(), plate(-0.25, 0), chair(-0.65, y, 0)) == [is_lone]


def test_a_plate_without_any_chair_is_lone_and_chairs_of_other_storeys_do_not_count():
    assert lone(table(), plate(0, 0)) == [True]
    assert lone(table(), plate(-0.25, 0), chair(-0.75, 0, 0, z=4.0)) == [True]
    assert lone(table(), plate(-0.25, 0, z=0.8), ("chair", box((-0.75, 0, 0.3), (0.5, 0.5, 0.6))))


def test_plates_on_counters_are_not_judged():
    counter = ("counter", box((0, 0, 0.45), (0.6, 2, 0.9)))
    assert lone(counter, plate(0, 0, z=0.91)) == []
