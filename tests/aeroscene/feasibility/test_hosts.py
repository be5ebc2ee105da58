from __future__ import annotations

from aeroscene.feasibility.hosts import dissolve, rehome
from aeroscene.feasibility.layout import layout_of
from tests.aeroscene.feasibility.scenes import BENCH, LAWN, PLAZA, garden, row_of, thing

HOUSE, ROOM, BED, BUSH, OTHER = range(50, 55)


def winter_garden(bush_x_m: float):
    """A house with two rooms, a lawn in the first and a bush of that lawn."""
    return garden(
        thing(HOUSE, "house", (60.0, 0.0, 2.0), (10.0, 20.0, 4.0)),
        thing(ROOM, "room", (60.0, -5.0, 1.7), (9.0, 9.0, 3.0), HOUSE),
        thing(OTHER, "room", (60.0, 5.0, 1.7), (9.0, 9.0, 3.0), HOUSE),
        thing(BED, "lawn", (58.0, -5.0, 0.35), (3.0, 3.0, 0.2), ROOM),
        thing(BUSH, "bush", (bush_x_m, -5.0, 0.9), (0.8, 0.8, 0.9), BED),
    )


def parent_of(layout, number):
    return layout.object(row_of(layout, number)).parent_id


def test_what_stood_on_a_lawn_indoors_is_left_to_its_room():
    layout = layout_of(winter_garden(58.0))
    dissolve(layout, row_of(layout, BED))
    assert parent_of(layout, BUSH) == ROOM


def test_what_lies_beside_a_lawn_indoors_goes_to_the_room_below():
    layout = layout_of(winter_garden(63.0))
    rehome(layout)
    assert parent_of(layout, BUSH) == ROOM


def test_furniture_goes_to_the_room_in_which_it_is():
    chair = thing(60, "chair", (60.0, 4.0, 0.7), (0.5, 0.5, 0.9), ROOM)
    layout = layout_of(garden(*winter_garden(58.0).objects, chair))
    rehome(layout)
    assert parent_of(layout, 60) == OTHER


def test_a_bench_beside_its_lawn_goes_to_the_plaza_below_or_stays_with_its_lawn():
    layout = layout_of(garden(thing(BENCH, "bench", (0.0, 18.0, 0.5), (0.6, 1.8, 0.8), LAWN)))
    rehome(layout)
    assert parent_of(layout, BENCH) == PLAZA
    layout = layout_of(garden(thing(BENCH, "bench", (-19.0, 0.0, 0.5), (0.6, 1.8, 0.8), LAWN)))
    rehome(layout)
    assert parent_of(layout, BENCH) == LAWN
