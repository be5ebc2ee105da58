import mujoco
import numpy as np
import pytest

from flightsim.export.mjcf import write_mjcf
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import RAY_GROUPS, empty_scene

SOLIDS_ONLY = np.array([0, 0, 0, 1, 0, 0], dtype=np.uint8)


@pytest.fixture(scope="module")
def reopened(mjcf_path):
    return mujoco.MjModel.from_xml_path(str(mjcf_path))


def at_start(model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_forward(model, data)
    return data


def test_every_solid_comes_back_where_it_was_under_its_objects_name(world, reopened):
    data = at_start(reopened)
    count = {}
    for solid in (solid for solid in world.solids if solid.collides):
        label = f"{world.scene.object_by_id[solid.object_id].category}_{solid.object_id}"
        geom = reopened.geom(f"{label}_{count.get(label, 0)}")
        count[label] = count.get(label, 0) + 1
        if solid.kind != "mesh":  # MuJoCo moves a mesh to its own centre.
            assert data.geom_xpos[geom.id] == pytest.approx(solid.position_enu_m, abs=1e-4)
        assert geom.contype[0] == 1
    assert sum(count.values()) > 150


def test_rays_meet_the_same_surfaces(world, reopened):
    ours, theirs = world.new_data(), at_start(reopened)
    low, high = world.scene.extent_min_enu_m, world.scene.extent_max_enu_m
    rng = np.random.default_rng(3)
    down, geom = np.array([0.1, 0.05, -1.0]), np.zeros(1, dtype=np.int32)
    n_hits = 0
    for x, y in rng.uniform(low[:2], high[:2], (300, 2)):
        eye = np.array([x, y, high[2]])
        ray = (eye, down, RAY_GROUPS, 1, world.vehicle_body_id, geom)
        expected_m = mujoco.mj_ray(world.model, ours, *ray)
        ray = (eye, down, SOLIDS_ONLY, 1, reopened.body("vehicle").id, geom)
        found_m = mujoco.mj_ray(reopened, theirs, *ray)
        if found_m < 0:
            continue  # The ground's plane, which is among the looks.
        n_hits += 1
        assert found_m == pytest.approx(expected_m, abs=2e-3)
    assert n_hits > 100


def test_the_vehicle_stands_at_the_start_and_stays(world, reopened):
    data = at_start(reopened)
    for _ in range(500):
        mujoco.mj_step(reopened, data)
    assert data.qpos[:3] == pytest.approx(world.rest_qpos[:3], abs=2e-3)
    assert sum(reopened.body_mass) == pytest.approx(world.airframe.quadrotor.mass_kg)


def test_a_vehicle_falls_onto_the_exported_ground(tmp_path):
    world = build_world(empty_scene(), AIRFRAMES["hummingbird"])
    model = mujoco.MjModel.from_xml_path(str(write_mjcf(world, tmp_path)))
    data = at_start(model)
    data.qpos[2] += 0.3
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert data.qpos[2] == pytest.approx(world.rest_qpos[2], abs=5e-3)


def test_areas_are_sites(world, reopened):
    data = at_start(reopened)
    assert reopened.nsite == len(world.scene.interaction_areas)
    for area in world.scene.interaction_areas:
        site = reopened.site(f"{area.kind}_{area.id}_{area.drone_class}")
        assert data.site_xpos[site.id] == pytest.approx(area.centroid, abs=1e-4)
        assert site.size[0] == pytest.approx(area.radius, abs=1e-4)
        slope_rad = np.arccos(min(1.0, data.site_xmat[site.id][8]))
        assert slope_rad == pytest.approx(area.slope_rad, abs=2e-3)


def test_skins_are_textured_and_touch_nothing(reopened):
    is_skin = (reopened.geom_group == 0) & (reopened.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    assert is_skin.sum() > 20
    assert not reopened.geom_contype[is_skin].any()
    materials = reopened.geom_matid[is_skin]
    role = mujoco.mjtTextureRole.mjTEXROLE_RGB
    assert (reopened.mat_texid[materials, role] >= 0).sum() > 10
