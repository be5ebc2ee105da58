"""The plant by other ways to know where it is than satellites."""

from collections import deque

import numpy as np
import pytest

from autonomy.types import OFF, ControlLevel, Setpoint
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant
from flightsim.plant.cfg import PlantCfg, PlantError
from flightsim.sensors.failure import Failure
from flightsim.sensors.vio import VioCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.bench.manoeuvres import curves, fly, meadow


@pytest.fixture(scope="module")
def field():
    return build_world(meadow(has_room=False), AIRFRAMES["iris"])


def flown(world, seconds=8.0, **cfg):
    plant = Plant(world, PlantCfg(seed=3, **cfg))
    errors = [
        np.subtract(plant.truth.position_enu_m, plant.estimate.position_enu_m)
        for _ in fly(plant, curves(np.random.default_rng(3)), seconds)
    ]
    return plant, np.linalg.norm(errors, axis=1)


@pytest.mark.parametrize(("aiding", "limit_m"), [("vio", 0.6), ("mocap", 0.004), ("auto", 0.3)])
def test_curves_are_flown_by_every_aiding(field, aiding, limit_m):
    plant, error_m = flown(field, aiding=aiding)
    assert plant.estimator.is_position_valid
    assert np.sqrt(np.mean(error_m**2)) < limit_m
    assert plant.sensors.gnss.fix_type == (6 if aiding == "auto" else 1)


def test_beside_odometry_a_receiver_of_metre_grade_hardly_moves_the_estimate_in_seconds(field):
    plant = Plant(field, PlantCfg(seed=3, aiding="auto", gnss="standard"))
    errors = [
        np.subtract(plant.estimate.position_enu_m, plant.truth.position_enu_m)[:2]
        for _ in fly(plant, curves(np.random.default_rng(3)), 30.0)
    ]
    late = np.array(errors[250:])
    assert np.abs(late[150:] - late[:-150]).max() < 0.25


def test_odometry_keeps_the_position_valid_without_satellites(field):
    plant, _ = flown(field, seconds=2.0, aiding="auto")
    plant.failures.fail_sensor("gnss", Failure.OFF)
    for _ in range(500):
        plant.advance()
    assert plant.estimator.gnss_age_s > 9.0
    assert plant.estimator.is_position_valid


def test_wind_is_estimated_in_flight(field):
    plant = Plant(field, PlantCfg(seed=3, wind=WindCfg.towards((4.0, -3.0, 0.0))))
    deque(fly(plant, curves(np.random.default_rng(3)), 6.0), maxlen=0)
    np.testing.assert_allclose(plant.wind_est_enu_mps, (4.0, -3.0), atol=0.4)


def test_in_a_room_it_starts_where_it_is_told_and_holds_by_odometry():
    scene = meadow(has_room=True, start_enu_m=(18.0, 0.0, 0.02))
    plant = Plant(build_world(scene, AIRFRAMES["iris"]), PlantCfg(seed=1, aiding="auto"))
    plant.apply(OFF)
    for _ in range(100):
        plant.advance()
    assert plant.sensors.gnss.fix_type == 1
    assert plant.sensors.gnss.eph_m == np.inf
    assert plant.estimator.is_position_valid
    plant.apply(
        Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(18.0, 1.0, 2.0), yaw_rad=0.0)
    )
    for _ in range(250):
        plant.advance()
    np.testing.assert_allclose(plant.truth.position_enu_m, (18.0, 1.0, 2.0), atol=0.3)


def test_rates_of_odometry_must_fit(field):
    with pytest.raises(PlantError, match=r"vio\.rate_hz"):
        Plant(field, PlantCfg(seed=0, vio=VioCfg(rate_hz=30)))
