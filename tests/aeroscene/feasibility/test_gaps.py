from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.feasibility.boxes import separation, strangers
from aeroscene.feasibility.gaps import APART_M, settle_gaps
from aeroscene.feasibility.layout import layout_of
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.feasibility.scenes import LAWN, garden, row_of, thing

FIRST, SECOND, CUP = 20, 21, 22
NO_AIR = strangers(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


def layout_with_gap(gap_m: float, *others):
    """Two crates of 1 m on a lawn, one beside the other along x, and a cup on the second."""
    x_m = -15.0 + 1.0 + gap_m
    return layout_of(
        garden(
            thing(FIRST, "crate", (-15.0, -5.0, 0.56), (1.0, 1.0, 1.0), LAWN),
            thing(SECOND, "crate", (x_m, -5.0, 0.56), (1.0, 1.0, 1.0), LAWN),
            thing(CUP, "cup", (x_m, -5.0, 1.11), (0.1, 0.1, 0.1), SECOND),
            *others,
        )
    )


def gap_m(layout, first=FIRST, second=SECOND):
    rows = (np.array([row_of(layout, number)]) for number in (first, second))
    return float(separation(layout.boxes, *rows)[0][0])


@pytest.mark.parametrize(
    ("before_m", "after_m"),
    [(0.0, 0.0), (0.004, 0.0), (0.014, 0.0), (0.016, APART_M), (0.029, APART_M), (0.04, 0.04)],
)
def test_objects_touch_or_are_apart(before_m, after_m):
    layout = layout_with_gap(before_m)
    settle_gaps(layout, NO_AIR)
    assert gap_m(layout) == pytest.approx(after_m, abs=1e-9)
    # What stands on an object moves with it.
    crate, cup = (layout.boxes.centre_m[row_of(layout, number)] for number in (SECOND, CUP))
    np.testing.assert_allclose(crate[:2], cup[:2])


def test_an_object_between_two_others_closes_one_gap_without_opening_a_narrow_one():
    # The third crate is 3 cm beyond the second one. Only a move of the first one is free.
    third = thing(23, "crate", (-15.0 + 2.0 + 0.004 + 0.03, -5.0, 0.56), (1.0, 1.0, 1.0), LAWN)
    layout = layout_with_gap(0.004, third)
    settle_gaps(layout, NO_AIR)
    assert gap_m(layout) == pytest.approx(0.0, abs=1e-9)
    assert gap_m(layout, SECOND, 23) >= APART_M - 1e-9


@pytest.mark.parametrize("wall_m", [0.002, 0.5])
def test_a_gap_is_closed_where_there_is_no_room_to_open_it(wall_m):
    # Containers at both ends leave the crates 2 mm, or half a metre.
    ends_m = -15.0 - 0.5 - wall_m - 1.0, -15.0 + 1.516 + wall_m + 1.0
    walls = [
        thing(24 + i, "container", (x_m, -5.0, 1.06), (2.0, 2.0, 2.0), LAWN)
        for i, x_m in enumerate(ends_m)
    ]
    layout = layout_with_gap(0.016, *walls)
    settle_gaps(layout, NO_AIR)
    assert gap_m(layout) == pytest.approx(0.0 if wall_m < 0.014 else APART_M, abs=1e-9)


def test_pinned_objects_stay():
    layout = layout_with_gap(0.004)
    before = layout.boxes.centre_m.copy()
    pinned = replace(layout, is_pinned=np.ones(len(before), dtype=bool))
    settle_gaps(pinned, NO_AIR)
    np.testing.assert_array_equal(pinned.boxes.centre_m, before)


@pytest.mark.parametrize("index", [7, 42, 311])
def test_curated_scenes_stay(index):
    layout = layout_of(cached_scene(index))
    before = layout.boxes.centre_m.copy()
    settle_gaps(layout, NO_AIR)
    assert np.abs(layout.boxes.centre_m - before).max() == 0.0
