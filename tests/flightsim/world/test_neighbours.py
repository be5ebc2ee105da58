"""What stands around a site can be hit and seen, and alters no flight within the volume."""

import mujoco
import numpy as np
import pytest

import flightsim.world.world as worlds
from aeroscene.neighbourhood import neighbours_of
from aeroscene.sources import load_scene
from autonomy.types import ControlLevel, Setpoint
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant, PlantCfg
from flightsim.plant.rays import cast_rays, new_rays
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import NEIGHBOUR_ID, build_world

IRIS = airframe_by_name("iris")
SCENE = load_scene("42")
GUSTY = WindCfg(speed_mps=5.0, turbulence_mps=1.0)


@pytest.fixture(scope="module")
def world():
    return build_world(SCENE, IRIS)


def nearest_house(scene):
    """A wall east of the flight volume."""
    high = scene.extent_max_enu_m
    houses = [
        p for p in neighbours_of(scene) if p.collides and p.material in {"brick", "plaster_cream"}
    ]
    return min(houses, key=lambda p: abs(p.position_enu_m[1]) + 9 * (p.position_enu_m[0] < high[0]))


@pytest.mark.parametrize("free_flight", [True, False])
def test_a_flight_within_the_volume_is_the_same_to_the_bit(monkeypatch, world, free_flight):
    monkeypatch.setattr(worlds, "neighbours_of", lambda _: ())
    alone = build_world(SCENE, IRIS)
    assert alone.model.ngeom < world.model.ngeom
    histories = []
    for each in (world, alone):
        cfg = PlantCfg(
            seed=3, free_flight=free_flight, wind=WindCfg(speed_mps=5.0, turbulence_mps=1.0)
        )
        plant, rows = Plant(each, cfg), []
        plant.align()
        x, y, z = SCENE.start_position_enu_m
        for tick in range(400):
            place = (x, y, z + min(6.0, 0.03 * tick))
            plant.apply(Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=place, yaw_rad=0.0))
            plant.advance()
            rows.append(plant.history.copy())
        histories.append(np.concatenate(rows))
        assert (plant.n_free_steps > 0) == free_flight
    for name in histories[0].dtype.names:
        np.testing.assert_array_equal(histories[0][name], histories[1][name])


def test_a_vehicle_that_leaves_the_volume_meets_a_house(world):
    house = nearest_house(SCENE)
    plant = Plant(world, PlantCfg(seed=0, state="truth"))
    x, y, z = house.position_enu_m
    towards = np.sign(-np.array([x, y]))
    reach_m = max(house.size_m) / 2 + 2.0
    start = np.array([x, y, z]) + np.array([*(towards * reach_m * 0.75), 0.0])
    plant.data.qpos[:3], plant.data.qvel[:2] = start, -6.0 * towards
    touched = set()
    for _ in range(60):
        plant.advance()
        for contact in plant.data.contact:
            touched |= {int(world.geom_object_id[g]) for g in contact.geom}
    assert NEIGHBOUR_ID in touched
    assert world.name_of(NEIGHBOUR_ID) == "the surroundings"
    assert plant.n_free_steps == 0


def test_lidars_see_a_house_and_satellites_and_rangefinder_do_not(world):
    house = nearest_house(SCENE)
    x, y, z = house.position_enu_m
    eye = np.array([*SCENE.start_position_enu_m[:2], z + 25.0])
    ray = np.array([[*eye, *(np.array([x, y, z]) - eye)]])
    found, data = np.empty(1), world.new_data()
    cast_rays(new_rays(world, data, world.wide_rays), ray, world.vehicle_body_id, found)
    wide = float(found[0])
    cast_rays(new_rays(world, data), ray, world.vehicle_body_id, found)
    assert wide < 1.0 < found[0]


def test_ids_of_the_physics_and_of_mujocos_rays_agree(world):
    geom, data = np.zeros(1, np.int32), world.new_data()
    house = nearest_house(SCENE)
    above = np.array([*house.position_enu_m[:2], 60.0])
    mujoco.mj_ray(world.model, data, above, np.array([0.0, 0.0, -1.0]), None, 1, -1, geom)
    assert world.geom_object_id[geom[0]] == NEIGHBOUR_ID
