"""Free flight: the same motion as by MuJoCo's own steps, and never where something can touch."""

import math

import mujoco
import numpy as np
import pytest

from aeroscene.sources import load_scene
from autonomy.types import ControlLevel, Setpoint
from flightsim.environment.movers import MovingObstacle
from flightsim.environment.wind import WindCfg
from flightsim.plant import PhysicsDivergedError, Plant, PlantCfg
from flightsim.plant.clearance import clearance_m
from flightsim.plant.free_flight import is_free, new_free_flight
from flightsim.plant.rays import new_rays
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import NEIGHBOUR_ID, build_world
from tests.flightsim.handmade import empty_scene

GUSTY = WindCfg(speed_mps=5.0, turbulence_mps=1.0)
MOTION = ("position_true_enu_m", "quat_true_wxyz", "velocity_true_enu_mps")
IRIS = airframe_by_name("iris")


def curve(time_s):
    """A setpoint on a figure eight that rises and turns its nose."""
    phase = 0.9 * time_s
    place = (4.0 * math.sin(phase), 2.5 * math.sin(2.0 * phase), 8.0 + math.sin(0.7 * phase))
    return Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=place, yaw_rad=0.5 * time_s)


def flown(world, seconds, *, setpoint=curve, **more):
    """History of a flight, and the share of physics steps that the kernel took itself."""
    plant, rows = Plant(world, PlantCfg(seed=2, wind=GUSTY, **more)), []
    plant.align()
    for _ in range(round(50 * seconds)):
        plant.apply(setpoint(1e-6 * plant.time_us))
        plant.advance()
        rows.append(plant.history.copy())
    return np.concatenate(rows), plant.n_free_steps / (500 * seconds)


@pytest.mark.parametrize("name", ["iris", "hummingbird", "typhoon"])
def test_a_minute_of_curves_in_gusts_is_the_same_flight_both_ways(name):
    world = build_world(empty_scene(), airframe_by_name(name))
    (free, share), (engine, none) = flown(world, 60.0), flown(world, 60.0, free_flight=False)
    assert share > 0.9
    assert none == 0.0
    for column in (*MOTION, "angular_rate_true_flu_radps", "position_est_enu_m"):
        assert np.abs(free[column] - engine[column]).max() < 1e-9
    assert np.array_equal(free["is_touching"], engine["is_touching"])


def test_flight_without_power_turning_fast_is_the_same_both_ways():
    """The gyroscopic torque is greatest here."""
    histories = []
    for free_flight in (True, False):
        world = build_world(empty_scene(), IRIS)
        plant = Plant(world, PlantCfg(seed=0, free_flight=free_flight, state="truth"))
        plant.data.qpos[2], plant.data.qvel[:] = 60.0, (3.0, -2.0, 4.0, 9.0, -7.0, 5.0)
        histories.append([])
        for _ in range(100):
            plant.advance()
            histories[-1].append(plant.history.copy())
    free, engine = (np.concatenate(rows) for rows in histories)
    for column in (*MOTION, "angular_rate_true_flu_radps"):
        assert np.abs(free[column] - engine[column]).max() < 1e-11


def test_a_push_from_outside_is_felt_as_by_mujoco():
    ends = []
    for free_flight in (True, False):
        plant = Plant(build_world(empty_scene(), IRIS), PlantCfg(seed=0, free_flight=free_flight))
        plant.data.qpos[2] = 30.0
        plant.data.qfrc_applied[:] = (3.0, -2.0, 20.0, 0.02, -0.01, 0.03)
        for _ in range(50):
            plant.advance()
        ends.append(plant.history[-1:].copy())
        assert (plant.n_free_steps > 0) == free_flight
    for column in (*MOTION, "angular_rate_true_flu_radps"):
        assert np.abs(ends[0][column] - ends[1][column]).max() < 1e-11
    assert ends[0]["position_true_enu_m"][0, 0] > 0.5


