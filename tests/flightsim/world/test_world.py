import dataclasses
import math

import mujoco
import numpy as np
import pytest

from aeroscene.corpus.curation import curate_scene
from aeroscene.solids.shapes import scene_primitives
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import GROUND_ID, VEHICLE_ID, WorldError, build_world
from tests.flightsim.handmade import RAY_GROUPS, empty_scene, slope, solid

IRIS = AIRFRAMES["iris"]


@pytest.fixture(scope="module")
def scene42():
    return curate_scene(42)


@pytest.fixture(scope="module")
def world42(scene42):
    return build_world(scene42, IRIS)


def fly(world, steps, *, is_sleep_enabled=True):
    """States of a flight through the scene, pushed by a fixed pattern of forces."""
    flag = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    assert world.model.opt.enableflags & flag
    if not is_sleep_enabled:
        world.model.opt.enableflags &= ~flag
    data = world.new_data()
    states = np.empty((steps, world.model.nq + world.model.nv))
    for k in range(steps):
        push = (2.0 * math.sin(0.01 * k), 1.5 * math.cos(0.013 * k), 17.0 if k < 400 else 10.0)
        data.xfrc_applied[world.vehicle_body_id, :3] = push
        mujoco.mj_step(world.model, data)
        states[k] = np.concatenate([data.qpos, data.qvel])
    return states


def test_static_geometry_belongs_to_the_world_body(world42):
    assert world42.model.nbody == 2
    assert world42.vehicle_body_id == 1


def test_every_object_of_the_scene_has_its_geoms(world42, scene42):
    ids = world42.geom_object_id
    expected = [p.object_id for p in scene_primitives(scene42)]
    assert ids[0] == GROUND_ID
    assert ids[1 : 1 + len(expected)].tolist() == expected
    is_vehicle = world42.model.geom_bodyid == world42.vehicle_body_id
    assert ((ids == VEHICLE_ID) == is_vehicle).all()


def test_geoms_stand_where_their_primitives_do(world42, scene42):
    data = world42.new_data()
    primitives = scene_primitives(scene42)
    for g, primitive in enumerate(primitives, start=1):
        if primitive.kind == "mesh":
            continue
        np.testing.assert_allclose(data.geom_xpos[g], primitive.position_enu_m, atol=1e-9)
        np.testing.assert_allclose(
            2 * world42.model.geom_aabb[g][3:], primitive.size_m, rtol=1e-6, atol=1e-9
        )


def test_vehicle_stands_still_at_the_start(world42, scene42):
    data = world42.new_data()
    start = data.qpos.copy()
    x, y, z = scene42.start_position_enu_m
    np.testing.assert_allclose(start[:3], (x, y, z + IRIS.leg_length_m), atol=0.02)
    assert data.time == 0.0
    assert not data.qvel.any()
    assert 2 * math.atan2(start[6], start[3]) == pytest.approx(scene42.start_yaw_rad, abs=1e-3)
    for _ in range(250):
        mujoco.mj_step(world42.model, data)
    np.testing.assert_allclose(data.qpos, start, atol=1e-4)


def test_same_scene_gives_bit_identical_flights(world42, scene42):
    again = build_world(scene42, IRIS)
    assert (fly(world42, 700) == fly(again, 700)).all()


def test_sleeping_changes_no_bit_of_a_flight_and_its_crash(world42, scene42):
    awake = build_world(scene42, IRIS)
    assert (fly(world42, 1500) == fly(awake, 1500, is_sleep_enabled=False)).all()


def test_start_inside_an_obstacle_is_named():
    scene = empty_scene((1.0, 2.0, 0.0))
    block = solid("box", (1.0, 2.0, 0.2), (3.0, 3.0, 2.0), object_id=12)
    with pytest.raises(WorldError) as caught:
        build_world(scene, IRIS, extra=(block,))
    assert str(caught.value) == (
        "start_position_enu_m (1.0, 2.0, 0.0) puts the vehicle inside object 12 (unknown); "
        "valid: a free point on a surface"
    )


def test_start_inside_a_curated_object_names_its_category(scene42):
    tree = next(o for o in scene42.objects if o.category == "tree")
    x, y, _ = tree.bbox.p
    buried = dataclasses.replace(scene42, start_position_enu_m=(x, y, 0.2))
    with pytest.raises(WorldError, match=rf"inside object {tree.id} \(tree\)"):
        build_world(buried, IRIS)


