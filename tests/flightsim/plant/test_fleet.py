"""Many plants at once: the same bits however many there are, and whoever advances them."""

import math
import threading
import time

import numpy as np
import pytest

from autonomy.types import ControlLevel, Setpoint
from flightsim.environment.movers import MovingObstacle
from flightsim.environment.wind import WindCfg
from flightsim.plant import Fleet, PhysicsDivergedError, Plant, PlantCfg, PlantError
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, solid

N_TICKS = 80
LEVEL = (1.0, 0.0, 0.0, 0.0)
WIND = WindCfg(speed_mps=4.0, turbulence_mps=0.5)
AWAY = Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(1.0, -0.5, 2.0), yaw_rad=0.3)


@pytest.fixture(scope="module")
def worlds():
    iris, hummingbird = airframe_by_name("iris"), airframe_by_name("hummingbird")
    way_enu_m = ((3.0, 0.0, 0.0), (6.0, 0.0, 0.0))
    walker = MovingObstacle(kind="person", path_enu_m=way_enu_m, speed_mps=1.0)
    table = solid("box", (0.0, 0.0, 0.5), (4.0, 4.0, 1.0))
    return [
        build_world(empty_scene(), iris),
        build_world(empty_scene(start=(0.0, 0.0, 1.0)), iris, extra=[table]),
        build_world(empty_scene(), hummingbird, traffic=[walker]),
    ]


def cfg(seed, **more):
    return PlantCfg(seed=seed, wind=WIND, aiding="vio", **more)


def histories_alone(world, plant_cfg):
    plant, rows = Plant(world, plant_cfg), []
    for tick in range(N_TICKS):
        if tick == 60:
            plant.apply(AWAY)
        plant.advance()
        rows.append(plant.history.tobytes())
    return rows


def histories_together(worlds, cfgs, n_threads):
    with Fleet(worlds, cfgs, n_threads=n_threads) as fleet:
        rows = [[] for _ in fleet.worlds]
        for tick in range(N_TICKS):
            if tick == 60:
                fleet.setpoints["level"] = AWAY.level
                fleet.setpoints["position_enu_m"] = AWAY.position_enu_m
                fleet.setpoints["yaw_rad"] = AWAY.yaw_rad
            fleet.advance()
            for i, row in enumerate(fleet.history):
                rows[i].append(row.tobytes())
    return rows


def test_each_flies_as_it_would_alone_whoever_advances_it(worlds):
    around = [worlds[i % 3] for i in range(7)]
    cfgs = [cfg(i) for i in range(7)]
    together = histories_together(around, cfgs, n_threads=3)
    assert together == histories_together(around, cfgs, n_threads=1)
    for i in (0, 1, 2, 6):
        assert together[i] == histories_alone(around[i], cfgs[i])


def test_the_vehicles_of_a_world_fly_as_they_would_in_plants_of_one_world():
    world = build_world(empty_scene(), *[airframe_by_name("iris")] * 2)
    plant, together = Plant(world, cfg(2)), histories_together([world] * 2, [cfg(5), cfg(2)], 2)
    for tick in range(N_TICKS):
        if tick == 60:
            for each in (plant, *plant.other_plants):
                each.apply(AWAY)
        plant.advance()
        for each, row in zip((plant, *plant.other_plants), together[2:], strict=True):
            assert each.history.tobytes() == row[tick]


def test_a_new_start_leaves_nothing_of_the_flight_before_nor_in_other_worlds(worlds):
    rows = [[], []]
    with Fleet(worlds[:2], [cfg(0), cfg(1)], n_threads=1) as fleet:
        for tick in range(90):
            if tick == 30:
                fleet.setpoints["level"][1] = ControlLevel.IDLE
            if tick == 40:
                fleet.restart(1, 5, WIND)
                rows[1].clear()
            fleet.advance()
            for i, row in enumerate(fleet.history):
                rows[i].append(row.tobytes())
    for i, seed in ((0, 0), (1, 5)):
        plant = Plant(worlds[i], cfg(seed))
        for row in rows[i]:
            plant.advance()
            assert plant.history.tobytes() == row


def test_a_start_with_the_mass_of_before_leaves_nothing_of_another_mass_nor_wind(worlds):
    def flight(fleet, seed, wind, share):
        fleet.restart(0, seed, wind, held_at=[((0.0, 0.0, 5.0), LEVEL)], mass_shares=[share])
        fleet.align([0])
        fleet.release(0)
        fleet.motor_speeds_radps[:] = 600.0
        rows = []
        for _ in range(30):
            fleet.advance()
            rows.append(fleet.history.tobytes())
        return rows

    for more in ({}, {"has_sensors": False, "state": "truth"}):
        with Fleet(worlds[:1], [cfg(0, **more)], n_threads=1) as fleet:
            first = flight(fleet, 1, WindCfg(), 1.0)
            heavy = flight(fleet, 1, WIND, 1.3)
            assert heavy != flight(fleet, 1, WIND, 1.0)
            assert flight(fleet, 1, WindCfg(), 1.0) == first
            assert flight(fleet, 1, WIND, 1.3) == heavy
        with Fleet(worlds[:1], [cfg(7, **more)], n_threads=1) as fleet:
            assert flight(fleet, 1, WIND, 1.3) == heavy


def test_worlds_align_together_as_each_alone(worlds):
    rows = []
    for n_threads in (1, 3):
        with Fleet(worlds[:1] * 4, [cfg(i) for i in range(4)], n_threads=n_threads) as fleet:
            for i in range(4):
                fleet.restart(i, i, held_at=[((0.0, 0.0, 5.0), LEVEL)])
            for each in (range(4),) if n_threads > 1 else ([i] for i in range(4)):
                fleet.align(each)
            rows.append(fleet.history.tobytes())
            assert fleet.records["filter"]["is_aligned"].all()
    assert rows[0] == rows[1]


