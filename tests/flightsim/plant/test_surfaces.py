"""Ground and ceiling: found by rays, felt by each rotor for itself."""

import numpy as np
import pytest

from autonomy.types import OFF, ControlLevel, Setpoint
from flightsim.environment.effects import Effects
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.air.ground import ground_share
from flightsim.vehicles.air.inflow import ceiling_ratio
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene, solid

IRIS = AIRFRAMES["iris"]
ROOF = solid("box", (10.0, 0.0, 2.5), (10.0, 10.0, 5.0))  # its western edge at x = 5
CEILING = solid("box", (-10.0, 0.0, 5.5), (6.0, 6.0, 1.0))


@pytest.fixture(scope="module")
def world():
    return build_world(empty_scene(), IRIS, extra=(ROOF, CEILING))


def rotors_at(world, position, **cfg):
    """Record of the rotors after a tick at a place, level."""
    plant = Plant(world, PlantCfg(seed=0, **cfg))
    plant.data.qpos[:3] = position
    plant.data.qpos[3:7] = (1.0, 0.0, 0.0, 0.0)
    plant.advance()
    return plant._record["rotors"]


def test_rotors_over_the_edge_of_a_roof_have_no_ground(world):
    r = rotors_at(world, (5.0, 0.0, 5.3))
    is_over = r["position_flu_m"][:4, 0] > 0.0
    height_m = 0.3 + r["position_flu_m"][0, 2]
    expected = ground_share(height_m, r["radius_m"], r["neighbour_m"], r["opposite_m"])
    np.testing.assert_allclose(r["ground_share"][:4][is_over], expected, rtol=1e-3)
    np.testing.assert_array_equal(r["ground_share"][:4][~is_over], 0.0)
    assert expected > 0.04


def test_high_up_and_without_the_effect_there_is_none(world):
    for r in (
        rotors_at(world, (10.0, 0.0, 8.0)),
        rotors_at(world, (10.0, 0.0, 5.2), effects=Effects.without("ground")),
    ):
        np.testing.assert_array_equal(r["ground_share"], 0.0)


def test_a_ceiling_is_felt_by_its_gap(world):
    r = rotors_at(world, (-10.0, 0.0, 4.9))
    gap_m = 0.1 - r["position_flu_m"][0, 2]
    expected = ceiling_ratio(gap_m, r["radius_m"])
    np.testing.assert_allclose(r["ceiling_ratio"][:4], expected, rtol=1e-2)
    r = rotors_at(world, (-10.0, 0.0, 4.9), effects=Effects.without("ceiling"))
    np.testing.assert_array_equal(r["ceiling_ratio"], 1.0)


def test_a_surface_that_comes_near_in_flight_is_noticed(world):
    plant = Plant(world, PlantCfg(seed=0, state="truth"))
    r, shares = plant._record["rotors"], []
    plant.apply(
        Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(0.0, 0.0, 4.0), yaw_rad=0.0)
    )
    for _ in range(250):
        plant.advance()
    assert r["ground_share"].max() == 0.0
    plant.apply(
        Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(0.0, 0.0, 0.2), yaw_rad=0.0)
    )
    speeds = [np.mean(plant.rotor_speeds_radps)]
    for _ in range(300):
        plant.advance()
        shares.append(r["ground_share"][:4].mean())
        speeds.append(np.mean(plant.rotor_speeds_radps))
    # It hovers 0.2 m above ground with less rotor speed, by the root of the thrust's gain.
    expected = speeds[0] * np.sqrt(1.0 - shares[-1])
    assert shares[-1] > 0.06
    assert speeds[-1] == pytest.approx(expected, rel=0.01)
    plant.apply(OFF)
