"""The widest way is as wide as the widest of all ways, and is found without a look at the rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from scipy import ndimage

from autonomy.planning import DistanceField
from autonomy.planning.search import SeenRoom, search_grid
from autonomy.planning.widest_path import narrowest_place, widest_path
from tests.autonomy.planning_worlds import seeds

LEAST, ENOUGH = 0.25, 2.0


def field_of(distance_m):
    return DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1.0, distance_m=distance_m)


def widest_of_all(distance_m, start, goal):
    """By joining what hangs together at every width, widest first; ends count as wide."""
    distance_m = distance_m.copy()
    distance_m[tuple(start)] = distance_m[tuple(goal)] = np.inf
    for width in np.unique(distance_m)[::-1]:
        labels, _ = ndimage.label(distance_m >= width)
        if labels[tuple(start)] == labels[tuple(goal)]:
            return width if width >= LEAST else 0.0
    return 0.0


@given(seeds)
@settings(max_examples=60)
def test_the_widest_way_is_as_wide_as_any(seed):
    rng = np.random.default_rng(seed)
    # Few different distances, as in a real field, so that many cells are equally wide.
    distance_m = rng.integers(0, 6, rng.integers(2, 7, 3)) / 2.0
    start, goal = (rng.integers(0, distance_m.shape) for _ in range(2))
    best = widest_of_all(distance_m, start, goal)
    for enough_m in (np.inf, ENOUGH):
        room_m, cell = narrowest_place(
            field_of(distance_m), start, goal, least_m=LEAST, enough_m=enough_m
        )
        assert min(room_m, enough_m) == min(best, enough_m)
        if 0.0 < room_m < np.inf:
            assert distance_m[tuple(cell)] == room_m


def test_of_two_narrow_places_the_first_is_named():
    distance_m = np.full((12, 3, 3), 3.0)
    distance_m[[3, 8]] = 0.5
    ends = np.array([0, 1, 1]), np.array([11, 1, 1])
    for start, goal, place in ((*ends, 3), (*ends[::-1], 8)):
        found = narrowest_place(field_of(distance_m), start, goal, least_m=LEAST, enough_m=ENOUGH)
        assert (found.room_m, found.cell[0]) == (0.5, place)


def cells_met(kernel, distance_m, *arguments):
    marks = np.zeros(distance_m.size, dtype=np.uint8)
    kernel(distance_m, *arguments, marks)
    return np.count_nonzero(marks)


@pytest.mark.parametrize("door_m", [0.5, 0.0])
def test_a_closed_room_is_told_by_a_look_at_the_room_from_either_side(door_m):
    distance_m = np.full((160, 160, 40), 3.0)
    distance_m[100] = 0.7
    distance_m[75:86, 75:86, :8] = 0.0
    distance_m[76:85, 76:85, 1:7] = 1.0
    distance_m[75, 80, 1:4] = door_m
    room, outside, inside = 9 * 9 * 6, np.array([150, 10, 30]), np.array([82, 82, 3])
    for ends in ((outside, inside), (inside, outside)):
        # A tree meets up to six cells for each that it enters.
        assert cells_met(widest_path, distance_m, *ends, LEAST, 0.9) < 12 * room


def test_what_a_search_meets_follows_the_way_and_not_the_place():
    distance_m = np.full((160, 160, 40), 3.0)
    distance_m[80] = 2.5
    ends = np.array([150, 10, 30]), np.array([10, 10, 5])
    assert cells_met(widest_path, distance_m, *ends, LEAST, 0.9) < 15 * 140
    seen = SeenRoom(np.zeros((1, 1, 1)), 0.0, -1)
    assert cells_met(search_grid, distance_m, *ends, 0.9, 2.0, seen, 0.0, 1.0) < 60 * 140