def test_start_in_the_ground_is_named():
    sunk = dataclasses.replace(
        empty_scene(), extent_min_enu_m=(-40.0, -40.0, -5.0), start_position_enu_m=(0.0, 0.0, -1.0)
    )
    with pytest.raises(WorldError, match="puts the vehicle inside the ground; valid:"):
        build_world(sunk, IRIS)


@pytest.mark.parametrize("angle_deg", [35.0, 60.0])
def test_start_on_a_steep_slope_is_refused(angle_deg):
    with pytest.raises(WorldError, match="start_position_enu_m"):
        build_world(empty_scene((0.0, 0.0, 5.0)), IRIS, extra=(slope(angle_deg),))


def test_start_in_the_air_is_no_place_to_stand():
    with pytest.raises(WorldError, match=r"is no place to stand \(the vehicle moved"):
        build_world(empty_scene((0.0, 0.0, 3.0)), IRIS)


def test_start_on_a_gentle_slope_settles_along_it():
    world = build_world(empty_scene((0.0, 0.0, 5.0)), IRIS, extra=(slope(8.0),))
    _, x, y, _ = world.rest_qpos[3:7]
    assert math.degrees(2 * math.asin(math.hypot(x, y))) == pytest.approx(8.0, abs=0.3)


def test_primitives_that_touch_nothing_do_not_hold_the_vehicle_or_a_ray():
    pane = solid("box", (0.0, 0.0, 0.5), (2.0, 2.0, 0.02), collides=False)
    world = build_world(empty_scene(), IRIS, extra=(pane,))
    assert world.rest_qpos[2] == pytest.approx(IRIS.leg_length_m, abs=0.005)
    data = world.new_data()
    hit = np.zeros(1, np.int32)
    distance_m = mujoco.mj_ray(
        world.model, data, (0.0, 0.0, 3.0), (0.0, 0.0, -1.0), RAY_GROUPS, 1, -1, hit
    )
    assert distance_m == pytest.approx(3.0)
    assert world.geom_object_id[hit[0]] == GROUND_ID


@pytest.mark.parametrize(
    ("shape", "top_m"),
    [
        (solid("box", (0, 0, 1), (2, 2, 2)), 2.0),
        (solid("cylinder", (0, 0, 1), (2, 2, 3)), 2.5),
        (solid("ellipsoid", (0, 0, 1), (2, 3, 4)), 3.0),
        (
            solid(
                "mesh",
                (0, 0, 1),
                (2, 2, 1),
                vertices_m=(
                    (-1, -1, -0.5),
                    (1, -1, -0.5),
                    (1, 1, -0.5),
                    (-1, 1, -0.5),
                    (0, -1, 0.5),
                    (0, 1, 0.5),
                ),
            ),
            1.5,
        ),
    ],
    ids=["box", "cylinder", "ellipsoid", "mesh"],
)
def test_every_kind_of_primitive_is_as_high_as_it_says(shape, top_m):
    world = build_world(empty_scene((20.0, 0.0, 0.0)), IRIS, extra=(shape,))
    hit = np.zeros(1, np.int32)
    distance_m = mujoco.mj_ray(
        world.model, world.new_data(), (0.0, 0.0, 9.0), (0.0, 0.0, -1.0), RAY_GROUPS, 1, -1, hit
    )
    assert 9.0 - distance_m == pytest.approx(top_m, abs=1e-5)
    assert world.geom_object_id[hit[0]] == 7


def test_world_without_a_vehicle_has_no_moving_part(scene42):
    world = build_world(scene42)
    assert world.model.nv == 0
    assert world.vehicle_body_id == -1
    assert world.new_data().time == 0.0


def test_step_is_what_physics_hz_says():
    assert build_world(empty_scene(), IRIS, physics_hz=1000).model.opt.timestep == 0.001


def test_free_fall_and_free_spin_keep_their_invariants():
    world = build_world(empty_scene(), IRIS)
    data = world.new_data()
    data.qpos[2] = 20.0
    data.qvel[3:] = (3.0, -2.0, 5.0)
    inertia = np.array(IRIS.quadrotor.inertia_flu_kgm2)
    energy_j = 0.5 * inertia @ data.qvel[3:] ** 2
    for _ in range(500):
        mujoco.mj_step(world.model, data)
    assert np.linalg.norm(data.qpos[3:7]) == pytest.approx(1.0, abs=1e-12)
    assert data.qvel[2] == pytest.approx(-9.81, rel=1e-9)
    assert 0.5 * inertia @ data.qvel[3:] ** 2 == pytest.approx(energy_j, rel=0.02)
