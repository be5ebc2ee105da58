"""What has no room moves, and a balcony goes rather than into its building."""

import numpy as np
import pytest

from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.overlap_repair import settle
from aeroscene.feasibility.stages import _nothing
from tests.aeroscene.feasibility.scenes import BENCH, LAWN, garden, row_of, thing

BUILDING, SLAB, CHAIR = 20, 21, 22


@pytest.mark.parametrize(("x_m", "is_balcony"), [(5.8, True), (3.0, False)])
def test_balconies_without_room_go_with_what_stands_on_them(x_m, is_balcony):
    layout = layout_of(
        garden(
            thing(BUILDING, "building", (0.0, 5.0, 3.06), (10.0, 8.0, 6.0), LAWN),
            thing(SLAB, "floor", (x_m, 5.0, 3.1), (1.5, 3.0, 0.2), BUILDING),
            thing(CHAIR, "chair", (x_m, 5.0, 3.65), (0.5, 0.5, 0.9), SLAB),
        )
    )
    slab, chair = row_of(layout, SLAB), row_of(layout, CHAIR)
    assert layout.is_balcony(slab) == is_balcony
    settle(layout, slab, _nothing())
    assert layout.is_present[[slab, chair]].tolist() == [not is_balcony] * 2


def test_other_things_stay_where_they_have_room():
    layout = layout_of(garden())
    bench = row_of(layout, BENCH)
    before = layout.boxes.centre_m.copy()
    settle(layout, bench, _nothing())
    assert np.array_equal(layout.boxes.centre_m, before)
