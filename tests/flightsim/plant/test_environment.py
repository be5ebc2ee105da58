"""The plant among movers and in moving air: it meets, sees and repeats them."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import category_id
from flightsim.cameras import open_camera_renderer
from flightsim.environment.effects import Effects
from flightsim.environment.movers import MovingObstacle
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant, PlantCfg, PlantError
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import FIRST_MOVER_ID, WorldError, build_world
from tests.flightsim.handmade import RAY_GROUPS, empty_scene

IRIS = AIRFRAMES["iris"]
FAR = MovingObstacle(kind="person", path_enu_m=((20.0, 0.0, 0.0), (20.0, 9.0, 0.0)), speed_mps=1.5)
NEAR = MovingObstacle(kind="car", path_enu_m=((-9.0, 0.0, 0.0), (9.0, 0.0, 0.0)), speed_mps=3.0)


@pytest.fixture(scope="module")
def worlds():
    scene = empty_scene()
    return {
        "empty": build_world(scene, IRIS),
        "far": build_world(scene, IRIS, traffic=[FAR]),
        "near": build_world(scene, IRIS, traffic=[NEAR]),
    }


def run(world, seconds, **cfg):
    plant = Plant(world, PlantCfg(**{"seed": 1} | cfg))
    rows = []
    for _ in range(round(50 * seconds)):
        plant.advance()
        rows.append(plant.history.copy())
    return plant, np.concatenate(rows)


def test_movers_far_away_change_nothing(worlds):
    _, alone = run(worlds["empty"], 2.0)
    _, among = run(worlds["far"], 2.0)
    assert alone.tobytes() == among.tobytes()


def test_movers_are_where_their_bodies_are(worlds):
    plant, _ = run(worlds["far"], 3.0)
    states = plant.obstacles_true
    np.testing.assert_allclose(
        states.position_enu_m - (0.0, 0.0, 0.88), plant.data.mocap_pos, atol=1e-12
    )
    before = states.position_enu_m
    plant.advance()
    moved = plant.obstacles_true.position_enu_m - before
    np.testing.assert_allclose(moved / 0.02, states.velocity_enu_mps, atol=0.02)
    assert states.kinds == ("person",)


def test_a_car_runs_into_a_vehicle_that_stands_in_its_way(worlds):
    plant, history = run(worlds["near"], 5.0)
    height_m = history["position_true_enu_m"][:, 2]
    arrival = np.flatnonzero(history["time_us"] > 3_000_000)[0]
    # Nobody evades: it goes under the wheels.
    assert np.ptp(height_m[100:arrival]) < 1e-3
    assert height_m[arrival:].min() < height_m[arrival] - 0.05
    assert plant.total_contact_ticks > 0
    assert np.all(np.isfinite(history["position_true_enu_m"]))


def test_the_same_world_can_be_run_again(worlds):
    _, once = run(worlds["near"], 4.0)
    _, again = run(worlds["near"], 4.0)
    assert once.tobytes() == again.tobytes()


def test_traffic_stops_and_goes_gradually(worlds):
    plant, _ = run(worlds["far"], 2.0)
    plant.traffic_speed = 0.0
    speeds = []
    for _ in range(60):
        plant.advance()
        speeds.append(np.linalg.norm(plant.obstacles_true.velocity_enu_mps))
    assert speeds[-1] == 0.0
    assert np.abs(np.diff(speeds)).max() < 0.06
    still = plant.obstacles_true.position_enu_m
    plant.advance()
    np.testing.assert_array_equal(plant.obstacles_true.position_enu_m, still)
    plant.traffic_speed = 2.0
    for _ in range(110):
        plant.advance()
    assert np.linalg.norm(plant.obstacles_true.velocity_enu_mps) > 1.6
    with pytest.raises(PlantError, match="0 to 5 are valid"):
        plant.traffic_speed = -1.0


def test_a_ray_down_meets_a_mover(worlds):
    world = worlds["far"]
    data, hit = world.new_data(), np.zeros(1, dtype=np.int32)
    x, y, _ = data.mocap_pos[0]
    depth = mujoco.mj_ray(world.model, data, (x, y, 5.0), (0.0, 0.0, -1.0), RAY_GROUPS, 1, -1, hit)
    assert 5.0 - depth == pytest.approx(1.76, abs=0.01)
    assert world.geom_object_id[hit[0]] == FIRST_MOVER_ID


@pytest.mark.parametrize("backend", ["gl", "raycast"])
def test_cameras_see_a_mover_and_whose_pixels_are_its(worlds, backend):
    ahead = MovingObstacle(
        kind="person", path_enu_m=((4.0, 0.0, 0.0), (4.0, 9.0, 0.0)), speed_mps=1.0
    )
    world = build_world(empty_scene(), IRIS, traffic=[ahead])
    data = world.new_data()
    renderer = open_camera_renderer(world, 160, 120, backend)
    try:
        is_seen = renderer.render_ids(data, "forward") == FIRST_MOVER_ID
        frame = renderer.render(data, "forward", 0)
        data.mocap_pos[0] = (-30.0, 0.0, 0.0)
        gone = renderer.render(data, "forward", 0)
    finally:
        renderer.close()
    assert is_seen.sum() > 100
    rows, columns = np.nonzero(is_seen)
    rays = np.column_stack([columns - frame.cx, rows - frame.cy, np.full(len(rows), frame.fx)])
    seen = rays / frame.fx * frame.depth_m[is_seen][:, None] @ frame.rotation_enu_from_optical.T
    np.testing.assert_allclose(frame.position_enu_m[0] + seen[:, 0], 4.0, atol=0.4)
    changed = np.any(frame.rgb != gone.rgb, axis=2)
    assert changed[is_seen].mean() > 0.95
    assert not changed[~is_seen].any()


def test_a_start_inside_a_mover_is_refused():
    on_top = MovingObstacle(
        kind="car", path_enu_m=((0.0, 0.0, 0.0), (9.0, 0.0, 0.0)), speed_mps=1.0
    )
    with pytest.raises(WorldError, match="inside moving obstacle 0"):
        build_world(empty_scene(), IRIS, traffic=[on_top])


def test_turbulence_repeats_with_its_seed_and_moves_the_air(worlds):
    wind = WindCfg(speed_mps=5.0, from_deg=270.0, turbulence_mps=0.5, gust_mps=3.0)
    _, once = run(worlds["empty"], 4.0, wind=wind)
    _, again = run(worlds["empty"], 4.0, wind=wind)
    _, other = run(worlds["empty"], 4.0, wind=wind, seed=2)
    assert once.tobytes() == again.tobytes()
    air = once["wind_enu_mps"]
    assert np.any(air != other["wind_enu_mps"])
    assert np.all(air.std(axis=0) > 0.02)
    assert abs(air[:, 0].mean() - 5.0) < 2.5


def test_turbulence_leaves_the_noise_of_the_sensors_as_it_was(worlds):
    _, calm = run(worlds["empty"], 1.0)
    _, windy = run(worlds["empty"], 1.0, wind=WindCfg(turbulence_mps=1e-6))
    np.testing.assert_allclose(windy["gyro_flu_radps"], calm["gyro_flu_radps"], atol=1e-4)


def test_a_wind_that_dies_down_leaves_calm_air(worlds):
    plant, _ = run(worlds["empty"], 0.5, wind=WindCfg(speed_mps=5.0, turbulence_mps=1.0))
    assert plant.air_velocity_true_enu_mps[1] < -1.0
    plant.wind = WindCfg()
    plant.advance()
    assert plant.air_velocity_true_enu_mps == (0.0, 0.0, 0.0)


def test_a_building_keeps_the_wind_off_and_a_change_of_wind_is_followed():
    box = OrientedBox(p=(-12.0, 0.0, 5.0), q=(1.0, 0.0, 0.0, 0.0), s=(10.0, 14.0, 10.0))
    building = SceneObject(
        id=1,
        scene_id="handmade",
        domain="outdoor",
        category_id=category_id("building"),
        parent_id=None,
        bbox=box,
    )
    world = build_world(replace(empty_scene(), objects=(building,)), IRIS)
    west, east = (WindCfg(speed_mps=6.0, from_deg=angle) for angle in (270.0, 90.0))
    plant, _ = run(world, 0.1, wind=west)
    assert plant.air_velocity_true_enu_mps[0] < 1.5
    plant.wind = east
    plant.advance()
    assert plant.air_velocity_true_enu_mps[0] < -3.0
    without, _ = run(world, 0.1, wind=west, effects=Effects.without("shelter"))
    np.testing.assert_allclose(without.air_velocity_true_enu_mps, (6.0, 0.0, 0.0), atol=1e-9)
