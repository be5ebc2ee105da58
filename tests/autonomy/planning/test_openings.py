"""Openings in walls of known measures."""

import math

import numba
import numpy as np
import pytest

from autonomy.planning import Obstacles, openings
from autonomy.planning.obstacles import join
from autonomy.planning.openings import Opening, find_openings, narrow_cells, reach_solids
from tests.autonomy.planning_worlds import GROUND, field_of

THICK = 0.12


def walls(yaw, parts):
    """Upright boxes (across, sill, width, height) of one wall that is turned about the origin."""
    c, s = math.cos(yaw), math.sin(yaw)
    center = np.array([[c * a, s * a, low + h / 2] for a, low, _, h in parts])
    quat = np.tile((math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)), (len(parts), 1))
    size = np.array([[w, THICK, h] for _, _, w, h in parts])
    return Obstacles.boxes(center, quat, size)


def room_with(at, width, low, high, yaw):
    """A wall of 10 m with one opening, under a ceiling at 4 m."""
    left, right = at - width / 2, at + width / 2
    parts = [
        ((left - 5) / 2, 0.0, left + 5, 4.0),
        ((right + 5) / 2, 0.0, 5 - right, 4.0),
        (at, high, width, 4.0 - high),
    ]
    if low > 0:
        parts.append((at, 0.0, width, low))
    ceiling = Obstacles.boxes(
        np.array([[0.0, 0.0, 4.5]]), np.array([[1.0, 0, 0, 0]]), np.array([[30.0, 30.0, 1.0]])
    )
    return join([walls(yaw, parts), ceiling, GROUND])


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.2, math.pi / 2])
@pytest.mark.parametrize(
    ("width", "low", "high"), [(1.5, 0.0, 2.4), (2.5, 0.0, 2.8), (1.75, 0.9, 2.4)]
)
def test_a_door_or_window_is_found_with_its_measures(yaw, width, low, high):
    world = room_with(0.6, width, low, high, yaw)
    field = field_of(world, half_extent=7.0, height=5.0, resolution=0.25)
    (found,) = find_openings(field, world)
    expected = (0.6 * math.cos(yaw), 0.6 * math.sin(yaw), (low + high) / 2)
    assert math.dist(found.center_enu_m, expected) < 0.1
    assert found.width_m == pytest.approx(width, abs=0.02)
    assert found.height_m == pytest.approx(high - low, abs=0.02)
    off = math.remainder(found.normal_rad - yaw - math.pi / 2, math.pi)
    assert abs(off) < math.radians(3.0)


@numba.njit
def looked_at_one_by_one(is_free, resolution):
    """Narrow cells without a look at what is about them before."""
    number = np.full(is_free.shape, -1, dtype=np.int8)
    most = 0.5 * openings.MAX_WIDTH_M / resolution
    for i, j, k in np.ndindex(is_free.shape):
        up = openings._run(is_free, i, j, k, 0.0, 0.0, 1.0, openings._MAX_RUN_M / resolution)
        if is_free[i, j, k] and up * resolution < openings._MAX_RUN_M:
            number[i, j, k] = openings._narrow_direction(is_free, i, j, k, up, most, resolution)
    return number


def test_cells_with_room_about_them_are_passed_over_and_no_other():
    world = room_with(0.6, 2.5, 0.9, 2.4, 0.4)
    field = field_of(world, half_extent=5.0, height=8.0, resolution=0.25)
    is_free = np.ascontiguousarray(field.distance_m > 0)
    found = narrow_cells(is_free, 0.25)
    assert (found >= 0).any()
    np.testing.assert_array_equal(found, looked_at_one_by_one(is_free, 0.25))


def test_lines_reach_as_far_as_steps_of_the_free_distance_lead():
    world = room_with(0.6, 1.5, 0.9, 2.4, 0.4)
    rng = np.random.default_rng(0)
    points, ways = rng.uniform((-4, -4, 0.2), (4, 4, 3.8), (40, 3)), rng.normal(size=(40, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    reach_m, is_going = np.zeros(40), np.ones(40, dtype=bool)
    for _ in range(openings._MARCH_STEPS):
        gap_m = world.signed_distance(points + reach_m[:, None] * ways)[0]
        is_going &= (gap_m >= openings._TOUCH_M) & (reach_m <= openings._MAX_RUN_M)
        reach_m += np.where(is_going, gap_m, 0.0)
    np.testing.assert_array_equal(reach_solids(points, ways, world.solids), reach_m)
    assert reach_m.max() > 1.0


def test_a_wall_without_an_opening_and_open_space_have_none():
    closed = room_with(0.6, 1.5, 0.0, 0.05, 0.0)
    assert not find_openings(field_of(closed, half_extent=7.0, height=5.0, resolution=0.25), closed)
    assert not find_openings(field_of(GROUND, half_extent=5.0, height=5.0), GROUND)


def test_what_fits_is_a_matter_of_the_narrower_side():
    door = Opening(center_enu_m=(0, 0, 1), normal_rad=0.0, width_m=0.9, height_m=2.0)
    assert door.fits(0.4)
    assert not door.fits(0.4, margin_m=0.1)
    hatch = Opening(center_enu_m=(0, 0, 1), normal_rad=0.0, width_m=3.0, height_m=0.7)
    assert not hatch.fits(0.4)
