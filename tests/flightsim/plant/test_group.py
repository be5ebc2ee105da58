"""Several vehicles in one world: the same bits for one alone, noise of their own, contacts."""

import math

import mujoco
import numpy as np
import pytest

from flightsim.environment.movers import MovingObstacle
from flightsim.lidars.ring_scanner import N_BEAMS, RingScanner
from flightsim.plant import Plant, PlantCfg, PlantError, VehicleGroup
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from scenarios.bench.figure_eight import hold
from tests.flightsim.handmade import empty_scene

IRIS, HUMMINGBIRD = airframe_by_name("iris"), airframe_by_name("hummingbird")
WALKER = MovingObstacle(
    kind="person", path_enu_m=((6.0, -3.0, 0.02), (6.0, 3.0, 0.02)), speed_mps=1
)


def group_of(*airframes, **more):
    worlds = build_world(empty_scene(), *airframes, **more).views
    return VehicleGroup(worlds, [PlantCfg(seed=3)] * len(worlds))


def put(plant, position_enu_m):
    at = plant.world.qpos_address
    plant.data.qpos[at : at + 3] = position_enu_m


def test_one_vehicle_of_a_group_flies_the_bits_of_a_plant_alone():
    alone = Plant(build_world(empty_scene(), IRIS, traffic=[WALKER]), PlantCfg(seed=3))
    group = group_of(IRIS, traffic=[WALKER])
    for _ in range(100):
        alone.advance()
        group.advance()
        assert group.plants[0].history.tobytes() == alone.history.tobytes()
    assert np.array_equal(group.plants[0].data.mocap_pos, alone.data.mocap_pos)


def test_vehicles_fly_where_each_is_sent_and_touch_nothing():
    group = group_of(IRIS, HUMMINGBIRD)
    group.align()
    goals = []
    for plant in group.plants:
        x, y, z = plant.truth.position_enu_m
        goals.append((x, y, z + 2.0))
        plant.apply(hold(goals[-1]))
    for _ in range(200):
        group.advance()
    for plant, goal in zip(group.plants, goals, strict=True):
        assert math.dist(plant.truth.position_enu_m, goal) < 0.5
        assert plant.contact_ticks == 0


def test_each_vehicle_has_noise_of_its_own_and_the_same_in_every_run():
    def readings():
        group = group_of(IRIS, IRIS)
        for _ in range(60):
            group.advance()
        return [plant.history.tobytes() for plant in group.plants], group

    (first, second), group = readings()
    assert first != second
    accelerations = [plant.sensors.imu.accel_flu_mps2 for plant in group.plants]
    assert accelerations[0] != accelerations[1]
    assert readings()[0] == [first, second]


def test_one_sky_stands_over_all_vehicles():
    first, second = (plant._record["sky"]["direction_enu"] for plant in group_of(IRIS, IRIS).plants)
    assert np.array_equal(first, second)


@pytest.mark.parametrize(("lower", "upper"), [(0, 1), (1, 2), (2, 0)])
def test_a_vehicle_that_falls_onto_another_is_felt_by_both(lower, upper):
    group = group_of(IRIS, IRIS, IRIS)
    below, above = group.plants[lower], group.plants[upper]
    x, y, z = below.truth.position_enu_m
    put(above, (x, y, z + 0.8))
    n_touching = 0
    for _ in range(40):
        group.advance()
        n_touching += above.contact_ticks
    assert n_touching > 0
    # It lies on the other one, or beside it, but never in it.
    assert math.dist(above.truth.position_enu_m, below.truth.position_enu_m) > 0.1


@pytest.mark.parametrize(("lower", "upper"), [(0, 1), (1, 2), (2, 0)])
def test_the_rangefinder_of_one_sees_another_below_it(lower, upper):
    group = group_of(IRIS, HUMMINGBIRD, IRIS)
    below, above = group.plants[lower], group.plants[upper]
    x, y, z = below.truth.position_enu_m
    put(above, (x, y, z + 3.0))
    for _ in range(10):
        group.advance()
    height_m = above.truth.position_enu_m[2]
    assert above.sensors.range_m < height_m - z
    assert below.sensors.range_m < 0.5


def test_level_beams_meet_every_other_vehicle_where_it_is():
    group = group_of(IRIS, IRIS, IRIS)
    own, left, ahead = (group.plants[i] for i in (1, 2, 0))
    for plant, position in ((own, (0, 0, 8)), (left, (0, 4, 8)), (ahead, (6, 0, 8))):
        put(plant, position)
    mujoco.mj_forward(own.world.model, own.data)
    ranges_m = RingScanner(own.world, own.data).scan_m((0.0, 0.0, 8.0), 0.0)
    assert ranges_m[0] == pytest.approx(6.0, abs=0.4)
    assert ranges_m[3 * N_BEAMS // 4] == pytest.approx(4.0, abs=0.4)
    assert ranges_m[N_BEAMS // 2] == math.inf


def test_a_mover_is_touched_by_whichever_vehicle_stands_in_its_way():
    start = group_of(IRIS, IRIS).plants[1].truth.position_enu_m
    x, y, _ = start
    through = MovingObstacle(
        kind="person", path_enu_m=((x - 2.0, y, 0.02), (x + 2.0, y, 0.02)), speed_mps=1.5
    )
    group = group_of(IRIS, IRIS, traffic=[through])
    moved_m = 0.0
    for _ in range(150):
        group.advance()
        moved_m = max(moved_m, math.dist(group.plants[1].truth.position_enu_m, start))
    assert moved_m > 0.02
    assert math.dist(group.plants[0].truth.position_enu_m[:2], (0.0, 0.0)) < 0.005


def test_the_traffic_has_one_clock():
    group = group_of(IRIS, IRIS, traffic=[WALKER])
    group.plants[1].traffic_speed = 0.0
    assert group.plants[0].traffic_speed == 0.0
    for _ in range(120):
        group.advance()
    before = group.plants[0].obstacles_true.position_enu_m
    group.advance()
    assert np.array_equal(group.plants[1].obstacles_true.position_enu_m, before)


def test_a_vehicle_of_several_is_no_plant_alone():
    worlds = build_world(empty_scene(), IRIS, IRIS).views
    with pytest.raises(PlantError, match="2 vehicles; a VehicleGroup is valid"):
        Plant(worlds[0], PlantCfg(seed=0))
    with pytest.raises(PlantError, match=r"vehicles \[1\] of a world of 2"):
        VehicleGroup(worlds[1:], [PlantCfg(seed=0)])
    with pytest.raises(PlantError, match="cfgs: 1 for 2 vehicles"):
        VehicleGroup(worlds, [PlantCfg(seed=0)])
    group = VehicleGroup(worlds, [PlantCfg(seed=0)] * 2)
    with pytest.raises(PlantError, match="a VehicleGroup is valid"):
        group.plants[0].advance()
