"""Stairs go where the level goes that they lead to, and go away where they lead nowhere."""

import math

import numpy as np
import pytest

from aeroscene.feasibility.layout import layout_of
from aeroscene.feasibility.stairs import drop_lost, follow_levels, landings_of
from tests.aeroscene.feasibility.scenes import LAWN, garden, row_of, thing

DECK, STAIRS = 20, 21
DECK_BOX = ((0.0, -10.0, 0.56), (4.0, 6.0, 1.0))


def yard(x_m: float = -3.0):
    """A deck, and stairs of 2 m that end at its west side."""
    deck = thing(DECK, "deck", *DECK_BOX, LAWN)
    stairs = thing(STAIRS, "stairs", (x_m, -10.0, 0.56), (2.0, 1.2, 1.0), LAWN)
    return layout_of(garden(deck, stairs))


def test_stairs_lead_to_the_level_at_their_top():
    layout = yard()
    (found,) = landings_of(layout)
    assert (found.stairs, found.level) == (row_of(layout, STAIRS), row_of(layout, DECK))
    assert found.share == pytest.approx([-1.0, 0.0])
    assert landings_of(yard(x_m=-3.6)) == []


def test_stairs_follow_a_level_that_moves_turns_and_shrinks():
    layout = yard()
    landings = landings_of(layout)
    deck, stairs = row_of(layout, DECK), row_of(layout, STAIRS)
    layout.boxes.centre_m[deck, :2] = (5.0, 2.0)
    layout.boxes.yaw_rad[deck] += math.pi
    layout.boxes.half_m[deck, 0] = 1.5
    follow_levels(layout, landings)
    # The west side is the east side now.
    assert layout.boxes.centre_m[stairs, :2] == pytest.approx([5.0 + 1.5 + 1.0, 2.0])


@pytest.mark.parametrize(("shift_m", "is_present"), [(0.3, True), (0.7, False)])
def test_stairs_that_lost_their_level_go(shift_m, is_present):
    layout = yard()
    landings = landings_of(layout)
    stairs = row_of(layout, STAIRS)
    layout.shift(stairs, np.array([-shift_m, 0.0, 0.0]))
    drop_lost(layout, landings)
    assert layout.is_present[stairs] == is_present


def test_stairs_that_never_led_anywhere_stay():
    layout = yard(x_m=-6.0)
    drop_lost(layout, landings_of(layout))
    assert layout.is_present[row_of(layout, STAIRS)]
