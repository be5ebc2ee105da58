"""Several vehicles in one world: the same bits for one alone, noise of their own, contacts."""

import math

import mujoco
import numpy as np
import pytest

from flightsim.environment.movers import MovingObstacle
from flightsim.lidars.ring_scanner import N_BEAMS, RingScanner
from flightsim.plant import Plant, PlantCfg, PlantError
from flightsim.plant.rays import cast_rays, new_rays
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from scenarios.bench.figure_eight import hold
from tests.flightsim.handmade import empty_scene

IRIS, HUMMINGBIRD = airframe_by_name("iris"), airframe_by_name("hummingbird")
WALKER = MovingObstacle(
    kind="person", path_enu_m=((6.0, -3.0, 0.02), (6.0, 3.0, 0.02)), speed_mps=1
)


def plants_of(*airframes, **more):
    first = Plant(build_world(empty_scene(), *airframes, **more), PlantCfg(seed=3))
    return (first, *first.other_plants)


def put(plant, position_enu_m):
    at = plant.world.qpos_address
    plant.data.qpos[at : at + 3] = position_enu_m


def test_vehicles_fly_where_each_is_sent_and_touch_nothing():
    plants = plants_of(IRIS, HUMMINGBIRD)
    plants[0].align()
    goals = []
    for plant in plants:
        x, y, z = plant.truth.position_enu_m
        goals.append((x, y, z + 2.0))
        plant.apply(hold(goals[-1]))
    for _ in range(200):
        plants[0].advance()
    for plant, goal in zip(plants, goals, strict=True):
        assert math.dist(plant.truth.position_enu_m, goal) < 0.5
        assert plant.contact_ticks == 0


def test_each_vehicle_has_noise_of_its_own_and_the_same_in_every_run():
    def readings():
        plants = plants_of(IRIS, IRIS)
        for _ in range(60):
            plants[0].advance()
        return [plant.history.tobytes() for plant in plants], plants

    (first, second), plants = readings()
    assert first != second
    accelerations = [plant.sensors.imu.accel_flu_mps2 for plant in plants]
    assert accelerations[0] != accelerations[1]
    assert readings()[0] == [first, second]


def test_one_sky_stands_over_all_vehicles():
    first, second = (plant._record["sky"]["direction_enu"] for plant in plants_of(IRIS, IRIS))
    assert np.array_equal(first, second)


@pytest.mark.parametrize(("lower", "upper"), [(0, 1), (1, 2), (2, 0)])
def test_a_vehicle_that_falls_onto_another_is_felt_by_both(lower, upper):
    plants = plants_of(IRIS, IRIS, IRIS)
    below, above = plants[lower], plants[upper]
    x, y, z = below.truth.position_enu_m
    put(above, (x, y, z + 0.8))
    n_touching = 0
    for _ in range(40):
        plants[0].advance()
        n_touching += above.contact_ticks
    assert n_touching > 0
    # It lies on the other one, or beside it, but never in it.
    assert math.dist(above.truth.position_enu_m, below.truth.position_enu_m) > 0.1


@pytest.mark.parametrize(("lower", "upper"), [(0, 1), (1, 2), (2, 0)])
def test_the_rangefinder_of_one_sees_another_below_it(lower, upper):
    plants = plants_of(IRIS, HUMMINGBIRD, IRIS)
    below, above = plants[lower], plants[upper]
    x, y, z = below.truth.position_enu_m
    put(above, (x, y, z + 3.0))
    for _ in range(10):
        plants[0].advance()
    height_m = above.truth.position_enu_m[2]
    assert above.sensors.range_m < height_m - z
    assert below.sensors.range_m < 0.5


def test_level_beams_meet_every_other_vehicle_where_it_is():
    plants = plants_of(IRIS, IRIS, IRIS)
    own, left, ahead = (plants[i] for i in (1, 2, 0))
    for plant, position in ((own, (0, 0, 8)), (left, (0, 4, 8)), (ahead, (6, 0, 8))):
        put(plant, position)
    mujoco.mj_forward(own.world.model, own.data)
    ranges_m = RingScanner(own.world, own.data).scan_m((0.0, 0.0, 8.0), 0.0)
    assert ranges_m[0] == pytest.approx(6.0, abs=0.4)
    assert ranges_m[3 * N_BEAMS // 4] == pytest.approx(4.0, abs=0.4)
    assert ranges_m[N_BEAMS // 2] == math.inf


def test_a_mover_is_touched_by_whichever_vehicle_stands_in_its_way():
    start = plants_of(IRIS, IRIS)[1].truth.position_enu_m
    x, y, _ = start
    through = MovingObstacle(
        kind="person", path_enu_m=((x - 2.0, y, 0.02), (x + 2.0, y, 0.02)), speed_mps=1.5
    )
    plants = plants_of(IRIS, IRIS, traffic=[through])
    moved_m = 0.0
    for _ in range(150):
        plants[0].advance()
        moved_m = max(moved_m, math.dist(plants[1].truth.position_enu_m, start))
    assert moved_m > 0.02
    assert math.dist(plants[0].truth.position_enu_m[:2], (0.0, 0.0)) < 0.005


def test_the_traffic_has_one_clock():
    plants = plants_of(IRIS, IRIS, traffic=[WALKER])
    plants[1].traffic_speed = 0.0
    assert plants[0].traffic_speed == 0.0
    for _ in range(120):
        plants[0].advance()
    before = plants[0].obstacles_true.position_enu_m
    plants[0].advance()
    assert np.array_equal(plants[1].obstacles_true.position_enu_m, before)


def test_whichever_vehicle_is_advanced_all_of_its_world_are():
    first, second = plants_of(IRIS, IRIS)
    second.advance()
    assert first.time_us == second.time_us == 20_000
    assert first.other_plants == (second,)
    assert second.other_plants == (first,)


def test_plants_are_of_a_world_as_build_world_gives_it():
    with pytest.raises(PlantError, match="world 0: it is the view of vehicle 2"):
        Plant(build_world(empty_scene(), IRIS, IRIS).views[1], PlantCfg(seed=0))


def test_rays_meet_a_vehicle_where_it_flies_now():
    """No engine's step brings its shapes along while both fly freely."""
    first, second = plants_of(IRIS, IRIS)
    put(first, (0.0, 0.0, 20.0))
    put(second, (4.0, 0.0, 20.0))
    first.data.qvel[7] = 6.0
    for _ in range(20):
        first.advance()
    assert first.n_free_steps == 200
    here, there = (np.array(plant.truth.position_enu_m) for plant in (first, second))
    assert there[1] > 2.0
    share = np.zeros(1)
    rays = new_rays(first.world, first.data)
    cast_rays(rays, np.array([[*here, *(there - here)]]), first.world.vehicle_body_id, share)
    assert 0.9 < share[0] < 1.0