def test_worlds_are_shared_but_where_something_moves_in_them(worlds):
    with Fleet([worlds[0]] * 2 + [worlds[2]] * 2, [cfg(i) for i in range(4)]) as fleet:
        models = [world.model for world in fleet.worlds]
    assert models[0] is models[1]
    assert models[2] is not models[3]


def test_a_hand_holds_a_vehicle_until_it_is_aligned(worlds):
    tilted = (math.cos(0.1), 0.0, math.sin(0.1), 0.0)
    with Fleet(worlds[:1], [cfg(0)], n_threads=1) as fleet:
        fleet.restart(0, 3, WIND, held_at=[((2.0, 1.0, 5.0), tilted)])
        fleet.align([0])
        row = fleet.history[0, -1]
        assert row["position_true_enu_m"].tolist() == [2.0, 1.0, 5.0]
        np.testing.assert_allclose(row["quat_est_wxyz"], tilted, atol=0.02)
        fleet.release(0)
        fleet.setpoints["level"] = ControlLevel.TRAJECTORY
        fleet.setpoints["position_enu_m"] = (2.0, 1.0, 5.0)
        for _ in range(200):
            fleet.advance()
        np.testing.assert_allclose(
            fleet.history[0, -1]["position_true_enu_m"], (2.0, 1.0, 5.0), atol=0.3
        )


def test_a_heavier_vehicle_falls_as_fast_but_climbs_slower(worlds):
    heights_m = []
    with Fleet([worlds[0]] * 2, [cfg(0, has_sensors=False, state="truth")] * 2) as fleet:
        for i, share in enumerate((1.0, 1.2)):
            fleet.restart(i, 0, held_at=[((0.0, 0.0, 5.0), LEVEL)], mass_shares=[share])
            fleet.release(i)
        fleet.motor_speeds_radps[:] = 700.0
        for _ in range(25):
            fleet.advance()
        heights_m = fleet.history["position_true_enu_m"][:, -1, 2]
    assert heights_m[0] > heights_m[1] + 0.1


def test_without_sensors_nothing_is_estimated_and_the_control_has_the_truth(worlds):
    with pytest.raises(PlantError, match="state = 'estimate': without sensors 'truth' is valid"):
        Fleet(worlds[:1], [cfg(0, has_sensors=False)])
    with Fleet(worlds[:1], [cfg(0, has_sensors=False, state="truth")]) as fleet:
        fleet.setpoints["level"] = ControlLevel.TRAJECTORY
        fleet.setpoints["position_enu_m"] = (0.0, 0.0, 2.0)
        for _ in range(150):
            fleet.advance()
        assert abs(fleet.history[0, -1]["position_true_enu_m"][2] - 2.0) < 0.2
        assert not fleet.records["filter"]["is_aligned"].any()


@pytest.mark.parametrize("advance_hz", [10, 250])
def test_a_call_may_be_longer_or_shorter(worlds, advance_hz):
    truth = cfg(0, has_sensors=False, state="truth", advance_hz=advance_hz)
    with Fleet(worlds[:1], [truth]) as fleet:
        fleet.advance()
        assert fleet.history.shape == (1, 250 // advance_hz)
        assert fleet.time_s[0] == pytest.approx(1.0 / advance_hz)


def test_a_lost_state_is_an_error_on_any_thread(worlds, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it runs
    with Fleet([worlds[0]] * 4, [cfg(i) for i in range(4)], n_threads=2) as fleet:
        fleet.advance()
        fleet.records["rotors"]["wind_enu_mps"][2] = math.nan
        fleet.records["air"]["is_steady"][2] = 1
        with pytest.raises(PhysicsDivergedError, match="world 2: the physics engine reset itself"):
            fleet.advance()


def test_other_threads_of_python_run_while_the_fleet_flies(worlds):
    truth = cfg(0, has_sensors=False, state="truth", advance_hz=1)
    stamps_s, is_over = [], threading.Event()

    def look_at_the_clock():
        while not is_over.wait(0.002):
            stamps_s.append(time.perf_counter())

    watcher = threading.Thread(target=look_at_the_clock)
    with Fleet([worlds[0]] * 16, [truth] * 16, n_threads=1) as fleet:
        watcher.start()
        n_within = 0
        for _ in range(20):  # a busy machine may not let the other one run in each call
            begin_s = time.perf_counter()
            fleet.advance()
            end_s = time.perf_counter()
            margin_s = 0.2 * (end_s - begin_s)
            n_within += sum(begin_s + margin_s < t < end_s - margin_s for t in stamps_s)
            if n_within:
                break
        is_over.set()
        watcher.join()
    assert n_within > 0


def test_rates_and_numbers_that_do_not_fit_are_refused(worlds):
    with pytest.raises(PlantError, match=r"cfgs: 1 for 2 worlds"):
        Fleet(worlds[:2], [cfg(0)])
    with pytest.raises(PlantError, match="n_threads = 0: 1 or more are valid"):
        Fleet(worlds[:1], [cfg(0)], n_threads=0)
    with pytest.raises(PlantError, match="the same for all are valid"):
        Fleet(worlds[:2], [cfg(0), cfg(0, advance_hz=10)])
    with pytest.raises(PlantError, match=r"control_hz = 250: a multiple of 60 up to physics_hz"):
        Fleet(worlds[:1], [cfg(0, advance_hz=60)])
