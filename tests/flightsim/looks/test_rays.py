"""Rays at triangles: packets of any number of rays meet what one ray meets."""

import numpy as np
import pytest

from flightsim.looks.rays import NOTHING, RayScene

TRIANGLES = np.random.default_rng(0).normal(size=(300, 3, 3)) * 0.4
TRIANGLES += np.random.default_rng(1).uniform(-4.0, 4.0, (300, 1, 3))


def by_hand(origin, direction):
    """Nearest triangle along a ray, its distance and the weights of its corners."""
    first, second, third = TRIANGLES.transpose(1, 0, 2)
    edges = np.stack([second - first, third - first, -np.broadcast_to(direction, first.shape)], 2)
    u, v, distance = np.linalg.solve(edges, (origin - first)[..., None])[..., 0].T
    is_met = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance >= 0.0)
    if not is_met.any():
        return NOTHING, np.inf, 0.0, 0.0
    nearest = np.where(is_met, distance, np.inf).argmin()
    return nearest, distance[nearest], u[nearest], v[nearest]


@pytest.mark.parametrize("n", [1, 15, 16, 17, 500])
def test_packets_of_rays_meet_what_each_ray_meets(n):
    rng = np.random.default_rng(n)
    origins, directions = rng.uniform(-5.0, 5.0, (n, 3)), rng.normal(size=(n, 3))
    scene = RayScene(TRIANGLES)
    hits = scene.first_hits(origins, directions)
    wanted = [by_hand(*ray) for ray in zip(origins, directions, strict=True)]
    triangle, *numbers = map(np.array, zip(*wanted, strict=True))
    np.testing.assert_array_equal(hits.triangle, triangle)
    is_met = triangle != NOTHING
    assert np.isinf(hits.distance[~is_met]).all()
    for found, exact in zip((hits.distance, hits.u, hits.v), numbers, strict=True):
        np.testing.assert_allclose(found[is_met], exact[is_met], atol=1e-4)
    np.testing.assert_array_equal(scene.is_hidden(origins, directions), is_met)


def test_rays_from_one_point_need_it_once():
    eye, directions = np.array([0.3, 0.1, -5.0]), np.random.default_rng(3).normal(size=(333, 3))
    scene = RayScene(TRIANGLES)
    once, each = (
        scene.first_hits(origins, directions) for origins in (eye, np.tile(eye, (333, 1)))
    )
    assert (once.triangle != NOTHING).sum() > 10
    for name in ("triangle", "distance"):
        np.testing.assert_array_equal(getattr(once, name), getattr(each, name))
    is_met = once.triangle != NOTHING
    np.testing.assert_array_equal(scene.is_hidden(eye, directions), is_met)


def test_nothing_is_met_where_nothing_is():
    scene, directions = RayScene(np.zeros((0, 3, 3))), np.ones((4, 3))
    assert scene.first_hits(np.zeros(3), directions).triangle.tolist() == [NOTHING] * 4
    assert not scene.is_hidden(np.zeros(3), directions).any()
