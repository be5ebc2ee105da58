"""The index of solids: the same distances as without it, as far as it reaches."""

import numpy as np
from hypothesis import given, settings

from autonomy.perception.solid_index import index_solids, nearest_plane
from autonomy.planning import Obstacles
from tests.autonomy.planning_worlds import random_boxes, seeds, town

REACH_M = 1.0


def distances(points, index):
    return np.array([nearest_plane(*point, index)[0] for point in points])


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_distances_are_exact_up_to_the_reach(seed):
    rng = np.random.default_rng(seed)
    obstacles = random_boxes(rng, 12)
    index = index_solids(obstacles, reach_m=REACH_M)
    points = rng.uniform(-13, 13, (200, 3))  # some lie outside the grid
    exact = np.minimum(obstacles.signed_distance(points)[0], REACH_M)
    np.testing.assert_allclose(distances(points, index), exact, atol=1e-9)


@settings(max_examples=10, deadline=None)
@given(seeds)
def test_normals_lead_away_from_the_nearest_surface(seed):
    rng = np.random.default_rng(seed)
    obstacles = town(rng)
    index = index_solids(obstacles, reach_m=REACH_M)
    for point in rng.uniform((-15, -15, 0.05), (15, 15, 9), (100, 3)):
        d, *normal, _ = nearest_plane(*point, index)
        if 0.0 < d < REACH_M:
            on_surface = point - d * np.array(normal)
            assert abs(obstacles.signed_distance(on_surface[None])[0][0]) < 1e-6


def test_a_wide_world_gets_wider_cells_and_the_same_distances():
    rng = np.random.default_rng(3)
    obstacles = random_boxes(rng, 30, extent=120.0)
    index = index_solids(obstacles, reach_m=REACH_M)
    assert index.cell > 1.0
    points = obstacles.center_enu_m + rng.normal(0.0, 2.0, obstacles.center_enu_m.shape)
    exact = np.minimum(obstacles.signed_distance(points)[0], REACH_M)
    np.testing.assert_allclose(distances(points, index), exact, atol=1e-9)


def test_without_solids_all_is_far():
    none = Obstacles.boxes(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)))
    index = index_solids(none, reach_m=REACH_M)
    assert distances([[0.5, 0.5, 0.5], [40.0, 0.0, 0.0]], index).tolist() == [1.0, 1.0]
