"""Corridors hold the way they were made for and keep their distance from every obstacle."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from scipy.optimize import linprog

from autonomy.planning import CertificateError, Obstacles
from autonomy.planning.corridor import MAX_PLANES, build_corridor, straighten
from tests.autonomy.planning_worlds import random_boxes, seeds

BOUNDS = (np.full(3, -12.0), np.full(3, 12.0))


def corridor_of(points, obstacles, **options):
    defaults = {"wanted_m": 0.6, "least_m": 0.2, "max_leg_m": 100.0}
    return build_corridor(np.asarray(points, float), obstacles, BOUNDS, **(defaults | options))


def clearance(a, b, obstacles):
    along = a + np.linspace(0, 1, 200)[:, None] * (np.asarray(b) - a)
    return obstacles.signed_distance(along)[0].min()


@given(seeds)
def test_every_point_of_a_polytope_is_far_enough_from_every_obstacle(seed):
    rng = np.random.default_rng(seed)
    obstacles = random_boxes(rng, 8)
    a, b = rng.uniform(-9, 9, (2, 3))
    offered = clearance(a, b, obstacles)
    assume(offered > 0.25)
    corridor = corridor_of([a, b], obstacles)
    kept = min(0.6, (offered + 0.2) / 2)
    points = rng.uniform(-12, 12, (4000, 3))
    planes = corridor.planes[0]
    inside = points[np.all(points @ planes[:, :3].T <= planes[:, 3], axis=1)]
    if len(inside):
        assert obstacles.signed_distance(inside)[0].min() >= kept - 1e-3


@given(seeds)
def test_a_polytope_holds_its_leg_with_room_to_spare(seed):
    rng = np.random.default_rng(seed)
    obstacles = random_boxes(rng, 8)
    a, b = rng.uniform(-9, 9, (2, 3))
    assume(clearance(a, b, obstacles) > 0.3)
    planes = corridor_of([a, b], obstacles).planes[0]
    along = a + np.linspace(0, 1, 50)[:, None] * (b - a)
    assert np.all(along @ planes[:, :3].T <= planes[:, 3] - 0.02)


@given(seeds)
@settings(max_examples=15)
def test_no_plane_of_a_polytope_is_idle(seed):
    rng = np.random.default_rng(seed)
    obstacles = random_boxes(rng, 12)
    a, b = rng.uniform(-9, 9, (2, 3))
    assume(clearance(a, b, obstacles) > 0.3)
    planes = corridor_of([a, b], obstacles).planes[0]
    used = planes[np.any(planes[:, :3] != 0, axis=1)]
    for k, plane in enumerate(used):
        others = np.delete(used, k, axis=0)
        beyond = linprog(-plane[:3], others[:, :3], others[:, 3], bounds=(-100.0, 100.0))
        assert -beyond.fun > plane[3] - 1e-5


@given(seeds)
def test_straightening_keeps_the_ends_and_costs_no_clearance(seed):
    rng = np.random.default_rng(seed)
    obstacles = random_boxes(rng, 6)
    path = np.cumsum(rng.normal(0, 0.7, (40, 3)), axis=0)
    smallest = obstacles.signed_distance(path)[0].min()
    assume(smallest > 0.05)
    # Points are looked at here, so the path's own segments have to be no worse.
    assume(all(clearance(a, b, obstacles) > 0.05 for a, b in pairwise(path)))
    straight = straighten(path, obstacles, enough_m=1.0)
    np.testing.assert_array_equal(straight[[0, -1]], path[[0, -1]])
    kept = [np.flatnonzero((path == point).all(axis=1))[0] for point in straight]
    for (a, i), (b, j) in pairwise(zip(straight, kept, strict=True)):
        if j > i + 1:
            before = min(1.0, obstacles.signed_distance(path[i : j + 1])[0].min())
            assert clearance(a, b, obstacles) >= before - 1e-5


def test_open_space_needs_one_leg_and_six_planes():
    far = random_boxes(np.random.default_rng(0), 1, extent=0.1)
    path = np.column_stack(
        [np.linspace(-8, 8, 20), np.full(20, 8.0), 8 + np.sin(np.arange(20)) / 9]
    )
    straight = straighten(path, far, enough_m=1.0)
    assert len(straight) == 2
    planes = corridor_of(straight, far).planes[0]
    assert np.count_nonzero(np.abs(planes[:, :3]).sum(axis=1)) <= 7


def test_long_legs_are_flown_in_several_pieces():
    nothing = random_boxes(np.random.default_rng(0), 0)
    corridor = corridor_of([[0, 0, 0], [9, 0, 0], [9, 2, 0]], nothing, max_leg_m=4.0)
    assert len(corridor) == 4
    np.testing.assert_allclose(corridor.gates_enu_m[:, 0], [0, 3, 6, 9, 9])
    np.testing.assert_array_equal(corridor.planes[0], corridor.planes[2])


def test_a_leg_too_close_to_an_obstacle_is_refused_with_its_distance():
    box = random_boxes(np.random.default_rng(0), 1, extent=0.1)
    with pytest.raises(CertificateError, match=r"passes -?\d\.\d\d m from an obstacle"):
        corridor_of([[-8, 0, 0], [8, 0, 0]], box)


def test_clutter_beyond_the_number_of_planes_shrinks_the_polytope():
    rng = np.random.default_rng(0)
    angle = np.arange(60) * 2.4
    pebbles = Obstacles.boxes(
        np.column_stack([np.linspace(-4, 4, 60), 2.2 * np.cos(angle), 2.2 * np.sin(angle)]),
        np.tile([1.0, 0.0, 0.0, 0.0], (60, 1)),
        np.full((60, 3), 0.1),
    )
    planes = corridor_of([[-4, 0, 0], [4, 0, 0]], pebbles).planes[0]
    assert len(planes) == MAX_PLANES
    points = rng.uniform(-12, 12, (20000, 3))
    inside = points[np.all(points @ planes[:, :3].T <= planes[:, 3], axis=1)]
    assert len(inside)
    assert pebbles.signed_distance(inside)[0].min() >= 0.6 - 1e-6
