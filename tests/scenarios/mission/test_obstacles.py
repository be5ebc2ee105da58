"""What the planner keeps away from is what the physics collides with."""

import math

import mujoco
import numpy as np
import pytest

from aeroscene.solids.freespace import build_distance_field
from aeroscene.solids.shapes import scene_primitives
from aeroscene.sources import load_scene
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import NEIGHBOUR_ID, build_world
from scenarios.mission.obstacles import distance_field, scene_obstacles
from tests.flightsim.handmade import hills, relief_scene
from tests.scenarios.landing_scenes import yard


def hits(scene, n_rays):
    """Points in the air, directions from there, and how far each gets in the physics."""
    world = build_world(scene, AIRFRAMES["iris"])
    data = world.new_data()
    mujoco.mj_forward(world.model, data)
    rng = np.random.default_rng(0)
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    starts = rng.uniform(low + [0, 0, 0.1], high, (n_rays, 3))
    towards = rng.normal(size=(n_rays, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    model, geom = world.model, np.zeros(1, np.int32)
    # Only what collides counts: paint and panes belong to another group.
    solid_groups = {int(model.geom_group[i]) for i in range(model.ngeom) if model.geom_contype[i]}
    groups = np.array([g in solid_groups for g in range(6)], np.uint8)

    def reach_m(point, way):
        hit_m = mujoco.mj_ray(model, data, point, way, groups, 1, world.vehicle_body_id, geom)
        return math.nan if world.geom_object_id[geom[0]] == NEIGHBOUR_ID else hit_m

    reach = np.array([reach_m(*ray) for ray in zip(starts, towards, strict=True)])
    # The planner knows the site, and nothing of what stands around it.
    is_of_site = ~np.isnan(reach)
    return starts[is_of_site], towards[is_of_site], reach[is_of_site]


@pytest.mark.parametrize("scene", ["yard", "28"])
def test_rays_of_the_physics_end_where_the_planners_distance_is_zero(scene):
    scene = yard(has_crates_on_top=True) if scene == "yard" else load_scene(scene)
    obstacles = scene_obstacles(scene, scene_primitives(scene))
    starts, towards, reach = hits(scene, 400)
    outside = obstacles.signed_distance(starts)[0] > 0.05
    starts, towards, reach = starts[outside], towards[outside], reach[outside]
    assert np.count_nonzero((reach > 0) & (reach < 20.0)) > 100
    for p, v, r in zip(starts, towards, reach, strict=True):
        free_m = r if r > 0 else 100.0
        along = p + v * (np.linspace(0, 0.999, 60) * free_m)[:, None]
        assert obstacles.signed_distance(along)[0].min() > -5e-3
        if r > 0:
            end = obstacles.signed_distance((p + v * r)[None])[0][0]
            is_far = np.abs(p + v * r).max() > 50.0
            assert is_far or end == pytest.approx(0.0, abs=5e-3)


def test_cells_never_promise_more_room_than_there_is():
    scene = load_scene("corpus:42")
    primitives = scene_primitives(scene)
    field = distance_field(build_distance_field(scene, 0.25, primitives))
    obstacles = scene_obstacles(scene, primitives)
    cells = np.random.default_rng(0).integers(0, field.distance_m.shape, (4000, 3))
    cells = cells[cells[:, 2] > 0]
    exact, _ = obstacles.signed_distance(field.centres(cells))
    promised = field.distance_m[tuple(cells.T)]
    assert np.all(promised <= np.maximum(exact, 0.0) + 1e-3)


def test_obstacles_of_a_relief_hold_all_of_the_ground_and_little_air():
    scene = relief_scene(hills())
    obstacles = scene_obstacles(scene, ())
    rng = np.random.default_rng(6)
    x, y = rng.uniform(-39.0, 39.0, (2, 1_000))
    height_m = scene.relief.height_m(x, y)

    def distances_m(above_m):
        return obstacles.signed_distance(np.column_stack([x, y, height_m + above_m]))[0]

    assert distances_m(-0.001).max() <= 0.0
    assert distances_m(0.05).min() > 0.0
    # No bound is above the height over the ground, and few are far below.
    assert (distances_m(2.0) <= 2.0 + 1e-9).all()
    assert np.median(distances_m(2.0)) > 1.5
