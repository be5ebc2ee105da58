"""Height fields: rays meet the true surface, and free flight ends before anything can touch."""

import math

import mujoco
import numpy as np
import pytest

from flightsim.plant import Plant, PlantCfg
from flightsim.plant.clearance import clearance_m
from flightsim.plant.free_flight import new_free_flight
from flightsim.plant.rays import cast_rays, new_rays
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import hills, incline, relief_scene

IRIS = airframe_by_name("iris")
N_RAYS = 3_000


def cast(world, rays):
    data, found_m = world.new_data(), np.empty(len(rays))
    cast_rays(new_rays(world, data), rays, world.vehicle_body_id, found_m)
    return found_m


def rays_from_above(relief, n=N_RAYS):
    """Rays in all directions from above the ground, also from beyond its grid."""
    rng, rays = np.random.default_rng(5), np.empty((n, 6))
    rays[:, :2] = rng.uniform(-70.0, 70.0, (n, 2))
    rays[:, 2] = relief.height_m(rays[:, 0], rays[:, 1]) + rng.uniform(0.01, 30.0, n)
    rays[:, 3:] = rng.standard_normal((n, 3))
    return rays


def test_rays_meet_the_surface_that_mujocos_own_meet():
    relief = hills()
    world, rays = build_world(relief_scene(relief), IRIS), rays_from_above(relief)
    data, geom = world.new_data(), np.zeros(1, np.int32)
    by_mujoco = np.array(
        [
            mujoco.mj_ray(world.model, data, ray[:3], ray[3:], None, 1, world.vehicle_body_id, geom)
            for ray in rays
        ]
    )
    found_m = cast(world, rays)
    is_hit = by_mujoco >= 0.0
    assert is_hit.mean() > 0.4
    np.testing.assert_array_equal(np.isfinite(found_m), is_hit)
    np.testing.assert_allclose(found_m[is_hit], by_mujoco[is_hit], atol=1e-5)


def test_rays_down_measure_the_height_over_nodes_edges_and_beyond_the_grid():
    relief = hills()
    line = np.arange(-50.0, 50.1, 0.5)
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    rays = np.zeros((len(x), 6))
    rays[:, 0], rays[:, 1], rays[:, 2], rays[:, 5] = x, y, 30.0, -1.0
    found_m = cast(build_world(relief_scene(relief), IRIS), rays)
    np.testing.assert_allclose(found_m, 30.0 - relief.height_m(x, y), atol=1e-5)


@pytest.mark.parametrize(("east", "north"), [(0.0, 0.0), (0.3, -0.2), (-0.5, 0.4)])
def test_a_ray_meets_an_inclined_plane_where_geometry_says(east, north):
    world = build_world(relief_scene(incline(east / 2, north / 2)))
    rng = np.random.default_rng(1)
    rays = np.zeros((500, 6))
    rays[:, :2] = rng.uniform(-15.0, 15.0, (500, 2))
    rays[:, 2] = rays[:, :2] @ (east / 2, north / 2) + rng.uniform(1.0, 20.0, 500)
    rays[:, 3:] = rng.normal((0.0, 0.0, -2.0), 0.4, (500, 3))
    rising = rays[:, 5] - rays[:, 3:5] @ (east / 2, north / 2)
    above = rays[:, 2] - rays[:, :2] @ (east / 2, north / 2)
    expected = -above / rising
    hit = rays[:, :2] + expected[:, None] * rays[:, 3:5]
    is_on_grid = (rising < 0.0) & (np.abs(hit) < 40.0).all(axis=1)
    assert is_on_grid.mean() > 0.9
    np.testing.assert_allclose(cast(world, rays)[is_on_grid], expected[is_on_grid], rtol=2e-6)


def test_the_clearance_above_a_relief_is_never_more_than_the_distance():
    relief = hills()
    world = build_world(relief_scene(relief), IRIS)
    data = world.new_data()
    free, rays = new_free_flight(world, data, is_on=True)[0], new_rays(world, data)[0]
    assert free["is_on"] == 1
    line = np.arange(-90.0, 90.0, 0.2)
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    from scipy.spatial import cKDTree

    surface = cKDTree(np.column_stack([x, y, relief.height_m(x, y)]))
    points = rays_from_above(relief, 1_000)[:, :3]
    found_m = np.array([clearance_m(rays, free, point, 50.0) for point in points])
    nearest_m = surface.query(points)[0]
    assert (found_m <= nearest_m + 1e-6).all()
    # It is of use too: most of the distance is known.
    assert np.median(found_m / nearest_m) > 0.7


def flown(world, start, velocity, *, free_flight, n_ticks=150):
    """Motion of a vehicle without power, and the ticks in which it touches something."""
    plant = Plant(world, PlantCfg(seed=0, state="truth", free_flight=free_flight))
    plant.data.qpos[:3], plant.data.qvel[:3] = start, velocity
    rows = []
    for _ in range(n_ticks):
        plant.advance()
        rows.append(plant.history.copy())
    return np.concatenate(rows), plant.n_free_steps


@pytest.mark.parametrize("heading_deg", [0.0, 130.0, 250.0])
def test_at_20_mps_over_hills_both_ways_fly_alike_and_touch_first_in_the_same_step(heading_deg):
    relief = hills(height_m=6.0)
    world = build_world(relief_scene(relief), IRIS)
    turn = math.radians(heading_deg)
    along = np.array([math.cos(turn), math.sin(turn)])
    x, y = -38.0 * along
    start = (x, y, float(relief.height_m(x, y)) + 7.0)
    velocity = (*(20.0 * along), 1.0)
    (free, n_free), (engine, none) = (
        flown(world, start, velocity, free_flight=is_free) for is_free in (True, False)
    )
    assert none == 0
    touching = np.flatnonzero(engine["is_touching"])
    first = int(touching[0])
    assert np.flatnonzero(free["is_touching"])[0] == first
    assert n_free > 100
    for column in ("position_true_enu_m", "velocity_true_enu_mps", "angular_rate_true_flu_radps"):
        assert np.abs(free[column][:first] - engine[column][:first]).max() < 1e-9


def test_low_over_a_crest_the_engine_takes_the_steps():
    world = build_world(relief_scene(incline(0.25, 0.0)), IRIS)
    low = flown(world, (0.0, 0.0, 0.35), (0.0, 0.0, 0.0), free_flight=True, n_ticks=2)[1]
    high = flown(world, (0.0, 0.0, 15.0), (0.0, 0.0, 0.0), free_flight=True, n_ticks=2)[1]
    assert (low, high) == (0, 20)
