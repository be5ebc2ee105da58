"""Exports of a scene with a relief: the ground is in each, and a vehicle stands on it."""

import mujoco
import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom, UsdPhysics, UsdValidation

from flightsim.export.glb import write_glb
from flightsim.export.mjcf import write_mjcf
from flightsim.export.usd import write_usd
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import hills, relief_scene


@pytest.fixture(scope="module")
def world():
    return build_world(relief_scene(hills()), airframe_by_name("iris"))


def assert_on(relief, points):
    np.testing.assert_allclose(points[:, 2], relief.height_m(*points[:, :2].T), atol=1e-3)


def test_mjcf_has_the_height_fields_and_the_vehicle_stands_on_them(world, tmp_path):
    model = mujoco.MjModel.from_xml_path(str(write_mjcf(world, tmp_path)))
    np.testing.assert_allclose(model.hfield_data, world.model.hfield_data, atol=1e-6)
    np.testing.assert_allclose(model.hfield_size, world.model.hfield_size, rtol=1e-4)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    for _ in range(500):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos[:3], world.rest_qpos[:3], atol=2e-3)


def test_glb_has_the_grid_as_a_node(world, tmp_path):
    scene = trimesh.load_scene(write_glb(world, tmp_path), process=False)
    matrix, name = scene.graph.get("ground")
    points = trimesh.transform_points(scene.geometry[name].vertices, matrix)
    enu = np.column_stack([points[:, 0], -points[:, 2], points[:, 1]])
    assert len(enu) == world.scene.relief.heights_m.size
    assert_on(world.scene.relief, enu)


def test_usd_has_the_ground_as_a_collider_up_to_beyond_the_grid(world, tmp_path):
    stage = Usd.Stage.Open(str(write_usd(world, tmp_path)))
    prim = stage.GetPrimAtPath("/World/Ground/look")
    assert prim.HasAPI(UsdPhysics.CollisionAPI)
    points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get())
    assert np.abs(points[:, :2]).max() > 500.0
    assert_on(world.scene.relief, points)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert not UsdValidation.ValidationContext(validators).Validate(stage)
