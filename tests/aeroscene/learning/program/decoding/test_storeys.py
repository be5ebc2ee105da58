"""Upper storeys lie on the rooms below them, and what is open above is high."""

import pytest

from aeroscene.learning.program.decoding.structures.storeys import Level, stacked, upper_slabs
from aeroscene.partition.cells import cells_of
from aeroscene.partition.frames import Frame
from aeroscene.partition.tree import VOID, Leaf, Part, Slice
from aeroscene.solids.shapes.facade import SLAB_M

FRAME = Frame(0.0, 0.0, 0.0, 20.0, 10.0)
WALL_M = 0.12


def split(share, first, second, axis="x"):
    return Slice(axis, (Part(share), Part(1 - share)), (first, second))


def levels(below, above):
    return [Level(below, 0.15, WALL_M), Level(above, 3.75, WALL_M)]


def cells(tree):
    return [
        (tuple(round(v, 6) for v in FRAME.bounds_of(cell.frame)), cell.leaf)
        for cell in cells_of(tree, FRAME)
    ]


LOW, HIGH, UPPER, OPEN = Leaf("a", 3.0), Leaf("b", 7.0), Leaf("c", 3.4), Leaf(VOID, 3.4)


def test_the_edge_of_a_floor_goes_to_where_high_rooms_end():
    below, above = stacked(levels(split(0.4, LOW, HIGH), split(0.5, UPPER, OPEN)), FRAME, 0.5)
    (floor, _), (void, _) = cells(above)
    assert floor == (0.0, 0.0, 8.0, 10.0)
    assert void == (8.0, 0.0, 20.0, 10.0)
    heights_m = [leaf.height_m for _, leaf in cells(below)]
    assert heights_m == pytest.approx([3.6 - SLAB_M, 7.0])


def test_a_high_room_under_a_far_floor_becomes_low_and_an_open_one_high():
    below, above = stacked(levels(split(0.2, LOW, HIGH), split(0.7, UPPER, OPEN)), FRAME, 0.5)
    assert cells(above)[0][0] == (0.0, 0.0, 14.0, 10.0)
    assert [leaf.height_m for _, leaf in cells(below)] == pytest.approx([3.6 - SLAB_M] * 2)
    below, _ = stacked(levels(split(0.5, LOW, LOW), split(0.5, UPPER, OPEN)), FRAME, 0.5)
    assert [leaf.height_m for _, leaf in cells(below)] == pytest.approx([3.6 - SLAB_M, 7.0])


def test_what_fits_stays_as_it_is():
    trees = [split(0.4, Leaf("a", 3.6 - SLAB_M), HIGH), split(0.4, UPPER, OPEN)]
    assert stacked(levels(*trees), FRAME, 0.5) == trees
    assert stacked([Level(HIGH, 0.15, WALL_M)], FRAME, 0.5) == [HIGH]


@pytest.mark.parametrize(("share", "at_m"), [(0.405, 8.0), (0.392, 8.0), (0.42, 8.4)])
def test_walls_close_beside_those_below_stand_upon_them(share, at_m):
    low = Leaf("a", 3.6 - SLAB_M)
    _, above = stacked(levels(split(0.4, low, low), split(share, UPPER, UPPER)), FRAME, 0.5)
    assert cells(above)[0][0] == (0.0, 0.0, at_m, 10.0)


def test_slabs_carry_each_room_or_all_of_a_storey():
    found = levels(LOW, split(0.4, UPPER, split(0.5, UPPER, OPEN)))
    slabs = upper_slabs(found, FRAME, [], n_slabs=2)
    assert [slab.p[2] + slab.s[2] / 2 for slab in slabs] == pytest.approx([3.75, 3.75])
    # Into the outer walls, to each other, and over half of the wall below the free edge.
    assert [slab.s[0] for slab in slabs] == pytest.approx([8.1, 6.06])
    assert [slab.s[1] for slab in slabs] == pytest.approx([10.2, 10.2])
    (whole,) = upper_slabs(found, FRAME, [], n_slabs=1)
    assert whole.s[0] == pytest.approx(14.16)
