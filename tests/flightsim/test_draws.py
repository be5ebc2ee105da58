"""Random draws: another scene, seed or stream gives others, and all have the stated spread."""

import dataclasses

import numpy as np
import pytest

from flightsim.draws import generator, seed_sequence
from flightsim.plant import Plant, PlantCfg
from flightsim.sensors.gnss import STANDARD
from flightsim.sensors.imu import ADIS16448
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

N_SCENES = 200


def test_the_same_three_give_the_same_draws():
    first, again = (generator(3, "42", "depth", "down", 20_000).normal(size=4) for _ in range(2))
    np.testing.assert_array_equal(first, again)


@pytest.mark.parametrize(
    "other",
    [(4, "42", "depth", 1), (3, "43", "depth", 1), (3, "42", "gnss", 1), (3, "42", "depth", 2)],
)
def test_each_of_the_three_matters(other):
    first = seed_sequence(3, "42", "depth", 1).generate_state(4)
    assert not np.isin(seed_sequence(*other).generate_state(4), first).any()


def test_parts_of_a_name_do_not_run_into_each_other():
    first, second = seed_sequence(0, "4", "2"), seed_sequence(0, "42")
    assert first.generate_state(1)[0] != second.generate_state(1)[0]


def test_with_one_seed_biases_spread_over_scenes_as_each_sensor_states():
    world = build_world(empty_scene(), AIRFRAMES["iris"])
    drifts_m, gyro_radps = [], []
    for number in range(N_SCENES):
        scene = dataclasses.replace(world.scene, scene_id=f"aeroscene-{number:04d}")
        elsewhere = dataclasses.replace(world, scene=scene)
        plant = Plant(elsewhere, PlantCfg(seed=0, gnss="standard", imu="adis16448"))
        drifts_m.append(plant._record["gnss"]["drift_enu_m"].copy())
        gyro_radps.append(plant._record["imu"]["gyro_bias_flu_radps"].copy())
    horizontal_m, vertical_m = STANDARD.drift_sigma_m
    for draws, sigma in (
        (drifts_m, (horizontal_m, horizontal_m, vertical_m)),
        (gyro_radps, (ADIS16448.gyro_turn_on_sigma_radps,) * 3),
    ):
        shares = np.array(draws) / sigma
        # Three standard errors of the mean, of the deviation and of a correlation.
        assert np.abs(shares.mean(axis=0)).max() < 3.0 / np.sqrt(N_SCENES)
        assert np.abs(shares.std(axis=0) - 1.0).max() < 3.0 / np.sqrt(2 * N_SCENES)
        between = np.corrcoef(shares.T)[np.triu_indices(3, 1)]
        assert np.abs(between).max() < 3.0 / np.sqrt(N_SCENES)
