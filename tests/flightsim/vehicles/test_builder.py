import math

import mujoco
import numpy as np
import pytest

from flightsim.looks.geom_groups import GeomGroup
from flightsim.vehicles.builder import camera_quat_wxyz
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, slope, solid

EACH = pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=lambda a: a.name)


def tilt_deg(quat):
    return math.degrees(math.acos(min(1.0, 1.0 - 2.0 * (quat[1] ** 2 + quat[2] ** 2))))


def vehicle_geoms(world, group):
    model = world.model
    return [
        g
        for g in range(model.ngeom)
        if model.geom_bodyid[g] == world.vehicle_body_id and model.geom_group[g] == group
    ]


@EACH
def test_mass_and_inertia_are_the_airframes_about_the_body_origin(airframe):
    world = build_world(empty_scene(), airframe)
    body = world.vehicle_body_id
    assert world.model.body_mass[body] == airframe.quadrotor.mass_kg
    np.testing.assert_array_equal(
        world.model.body_inertia[body], airframe.quadrotor.inertia_flu_kgm2
    )
    assert not world.model.body_ipos[body].any()
    np.testing.assert_array_equal(world.model.body_iquat[body], (1, 0, 0, 0))


@EACH
def test_looks_touch_nothing_and_shape_is_not_drawn(airframe):
    world = build_world(empty_scene(), airframe)
    looks = vehicle_geoms(world, GeomGroup.VEHICLE_LOOKS)
    shape = vehicle_geoms(world, GeomGroup.VEHICLE_SHAPE)
    assert len(looks) > 20
    n_bars = 1 + 3 * len(airframe.quadrotor.rotors)
    # On skids: four legs and two tubes, whatever the number of arms.
    assert len(shape) == (1 + 2 * 6 + 6 if airframe.has_skids else n_bars)
    assert not world.model.geom_contype[looks].any()
    assert world.model.geom_contype[shape].all()


@EACH
@pytest.mark.parametrize("slope_deg", [0.0, 4.0, 8.0])
def test_dropped_vehicle_rests_level_on_its_legs(airframe, slope_deg):
    world = build_world(empty_scene((0.0, 0.0, 5.0)), airframe, extra=(slope(slope_deg),))
    data = world.new_data()
    data.qpos[2] += 0.3
    rebound_mps = 0.0
    after_landing = []
    for step in range(1250):
        mujoco.mj_step(world.model, data)
        if data.ncon:
            rebound_mps = max(rebound_mps, data.qvel[2])
        if step >= 250:
            after_landing.append(data.qpos.copy())
    after_landing = np.array(after_landing)
    assert rebound_mps < 0.15
    assert np.abs(data.qvel).max() < 1e-3
    assert abs(tilt_deg(data.qpos[3:7]) - slope_deg) < 0.5
    assert np.linalg.norm(np.ptp(after_landing[:, :2], axis=0)) < 0.005
    touching = {world.model.geom(int(max(c.geom))).name for c in data.contact}
    skids = {"skid0", "skid1"} if airframe.has_skids else set()
    assert touching == {"leg0", "leg1", "leg2", "leg3"} | skids


def test_sliding_landing_stops_upright():
    world = build_world(empty_scene(), AIRFRAMES["iris"])
    data = world.new_data()
    data.qpos[2] += 0.05
    data.qvel[:3] = (0.6, -0.4, -0.3)
    for _ in range(1000):
        mujoco.mj_step(world.model, data)
    assert tilt_deg(data.qpos[3:7]) < 1.0
    assert np.abs(data.qvel).max() < 1e-3


@EACH
def test_rotor_disc_is_what_meets_a_wall_first(airframe):
    reach = max(r.position_flu_m[0] for r in airframe.quadrotor.rotors) + airframe.rotor_radius_m
    height = airframe.quadrotor.rotors[0].position_flu_m[2]
    for gap_m, touches in ((0.004, False), (-0.004, True)):
        wall = solid("box", (reach + gap_m + 0.5, 0.0, 5.0), (1.0, 6.0, 4.0))
        world = build_world(empty_scene(), airframe, extra=(wall,))
        data = world.new_data()
        data.qpos[:7] = (0.0, 0.0, 5.0 - height, 1.0, 0.0, 0.0, 0.0)
        mujoco.mj_forward(world.model, data)
        assert bool(data.ncon) is touches
        names = {world.model.geom(int(max(c.geom))).name for c in data.contact[: data.ncon]}
        assert all(name.startswith("disc") for name in names)


@EACH
@pytest.mark.parametrize("speed_mps", [4.0, 8.0])
def test_vehicle_does_not_fly_through_a_wall(airframe, speed_mps):
    wall = solid("box", (2.0, 0.0, 2.0), (0.1, 4.0, 4.0))
    world = build_world(empty_scene(), airframe, extra=(wall,))
    data = world.new_data()
    data.qpos[2] = 2.0
    data.qvel[0] = speed_mps
    for _ in range(300):
        mujoco.mj_step(world.model, data)
        assert data.qpos[0] < 2.0


@EACH
def test_soles_are_at_leg_length_under_the_arms_or_where_the_skids_end(airframe):
    soles = airframe.soles_flu_m
    if airframe.has_skids:
        assert {(abs(x), abs(y), z) for x, y, z in soles} == {(0.15, 0.14315, -0.1767)}
        return
    for rotor, sole in zip(airframe.quadrotor.rotors, soles, strict=True):
        assert math.hypot(sole[0], sole[1]) == pytest.approx(airframe.leg_spread_m)
        assert sole[2] == -airframe.leg_length_m
        cross = rotor.position_flu_m[0] * sole[1] - rotor.position_flu_m[1] * sole[0]
        assert cross == pytest.approx(0.0, abs=1e-12)


@EACH
def test_cameras_look_where_their_mounts_say(airframe):
    for mount in airframe.cameras:
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, np.array(camera_quat_wxyz(mount)))
        right, up, back = rotation.reshape(3, 3).T
        pitch, yaw = mount.pitch_down_rad, mount.yaw_rad
        ahead = (math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), -math.sin(pitch))
        np.testing.assert_allclose(-back, ahead, atol=1e-9)
        np.testing.assert_allclose(right, (math.sin(yaw), -math.cos(yaw), 0), atol=1e-9)
        np.testing.assert_allclose(np.cross(back, right), up, atol=1e-9)
