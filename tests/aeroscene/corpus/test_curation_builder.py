from __future__ import annotations

import math

from hypothesis import assume, given
from hypothesis import strategies as st

from aeroscene.corpus.curation.builder import TOUCH_M, Builder
from aeroscene.corpus.curation.frame import Frame
from aeroscene.scene.geometry import penetration_depth

places = st.floats(-3, 3)
lengths = st.floats(0.2, 4)
angles = st.floats(-math.pi, math.pi)
WORLD = Frame(0.0, 0.0, 0.0)


@given(st.tuples(lengths, lengths, lengths), st.tuples(lengths, lengths, lengths), angles, angles,
       places, places, places)  # fmt: skip
def test_a_second_box_is_refused_exactly_when_it_would_overlap(a, b, turn_a, turn_b, u, v, base):
    free = Builder("free")
    free.place("crate", WORLD.moved(u, v, turn_b), b, base=base)
    builder = Builder("s")
    builder.place("crate", WORLD.moved(0, 0, turn_a), a)
    second = builder.place("crate", WORLD.moved(u, v, turn_b), b, base=base)
    first_box, second_box = builder.objects[0].bbox, free.objects[0].bbox
    depth = penetration_depth(
        first_box.p, first_box.q, first_box.s, second_box.p, second_box.q, second_box.s
    )
    assume(abs(depth - TOUCH_M) > 1e-3)
    assert (second is None) == (depth > TOUCH_M)


def test_children_may_lie_within_their_ancestors_but_not_within_strangers():
    builder = Builder("s")
    hall = builder.place("building", WORLD, (9, 9, 9))
    room = builder.place("room", WORLD, (6, 6, 3), base=0.2, parent=hall)
    assert builder.place("table", WORLD, (1, 1, 1), base=0.3, parent=room)
    assert builder.place("table", WORLD.moved(2, 0), (1, 1, 1), base=0.3) is None
    assert [obj.parent_id for obj in builder.objects] == [None, 0, 1]


def test_reserved_air_stays_free():
    builder = Builder("s")
    builder.reserve(WORLD, (2, 2, 2), 1.0)
    assert builder.place("crate", WORLD, (1, 1, 2)) is None
    assert builder.place("crate", WORLD, (1, 1, 0.9))


def test_an_outline_that_leaves_its_bearer_is_refused():
    builder = Builder("s")
    table = builder.place("table", WORLD, (1, 2, 0.7))
    assert table
    near_edge = {"parent": table, "within": table}
    assert builder.place("cup", table.frame.moved(0.48, 0), (0.1, 0.1, 0.1), **near_edge) is None
    assert builder.place("cup", table.frame.moved(0.44, 0), (0.1, 0.1, 0.1), **near_edge)


def test_what_leaves_the_flight_volume_is_refused():
    builder = Builder("s")
    builder.enclose((-5.0, -5.0), (5.0, 5.0))
    assert builder.place("crate", WORLD.moved(4.5, 0), (1, 1, 1))
    assert builder.place("crate", WORLD.moved(4.6, 2), (1, 1, 1)) is None
    assert builder.place("crate", WORLD.moved(-4.4, 0, math.pi / 4), (1, 1, 1)) is None
    assert builder.place("crate", WORLD.moved(-4.2, 0, math.pi / 4), (1, 1, 1))
