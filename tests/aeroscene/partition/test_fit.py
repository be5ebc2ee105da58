from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given

from aeroscene.partition.cells import cells_of, merged
from aeroscene.partition.fit import SAME_M, Piece, Widths, fit, number_merges
from aeroscene.partition.tree import (
    VOID,
    Cross,
    Leaf,
    Part,
    PartitionError,
    Pinwheel,
    Slice,
    part_lengths,
    walk,
)
from tests.aeroscene.partition.layouts import FRAME, greatest_error_m, is_close, overlap_m2, trees


def piece(x0, y0, x1, y1, key, kind="lawn"):
    return Piece((x0, y0, x1, y1), Leaf(kind, 0.1), key)


def boxes(cells):
    return [cell.frame.box(cell.leaf.quarter, cell.base_m, cell.top_m) for cell in cells]


@given(trees())
def test_leaves_fill_their_frame_and_share_nothing(tree):
    cells = list(cells_of(tree, FRAME))
    area = sum(cell.frame.length_m * cell.frame.width_m for cell in cells)
    assert is_close(area, FRAME.length_m * FRAME.width_m)
    assert overlap_m2(boxes(cells)) < 1e-3


def has_lines_for_one(cells):
    """Whether two lines lie so near that they are fitted as one."""
    bounds = np.array([FRAME.bounds_of(cell.frame) for cell in cells])
    gaps_m = np.diff(np.sort(np.stack([bounds[:, [0, 2]], bounds[:, [1, 3]]]).reshape(2, -1)))
    return bool(((gaps_m > 1e-6) & (gaps_m <= SAME_M)).any())


def split_in_three(*numbers):
    parts = tuple(Part(number / sum(numbers)) for number in numbers)
    return Slice("x", parts, (Leaf("lawn", 0.25),) * 3)


NEARLY_IN_LINE = Slice(
    "y",
    (Part(0.5), Part(0.5)),
    (split_in_three(0.7686695, 0.95703125, 0.28125), split_in_three(0.41456688, 0.31836, 0.34961)),
)
"""A line above lies 3 mm beside one below."""


@given(trees())
@example(NEARLY_IN_LINE)
def test_what_a_tree_makes_is_fitted_and_made_again(tree):
    cells = list(cells_of(tree, FRAME))
    pieces = [Piece(FRAME.bounds_of(c.frame), c.leaf, n) for n, c in enumerate(cells, 1)]
    found = number_merges(fit(pieces))
    again = merged(list(cells_of(found, FRAME)))
    most_m = SAME_M if has_lines_for_one(cells) else 1e-5
    assert greatest_error_m(boxes(cells), boxes(again)) < most_m
    assert sorted(c.leaf.kind for c in again) == sorted(c.leaf.kind for c in cells)
    assert not any(isinstance(n, Cross) and n.is_fallback for n in walk(found))


def test_a_street_between_collinear_arms_bridges_the_columns_of_a_cross():
    pieces = [piece(0, 20, 60, 26, 1, "road")]
    for number, (y0, y1) in enumerate(((0, 20), (26, 50)), 1):
        pieces += [
            piece(0, y0, 30, y1, 10 * number),
            piece(30, y0, 37, y1, 10 * number + 1, "road"),
            piece(37, y0, 60, y1, 10 * number + 2),
        ]
    tree = number_merges(fit(pieces, Widths(frozenset(("road",)))))
    assert isinstance(tree, Cross)
    assert [part.is_width for part in tree.columns] == [False, True, False]
    assert [part.value for part in tree.rows if part.is_width] == [6.0]
    assert [leaf.merge for leaf in tree.cells[3:6]] == [1, 1, 1]


@pytest.mark.parametrize("is_mirrored", [False, True])
def test_four_streets_about_a_square_are_a_pinwheel(is_mirrored):
    rows = [(0, 0, 40, 10), (40, 0, 50, 35), (12, 35, 50, 50), (0, 10, 5, 50), (12, 10, 40, 35)]
    rows.append((5, 10, 12, 50))
    if is_mirrored:
        rows = [(50 - x1, y0, 50 - x0, y1) for x0, y0, x1, y1 in rows]
    tree = fit([piece(*row, key) for key, row in enumerate(rows, 1)])
    assert isinstance(tree, Pinwheel)
    assert tree.is_mirrored == is_mirrored
    assert tree.middle.merge == 5


def test_what_no_node_divides_is_a_grid_of_merged_cells():
    rows = [(0, 0, 2, 1), (2, 0, 4, 2), (0, 1, 1, 4), (1, 1, 2, 3), (2, 2, 3, 3), (3, 2, 4, 4),
            (1, 3, 3, 4)]  # fmt: skip
    pieces = [piece(*row, key) for key, row in enumerate(rows, 1)]
    tree = number_merges(fit(pieces))
    assert isinstance(tree, Cross)
    assert tree.is_fallback
    frame = FRAME.inner((0, 0, 4, 4))
    again = [frame.bounds_of(c.frame) for c in merged(list(cells_of(tree, frame)))]
    assert sorted(np.round(again, 6).tolist()) == sorted(map(list, rows))


def test_pieces_that_overlap_are_refused():
    with pytest.raises(PartitionError, match="piece 2 overlaps another"):
        fit([piece(0, 0, 5, 5, 1), piece(4.9, 0, 9, 5, 2)])


def test_an_l_is_one_merge_number_and_as_few_boxes_as_it_takes():
    pieces = [piece(0, 0, 4, 6, 7), piece(4, 0, 9, 2, 7), piece(4, 2, 9, 6, 8)]
    tree = number_merges(fit(pieces))
    assert sorted(n.merge for n in walk(tree) if isinstance(n, Leaf)) == [0, 1, 1]
    assert len(merged(list(cells_of(tree, FRAME)))) == 3


def test_gaps_become_void_and_nothing_stands_there():
    tree = fit([piece(0, 0, 10, 10, 1), piece(12, 0, 20, 10, 2)])
    assert [n.kind for n in walk(tree) if isinstance(n, Leaf)] == ["lawn", VOID, "lawn"]
    assert len(merged(list(cells_of(tree, FRAME)))) == 2


def test_wrong_trees_are_refused_by_name():
    leaf = Leaf("lawn")
    good = Slice("x", fit([piece(0, 0, 1, 1, 1), piece(1, 0, 2, 1, 2)]).parts, (leaf,) * 2)
    with pytest.raises(PartitionError, match="shares that sum to 1"):
        Slice("x", good.parts[:1], (leaf,))
    with pytest.raises(PartitionError, match=r"slice.children has 1 entries; valid: 2"):
        Slice("x", good.parts, (leaf,))
    with pytest.raises(PartitionError, match=r"valid: 0 < low < high < 1"):
        Pinwheel(False, (0.6, 0.4, 0.2, 0.8), (leaf,) * 4, leaf)
    with pytest.raises(PartitionError, match="thinner"):
        fit([piece(0, 0, 0.001, 5, 1)])
    road = fit([piece(0, 0, 9, 6, 1, "road"), piece(0, 6, 9, 20, 2)], Widths(frozenset(("road",))))
    with pytest.raises(PartitionError, match=r"strips are 6.000 m wide; valid: below 5.000 m"):
        part_lengths(road.parts, 5.0)
