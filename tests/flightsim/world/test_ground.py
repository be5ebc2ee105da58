"""The ground of a world over a relief: vehicles rest on it, and it goes on beyond the grid."""

import math

import mujoco
import numpy as np
import pytest

from aeroscene.scene import Relief
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import GROUND_ID, build_world
from flightsim.world.geometry import SurfaceProbe
from tests.flightsim.handmade import empty_scene, hills, incline, relief_scene, solid

IRIS = airframe_by_name("iris")


def finely(relief):
    """The same surface by nodes a metre apart, so that the legs stand in several cells."""
    line = np.arange(-40.0, 40.5, 1.0)
    return Relief((-40.0, -40.0), 1.0, relief.height_m(line[None, :], line[:, None]))


@pytest.mark.parametrize("slope_deg", [0.0, 5.0, 12.0])
def test_an_iris_that_falls_onto_a_slope_rests_on_it(slope_deg):
    gradient = math.tan(math.radians(slope_deg))
    relief = finely(incline(0.6 * gradient, -0.8 * gradient))
    plant = Plant(build_world(relief_scene(relief), IRIS), PlantCfg(seed=0, state="truth"))
    x, y = 5.3, 4.1
    plant.data.qpos[:3] = (x, y, float(relief.height_m(x, y)) + 0.5)
    for _ in range(200):
        plant.advance()
    before = plant.data.qpos[:3].copy()
    for _ in range(50):
        plant.advance()
    place, quat = plant.data.qpos[:3], plant.data.qpos[3:7]
    up = np.empty(3)
    mujoco.mju_rotVecQuat(up, np.array([0.0, 0.0, 1.0]), quat)
    np.testing.assert_allclose(up, relief.normal_enu(x, y), atol=0.005)
    assert np.linalg.norm(place - before) < 0.002
    above_m = (place[2] - relief.height_m(*place[:2])) * math.cos(math.radians(slope_deg))
    assert above_m == pytest.approx(IRIS.leg_length_m, abs=0.003)
    assert np.hypot(place[0] - x, place[1] - y) < 0.05


@pytest.mark.parametrize("place", [(-300.0, 12.0), (700.0, -5.5), (3.0, 1500.0), (-900.0, 900.0)])
def test_beyond_the_grid_a_vehicle_rests_on_the_continued_ground(place):
    relief = hills()
    world = build_world(relief_scene(relief), IRIS)
    data = world.new_data()
    height_m = float(relief.height_m(*place))
    data.qpos[:3] = (*place, height_m + 0.3)
    for _ in range(1500):
        mujoco.mj_step(world.model, data)
    assert data.qpos[2] - float(relief.height_m(*data.qpos[:2])) == pytest.approx(0.11, abs=0.03)
    touched = {int(g) for contact in data.contact for g in contact.geom}
    assert GROUND_ID in world.geom_object_id[list(touched)]


def test_geoms_of_the_ground_are_known_as_such_and_solids_keep_their_places():
    block = solid("box", (8.0, 8.0, 3.0), (1.0, 1.0, 6.0), object_id=7)
    flat = build_world(empty_scene(), IRIS, extra=(block,))
    hilly = build_world(relief_scene(hills()), IRIS, extra=(block,))
    for world in (flat, hilly):
        assert world.geom_object_id[:2].tolist() == [GROUND_ID, 7]
    assert np.count_nonzero(flat.geom_object_id == GROUND_ID) == 1
    assert np.count_nonzero(hilly.geom_object_id == GROUND_ID) == 9
    assert np.count_nonzero(hilly.geom_object_id == -1) == np.count_nonzero(
        flat.geom_object_id == -1
    )


def test_a_probe_finds_the_ground_and_what_stands_on_it():
    relief = hills()
    probe = SurfaceProbe(relief, [solid("box", (8.0, 8.0, 3.0), (1.0, 1.0, 6.0))])
    points = np.array([(8.0, 8.0, 20.0), (-11.3, 4.7, 20.0), (90.0, 3.3, 20.0)])
    heights_m, hit = probe.surfaces(points)
    expected = [6.0, *relief.height_m(points[1:, 0], points[1:, 1])]
    np.testing.assert_allclose(heights_m, expected, atol=1e-5)
    assert hit.tolist() == [1, 0, 0]
