"""Rays through the tree meet what MuJoCo's own rays meet, to the bit, and look at few geoms."""

import math

import mujoco
import numpy as np
import pytest

from aeroscene import load_scene
from flightsim.environment.movers import MovingObstacle
from flightsim.plant.rays import cast_rays, new_rays
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from flightsim.world.rays import RayTree
from tests.flightsim.handmade import empty_scene, solid

N_RAYS = 4_000
TILTED = (0.9, 0.1, -0.3, 0.3)
MESH = ((-1, -1, -1), (1, -1, -1), (0, 1, -1), (0, 0, 1))
SOLIDS = [
    solid("box", (0.0, 8.0, 1.0), (2.0, 1.0, 3.0), quat=TILTED),
    solid("cylinder", (4.0, 8.0, 1.0), (2.0, 2.0, 3.0), quat=TILTED),
    solid("ellipsoid", (8.0, 8.0, 1.0), (1.0, 2.0, 3.0), quat=TILTED),
    solid("mesh", (12.0, 8.0, 1.0), (2.0, 2.0, 2.0), vertices_m=MESH, quat=TILTED),
    solid("box", (4.0, 4.0, 6.0), (20.0, 20.0, 0.1), collides=False),
]
WALKERS = [
    MovingObstacle(kind=kind, path_enu_m=((x, 3.0, 0.0), (x, 9.0, 0.0)), speed_mps=1.0)
    for kind, x in (("person", 3.0), ("car", 6.0))
]


def handmade():
    return build_world(empty_scene(), AIRFRAMES["iris"], extra=SOLIDS, traffic=WALKERS)


WORLDS = {
    "handmade": handmade,
    "scene 28": lambda: build_world(load_scene("28"), AIRFRAMES["iris"]),
    "indoors": lambda: build_world(load_scene("corpus:2"), AIRFRAMES["hummingbird"]),
    "empty": lambda: build_world(empty_scene(), AIRFRAMES["iris"]),
}


def random_rays(world, n):
    """Rays in all directions, some along the axes, from everywhere, also from inside of solids."""
    rng = np.random.default_rng(3)
    low, high = np.array([*world.scene.extent_min_enu_m]), np.array([*world.scene.extent_max_enu_m])
    rays = np.empty((n, 6))
    rays[:, :3] = rng.uniform(low - 1.0, high + 1.0, (n, 3))
    rays[:, 3:] = rng.standard_normal((n, 3))
    along = rng.integers(0, 3, n // 4)
    rays[: n // 4, 3:] = np.eye(3)[along] * rng.choice([-1.0, 1.0], (n // 4, 1))
    # From the middle of geoms, and exactly from the faces of their boxes.
    geoms = rng.choice(np.flatnonzero(world.model.geom_bodyid == 0), n // 4)
    rays[-len(geoms) :, :3] = world.model.geom_pos[geoms]
    rays[-len(geoms) // 2 :, 2] += world.model.geom_size[geoms, 2][-len(geoms) // 2 :]
    return rays


def by_mujoco(world, data, rays, excluded):
    geom = np.zeros(1, np.int32)
    hits_m = np.array(
        [
            mujoco.mj_ray(world.model, data, ray[:3], ray[3:], None, 1, excluded, geom)
            for ray in rays
        ]
    )
    return np.where(hits_m < 0.0, np.inf, hits_m)


@pytest.mark.parametrize("name", WORLDS)
@pytest.mark.parametrize("sees_vehicle", [False, True])
def test_rays_meet_what_mujocos_own_meet_to_the_bit(name, sees_vehicle):
    world = WORLDS[name]()
    data = world.new_data()
    data.qpos[:3] = (5.0, 6.0, 2.0)
    mujoco.mj_forward(world.model, data)
    excluded = -1 if sees_vehicle else world.vehicle_body_id
    rays, found_m = random_rays(world, N_RAYS), np.empty(N_RAYS)
    cast_rays(new_rays(world, data, world.wide_rays), rays, excluded, found_m)
    np.testing.assert_array_equal(found_m, by_mujoco(world, data, rays, excluded))
    assert 0.2 < np.isfinite(found_m).mean() < 1.0


def test_what_moves_is_met_where_it_is_now():
    world = handmade()
    data = world.new_data()
    rays = new_rays(world, data)
    down = np.array([[3.0, 5.0, 5.0, 0.0, 0.0, -1.0]])
    found_m = np.empty(1)
    heights_m = []
    for y in (5.0, 7.0):
        data.mocap_pos[0] = (3.0, y, 0.0)
        mujoco.mj_forward(world.model, data)
        cast_rays(rays, down, world.vehicle_body_id, found_m)
        heights_m.append(5.0 - found_m[0])
    assert heights_m[0] > 1.0
    assert heights_m[1] == 0.0


def test_boxes_hold_what_is_below_them_and_every_geom_is_in_one_leaf():
    tree = RayTree.from_model(handmade().model)
    n = len(tree.leaf_geoms)
    assert n & (n - 1) == 0
    assert sorted(tree.leaf_geoms[tree.leaf_geoms >= 0].tolist()) == [1, 2, 3, 4, 5]
    assert tree.endless_geoms.tolist() == [0]
    for node in range(1, n):
        for child in (2 * node, 2 * node + 1):
            assert np.all(tree.boxes_enu_m[node, :3] <= tree.boxes_enu_m[child, :3])
            assert np.all(tree.boxes_enu_m[node, 3:] >= tree.boxes_enu_m[child, 3:])


def test_invisible_geoms_are_in_no_tree_and_height_fields_are():
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(1, 1, 1), rgba=(1, 1, 1, 0))
    assert RayTree.from_model(spec.compile()).leaf_geoms.tolist() == [-1]
    spec.add_hfield(name="hill", nrow=2, ncol=2, size=(1, 1, 1, 1), userdata=[0, 1, 0, 1])
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname="hill")
    tree = RayTree.from_model(spec.compile())
    assert tree.leaf_geoms.tolist() == [1]
    assert tree.field_cosines == pytest.approx([math.sqrt(0.8)], abs=1e-3)