def test_the_clearance_is_the_distance_to_the_nearest_bounding_box():
    world = build_world(load_scene("28"), IRIS)
    model, data, rng = world.model, world.new_data(), np.random.default_rng(4)
    free = new_free_flight(world, data, is_on=True)[0]
    rays = new_rays(world, data)[0]
    is_site = world.geom_object_id != NEIGHBOUR_ID
    solids = np.flatnonzero((model.geom_bodyid == 0) & (model.geom_contype != 0) & is_site)
    boxed = solids[model.geom_type[solids] != mujoco.mjtGeom.mjGEOM_PLANE]
    turns = data.geom_xmat[boxed].reshape(-1, 3, 3)
    for _ in range(500):
        point = rng.uniform((-40.0, -40.0, 0.5), (40.0, 40.0, 25.0))
        local = np.einsum("nji,nj->ni", turns, point - data.geom_xpos[boxed])
        outside = np.abs(local - model.geom_aabb[boxed, :3]) - model.geom_aabb[boxed, 3:]
        nearest = np.linalg.norm(np.maximum(outside, 0.0), axis=1).min()
        assert clearance_m(rays, free, point, 50.0) == pytest.approx(min(nearest, point[2], 50.0))


def test_what_stands_on_the_ground_or_near_it_is_left_to_the_engine():
    world = build_world(empty_scene(), IRIS)
    low = Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(0.0, 0.0, 0.3), yaw_rad=0.0)
    assert flown(world, 4.0, setpoint=lambda _: low)[1] == 0.0


def test_near_a_mover_the_engine_takes_all_steps():
    walker = MovingObstacle(
        kind="drone", path_enu_m=((1.2, 0.0, 6.0), (1.3, 0.0, 6.0)), speed_mps=0.1
    )
    high = Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(0.0, 0.0, 6.0), yaw_rad=0.0)
    alone = build_world(empty_scene(), IRIS)
    met = build_world(empty_scene(), IRIS, traffic=[walker])
    assert flown(alone, 8.0, setpoint=lambda _: high)[1] > 0.9
    assert flown(met, 8.0, setpoint=lambda _: high)[1] < 0.5


@pytest.mark.parametrize("part", ["body_ipos", "dof_damping"])
def test_a_body_that_moves_otherwise_is_left_to_the_engine(part):
    world = build_world(empty_scene(), IRIS)
    getattr(world.model, part)[-1] = 0.01
    assert not new_free_flight(world, world.new_data(), is_on=True)["is_on"][0]


@pytest.mark.parametrize("column", [0, 4])
def test_a_velocity_that_is_no_number_is_noticed_in_the_air(column):
    plant = Plant(build_world(empty_scene(), IRIS), PlantCfg(seed=0, state="truth"))
    plant.data.qpos[2] = 20.0
    plant.advance()
    plant.data.qvel[column] = math.nan
    with pytest.raises(PhysicsDivergedError):
        plant.advance()


def test_vehicles_that_are_apart_fly_freely_and_those_that_meet_do_not():
    first = Plant(build_world(empty_scene(), IRIS, IRIS), PlantCfg(seed=0, state="truth"))
    first.data.qpos[2], first.data.qpos[9] = 20.0, 25.0
    first.advance()
    record = first._record["free_flight"]
    assert first.n_free_steps == 10
    apart_m = math.dist(first.data.qpos[:3], first.data.qpos[7:10])
    clearances_m = (
        record["clearance_m"] + first.other_plants[0]._record["free_flight"]["clearance_m"]
    )
    assert clearances_m < apart_m - 2.0 * IRIS.collision_radius_m
    first.data.qpos[7:10] = first.data.qpos[:3] + (0.0, 0.0, 0.5)
    first.advance()
    assert first.n_free_steps == 10


def test_two_vehicles_are_not_free_wherever_mujoco_finds_a_contact():
    """Their hulls have margins: rotors that point at each other touch before they meet."""
    world = build_world(empty_scene(), IRIS, IRIS)
    first = Plant(world, PlantCfg(seed=0, state="truth"))
    x, y, _ = IRIS.quadrotor.rotors[0].position_flu_m
    yaw = -math.atan2(y, x)
    quats = [(math.cos(half), 0.0, 0.0, math.sin(half)) for half in (yaw / 2, (yaw + math.pi) / 2)]
    data, n_contacts = world.new_data(), 0
    first.data.qpos[:] = (0.0, 0.0, 9.0, *quats[0], 1.0, 0.0, 9.0, *quats[1])
    assert is_free(first._row[0])
    # From afar, as in flight: each reaches the end of the sphere that it knows.
    for apart_m in np.arange(1.0, 0.6, -0.001).tolist():
        data.qpos[:] = (0.0, 0.0, 9.0, *quats[0], apart_m, 0.0, 9.0, *quats[1])
        mujoco.mj_fwdPosition(world.model, data)
        first.data.qpos[:] = data.qpos
        is_known_free = is_free(first._row[0])
        n_contacts += data.ncon > 0
        assert not (data.ncon > 0 and is_known_free)
    assert n_contacts > 100
