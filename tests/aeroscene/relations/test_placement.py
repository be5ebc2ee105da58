import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.relations import Align, Gap, Kind, Relation, Residual, place, scene_relations
from aeroscene.relations.placement import locate, residual_of
from aeroscene.relations.plane import Place, Rectangle, hull
from tests.aeroscene.metrics.scenes import scene_of
from tests.aeroscene.relations.rooms import ROOM, office, on_floor

metres, angles = st.floats(-20, 20), st.floats(-math.pi, math.pi)
halves = st.tuples(st.floats(0.1, 10), st.floats(0.1, 10))
relations = st.builds(
    Relation,
    kind=st.sampled_from([kind for kind in Kind if kind != Kind.SEAT]),
    side=st.integers(0, 3),
    gap=st.sampled_from(Gap),
    align=st.sampled_from(Align),
    slot=st.integers(0, 7),
    quadrant=st.integers(0, 4),
)


def without_noise(unit):
    """A unit with only what its relation leaves open."""
    names = ("u_m", "v_m", "yaw_rad")
    pins = zip(names, unit.relation.pinned, strict=True)
    residual = replace(unit.residual, **{name: 0.0 for name, is_pinned in pins if is_pinned})
    members = tuple(replace(member, residual=Residual()) for member in unit.members)
    return replace(unit, members=members, residual=residual)


@given(relations, metres, metres, angles, halves, metres, metres, angles, halves)
def test_a_residual_gives_back_the_place(relation, x, y, yaw, half, u, v, turn, child_half):
    host, child = Rectangle(Place(x, y, yaw), half), Rectangle(Place(u, v, turn), child_half)
    residual = residual_of(relation, host, child)
    found = locate(relation, residual, host, child_half)
    assert (found.x_m, found.y_m) == pytest.approx((u, v), abs=1e-9)
    assert math.remainder(found.yaw_rad - turn, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_what_is_pinned_stands_flush_without_a_residual():
    host = Rectangle(Place(0.0, 0.0, 0.0), (3.0, 2.0))
    corner = Relation(kind=Kind.EDGE, side=1, gap=Gap.TOUCH, align=Align.HIGH, quadrant=2)
    found = locate(corner, Residual(), host, (0.25, 0.5))
    # The back, half a metre wide, 3 cm off the north wall, and an end 3 cm off the west one.
    assert (found.x_m, found.y_m) == pytest.approx((-3.0 + 0.03 + 0.5, 2.0 - 0.03 - 0.25))


def test_without_noise_a_row_is_even():
    scene = office(off_m=(0.05, -0.04, 0.06))
    coarse = {obj.id: obj.bbox for obj in scene.objects if obj.is_coarse}
    units = scene_relations(scene)
    noisy, even = place(units, coarse), place(map(without_noise, units), coarse)
    for boxes, is_even in ((noisy, False), (even, True)):
        columns = sorted(box.p[1] for box in boxes.values() if box.p[0] < 0)
        steps = [after - before for before, after in pairwise(columns)]
        assert (max(steps) - min(steps) < 1e-9) == is_even


def test_without_noise_a_wardrobe_stands_at_the_wall_where_it_stood_along_it():
    scene = scene_of(ROOM, on_floor("wardrobe", 5.65, 1.3, (0.54, 1.94, 2), 180))
    (unit,) = scene_relations(scene)
    (box,) = place([without_noise(unit)], {scene.objects[0].id: scene.objects[0].bbox}).values()
    assert box.p == pytest.approx((6.0 - 0.03 - 0.27, 1.3, 1.0))


@given(metres, metres, angles)
def test_a_hull_is_as_long_and_wide_as_what_it_is_about(x, y, yaw):
    """Two tiles of an L, the second of them a quarter turn off the first."""
    first = Rectangle(Place(x, y, yaw), (2.0, 3.0))
    second = Rectangle(first.place.moved(4.0, 1.0, math.pi / 2), (2.0, 1.5))
    found = hull([first, second])
    assert found.half_m == pytest.approx((3.75, 3.0))
    assert found.place.local(first.place) == pytest.approx((-1.75, 0.0, 0.0), abs=1e-9)
