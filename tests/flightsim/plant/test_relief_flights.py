"""Flights over a relief: the air knows the height above the ground, and movers walk on it."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.scene import Relief
from aeroscene.sources import load_scene
from autonomy.types import ControlLevel, Setpoint
from flightsim.environment.motion import start_poses
from flightsim.environment.traffic import TrafficCfg
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, relief_scene

IRIS = airframe_by_name("iris")
RAISED_M = 50.0


def hovered(scene, ground_m):
    """Wind at a vehicle that hovers 6 m above the ground in turbulence, tick by tick."""
    cfg = PlantCfg(seed=4, state="truth", wind=WindCfg(speed_mps=4.0, turbulence_mps=1.5))
    plant, rows = Plant(build_world(scene, IRIS), cfg), []
    place = (0.0, 0.0, ground_m + 6.0)
    for _ in range(400):
        plant.apply(Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=place, yaw_rad=0.0))
        plant.advance()
        rows.append(plant._record["rotors"]["wind_enu_mps"].copy())
    return np.array(rows)


def test_turbulence_goes_by_the_height_above_the_ground():
    level = Relief((-40.0, -40.0), 80.0, np.full((2, 2), RAISED_M))
    # Draws depend on the name of the scene.
    high = replace(relief_scene(level, ceiling_m=90.0), scene_id=empty_scene().scene_id)
    flat, raised = hovered(empty_scene(), 0.0), hovered(high, RAISED_M)
    assert flat.std(axis=0).min() > 0.5
    # The vehicle is not at the same place to the millimetre: the air up there is a little thinner.
    assert np.abs(flat - raised).max() < 0.1


@pytest.mark.parametrize("kind", ["people", "cars"])
def test_movers_go_over_hills_on_the_ground(kind):
    scene = load_scene("hills")
    world = build_world(scene, IRIS, traffic=TrafficCfg(**{kind: 2}, seed=1))
    places = np.concatenate([np.array(mover.path_enu_m) for mover in world.obstacles])
    above_m = places[:, 2] - scene.relief.height_m(places[:, 0], places[:, 1])
    assert len(world.obstacles) == 2
    assert np.ptp(places[:, 2]) > 0.5
    # A mover stands on the highest ground under it.
    assert above_m.min() > 0.0
    assert above_m.max() < 1.0
    assert np.isfinite(start_poses(world.obstacles)[0]).all()
