"""Units go to free places by the ways that their relations leave open, and no farther."""

import math

import pytest

from aeroscene.learning.program.decoding.draft.neighbours import (
    Neighbours,
    free_of,
    free_shift,
    moved,
    open_ways,
    turned,
)
from aeroscene.relations import Align, Gap, Kind, Relation, Unit
from aeroscene.relations.plane import Place, Rectangle
from aeroscene.relations.relation import ANY_TURN
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw

ROOM = Rectangle(Place(0.0, 0.0, 0.0), (5.0, 4.0))


def box(x_m, y_m, size_m=(1.0, 1.0, 1.0), z_m=0.5, yaw_rad=0.0):
    return OrientedBox((x_m, y_m, z_m), quat_from_yaw(yaw_rad), size_m)


def room_with(*boxes):
    found = Neighbours()
    found.add(box(0.0, 0.0, (10.0, 8.0, 3.0), 1.5), "room", None)
    for each in boxes:
        found.add(each, "crate", 0)
    return found


def test_what_has_room_stays_to_the_digit():
    taken = room_with(box(0.0, 0.0)).taken(0)
    assert free_shift([box(1.0, 0.0)], taken, ROOM, None) == (0.0, 0.0)
    assert free_shift([box(0.0, 0.0, z_m=1.5)], taken, ROOM, None) == (0.0, 0.0)


def test_bearers_are_no_obstacle_and_all_else_is():
    neighbours = room_with(box(0.0, 0.0))
    assert len(neighbours.taken(0)) == 1
    assert len(neighbours.taken(1)) == 0
    assert len(neighbours.taken(None)) == 2
    neighbours.add_air(box(3.0, 0.0))
    assert len(neighbours.taken(1)) == 1


@pytest.mark.parametrize("way_rad", [0.0, math.pi / 2, 0.6])
def test_a_unit_goes_along_its_way_until_it_overlaps_nothing(way_rad):
    taken = room_with(box(0.0, 0.0)).taken(0)
    own = box(0.2, 0.1)
    shift = free_shift([own], taken, ROOM, (way_rad,))
    assert shift is not None
    across = shift[1] * math.cos(way_rad) - shift[0] * math.sin(way_rad)
    assert across == pytest.approx(0.0, abs=1e-9)
    assert not free_of(taken, [own])
    assert free_of(taken, [moved(own, shift)])
    assert 0.7 < math.hypot(*shift) < 1.6


def test_a_group_goes_as_one_and_stays_in_its_room():
    taken = room_with(box(-1.0, 0.0), box(3.0, 0.0)).taken(0)
    group = [box(x, 0.0) for x in (-1.2, 0.0, 1.2)]
    shift = free_shift(group, taken, ROOM, (0.0,))
    assert shift is None
    shift = free_shift(group, taken, ROOM, None)
    assert shift is not None
    assert len(free_of(taken, [moved(each, shift) for each in group])) == 3
    assert max(abs(moved(each, shift).p[1]) for each in group) <= 3.5


def test_what_reaches_over_its_bearer_is_put_onto_it():
    taken = room_with().taken(0)
    assert free_shift([box(4.8, -3.7)], taken, ROOM, None) == pytest.approx((-0.3, 0.2))
    assert free_shift([box(4.503, 0.0)], taken, ROOM, None) == (0.0, 0.0)
    assert free_shift([box(0.0, 0.0, (12.0, 1.0, 1.0))], taken, ROOM, None) == (0.0, 0.0)


def test_room_is_looked_for_from_where_the_bearer_ends():
    taken = room_with(box(3.9, 0.0)).taken(0)
    own = box(5.2, 0.0)
    shift = free_shift([own], taken, ROOM, None)
    assert shift is not None
    found = moved(own, shift)
    assert free_of(taken, [found])
    assert found.p[0] <= 4.5 + 1e-9


def ways(kind, gap, align, side=1):
    relation = Relation(kind=kind, gap=gap, align=align, side=side, quadrant=2)
    return list(open_ways(Unit(parent_id=0, host_id=0, relation=relation, members=()), ROOM))


def test_an_edge_is_left_for_another_edge_alone():
    found = ways(Kind.EDGE, Gap.TOUCH, Align.FREE)
    assert [turns for turns, _ in found] == [0, 1, 3, 2]
    assert all(len(headings) == 1 for _, headings in found)
    assert found[0][1] == pytest.approx((math.pi,))


def test_pins_are_given_up_one_by_one():
    beside = ways(Kind.SIDE, Gap.NEAR, Align.CENTRE)
    assert [turns for turns, _ in beside] == [0, 2, 1, 3, 0, 2, 1, 3, 0]
    assert [len(headings or ()) for _, headings in beside] == [0] * 4 + [1] * 4 + [0]
    assert beside[-1][1] is None
    assert ways(Kind.SCATTER, Gap.FREE, Align.FREE) == [(0, None)]
    corner = ways(Kind.EDGE, Gap.TOUCH, Align.LOW)
    assert len(corner[-1][1]) == 2
    assert all(headings is not None for _, headings in corner)


def beside(side, quadrant):
    relation = Relation(kind=Kind.SIDE, side=side, quadrant=quadrant, gap=Gap.TOUCH)
    return Unit(parent_id=0, host_id=1, relation=relation, members=())


@pytest.mark.parametrize(("side", "quadrant"), [(0, 0), (1, 3), (2, 2), (3, 1)])
def test_what_is_headed_as_its_host_is_stays_so_on_the_other_side(side, quadrant):
    """A shelf beside another along a wall has no room before it, and none with its face to it."""
    unit = beside(side, quadrant)
    assert {turns for turns, _ in open_ways(unit, ROOM)} == {0, 2}
    relation = turned(unit, 2).relation
    assert relation.side == (side + 2) % 4
    assert (relation.side + relation.quadrant) % 4 == 0


@pytest.mark.parametrize("quadrant", [0, 1, 2, ANY_TURN])
def test_what_is_headed_otherwise_turns_about_its_host(quadrant):
    """A bench that looks at a path looks at it from beyond too."""
    unit = beside(1, quadrant)
    assert {turns for turns, _ in open_ways(unit, ROOM)} == {0, 1, 2, 3}
    for turns in (1, 2, 3):
        relation = turned(unit, turns).relation
        assert (relation.side, relation.quadrant) == ((1 + turns) % 4, quadrant)
    assert turned(unit, 0) == unit


def test_what_reaches_a_little_into_others_is_not_deep_in_them():
    taken = room_with(box(0.0, 0.0)).taken(0)
    group = [box(0.9, 0.0), box(0.5, 0.0), box(2.0, 0.0)]
    assert free_of(taken, group) == group[2:]
    assert free_of(taken, group, 0.5) == [group[0], group[2]]


def test_what_is_kept_free_is_nothing_to_be_deep_in():
    neighbours = room_with()
    neighbours.add_air(box(3.0, 0.0))
    assert not free_of(neighbours.taken(0), [box(3.0, 0.0)])
    assert free_of(neighbours.taken(0, has_air=False), [box(3.0, 0.0)])
