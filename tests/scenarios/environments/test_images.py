"""Images of environments: depth and segments of what the physics has."""

import math

import mujoco
import numpy as np
import pytest

from aeroscene.sources import load_scene
from flightsim.cameras.segmentation import DRONE_CLASS
from flightsim.cameras.view import PoseCopy
from flightsim.environment.movers import MovingObstacle
from flightsim.plant.rays import new_rays
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import FIRST_MATE_ID, FIRST_MOVER_ID, VEHICLE_ID, build_world
from scenarios.environments import EnvironmentInputError, ObservationCfg
from scenarios.environments.interface.images import FAR_M, CameraImages
from scenarios.environments.interface.observations import rotation_matrices
from tests.flightsim.handmade import RAY_GROUPS, empty_scene, solid


@pytest.mark.parametrize("camera", ["forward", "down"])
def test_depth_is_the_distance_of_what_the_physics_has(camera):
    turned = (math.cos(0.3), 0.0, 0.0, math.sin(0.3))
    wall = solid("box", (4.0, 0.5, 1.0), (1.0, 2.0, 2.0), quat=turned)
    world = build_world(empty_scene(), airframe_by_name("iris"), extra=[wall])
    data = world.new_data()
    data.qpos[:7] = (0.5, 0.2, 1.5, *turned)
    poses = PoseCopy(world.model)
    poses.update(data)
    mujoco.mj_forward(world.model, data)
    view = poses.viewpoint(camera)
    images = CameraImages([world], (17, 13), camera).render(
        data.qpos[None, :3], rotation_matrices(data.qpos[None, 3:7])
    )
    (image,) = images["depth"]
    geom = np.zeros(1, dtype=np.int32)
    for pixel in np.ndindex(13, 17):
        ray = view.rays_enu(17, 13)[pixel].astype(float)
        args = (view.position_enu_m, ray, RAY_GROUPS, 1, world.vehicle_body_id, geom)
        wanted_m = mujoco.mj_ray(world.model, data, *args)
        wanted_m = FAR_M if wanted_m < 0.0 else min(wanted_m, FAR_M)
        assert image[pixel] == pytest.approx(wanted_m, abs=2e-3)
    assert image.min() < 3.5


def test_segments_are_what_the_rays_meet_whoever_casts_them():
    world = build_world(load_scene("42"), airframe_by_name("iris"))
    data = world.new_data()
    data.qpos[2] += 6.0
    mujoco.mj_forward(world.model, data)
    turns = np.linspace(0.0, 6.0, 5)
    quats = np.array([(math.cos(a / 2), 0.0, 0.0, math.sin(a / 2)) for a in turns])
    poses = np.repeat(data.qpos[None, :3], 5, axis=0), rotation_matrices(quats)
    segments, images = ("classes", "objects"), []
    for n_threads in (1, 3):
        cameras = CameraImages([world] * 5, (16, 12), "forward", segments, n_threads)
        images.append(cameras.render(*poses))
        cameras.close()
    alone, together = images
    for name in ("depth", *segments):
        np.testing.assert_array_equal(alone[name], together[name])
    plain = CameraImages([world] * 5, (16, 12), "forward", n_threads=1).render(*poses)
    np.testing.assert_array_equal(plain["depth"], alone["depth"])
    objects, classes = alone["objects"], alone["classes"]
    seen = set(np.unique(objects[objects >= 0]).tolist())
    assert len(seen) > 5
    by_id = world.scene.object_by_id
    assert all(np.all(classes[objects == i] == by_id[i].category_id) for i in seen)
    mount = world.airframe.cameras[0]
    geom, n_alike = np.zeros(1, dtype=np.int32), 0
    eye, turn = data.qpos[:3] + mount.position_flu_m, mount.rotation_flu_from_optical
    focal_px = 6.0 / math.tan(mount.vertical_fov_rad / 2)
    touchable = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8)
    for v, u in np.ndindex(12, 16):
        ray = turn @ ((u - 7.5) / focal_px, (v - 5.5) / focal_px, 1.0)
        args = (eye, ray, touchable, 1, world.vehicle_body_id, geom)
        is_met = mujoco.mj_ray(world.model, data, *args) >= 0.0
        wanted = world.geom_object_id[geom[0]] if is_met else -3
        n_alike += objects[0, v, u] == wanted
    assert n_alike > 0.97 * 12 * 16  # curved solids have facets


def test_what_moves_is_where_the_physics_has_it_and_oneself_is_unseen():
    path_enu_m = ((4.0, -0.7, 0.0), (9.0, -0.7, 0.0))
    person = MovingObstacle(kind="person", path_enu_m=path_enu_m, speed_mps=1.0)
    airframes = [airframe_by_name(name) for name in ("iris", "hummingbird")]
    worlds = build_world(empty_scene(), *airframes, traffic=[person]).views
    model, data = worlds[0].model, worlds[0].new_data()
    turned = (math.cos(0.1), 0.0, 0.0, math.sin(0.1))
    poses = ((0.0, 0.0, 1.5), turned), ((1.5, 0.4, 1.4), (math.cos(1.4), 0.0, 0.0, math.sin(1.4)))
    for world, (position, quat) in zip(worlds, poses, strict=True):
        data.qpos[world.qpos_address :][:7] = [*position, *quat]
    mujoco.mj_forward(model, data)
    rays = np.concatenate([new_rays(world, data) for world in worlds])
    size_px, segments = (48, 36), ("classes", "objects")
    cameras = CameraImages([*worlds], size_px, "forward", segments, n_threads=1, rays=rays)
    images = cameras.render(
        np.array([position for position, _ in poses]),
        rotation_matrices(np.array([quat for _, quat in poses])),
    )
    poser, geom = PoseCopy(model), np.zeros(1, dtype=np.int32)
    poser.update(data)
    for i, world in enumerate(worlds):
        view = poser.viewpoint(world.camera_name("forward"))
        for pixel in np.ndindex(36, 48):
            ray = view.rays_enu(*size_px)[pixel].astype(float)
            args = (view.position_enu_m, ray, None, 1, world.vehicle_body_id, geom)
            met_m = mujoco.mj_ray(model, data, *args)
            wanted_m = FAR_M if met_m < 0.0 else min(met_m, FAR_M)
            assert images["depth"][i][pixel] == pytest.approx(wanted_m, abs=2e-3)
            wanted = world.geom_object_id[geom[0]] if met_m >= 0.0 else -3
            assert images["objects"][i][pixel] == wanted
        mate = FIRST_MATE_ID - 1 + i
        is_mate, is_person = images["objects"][i] == mate, images["objects"][i] == FIRST_MOVER_ID
        assert is_mate.sum() > 20
        assert set(images["classes"][i][is_mate].tolist()) == {DRONE_CLASS}
        assert (is_person.sum() > 20) == (i == 0)
        assert not (images["objects"][i] == VEHICLE_ID).any()


def test_segments_need_a_depth_for_their_size():
    with pytest.raises(EnvironmentInputError, match=r"valid: a depth such as \(64, 64\) beside"):
        ObservationCfg(segments=("classes",))
    with pytest.raises(EnvironmentInputError, match=r"'kinds': classes, objects are valid"):
        ObservationCfg(depth=(16, 16), segments=("kinds",))
