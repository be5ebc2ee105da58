"""Wind and traffic by parameter, while flying."""

import pytest

from aeroscene.sources import load_scene
from flightsim.autopilot.parameters import ParameterValueError
from flightsim.environment.traffic import TrafficError
from flightsim.environment.wind import WindError
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.testbench.cfg import TestbenchError


@pytest.fixture
def bench():
    cfg = TestbenchCfg(
        speed="max",
        wind=4.0,
        wind_from=90.0,
        turbulence="light",
        traffic="people=1",
        without="shelter",
    )
    with Testbench(load_scene("42"), cfg, has_network=False) as bench:
        yield bench


def test_parameters_begin_as_the_options_say(bench):
    values = bench.autopilot.parameters
    assert values["SIM_WIND_SPD"] == 4.0
    assert values["SIM_WIND_DIR"] == 90.0
    assert values["SIM_WIND_TURB"] == pytest.approx(0.7717, abs=1e-3)
    assert values["SIM_TRAFFIC_SPD"] == 1.0
    assert len(bench.plant.obstacles_true) == 1


def test_the_air_follows_the_parameters(bench):
    pilot, plant = bench.autopilot, bench.plant
    pilot.parameters.set("SIM_WIND_TURB", 0.0)
    pilot.parameters.set("SIM_WIND_DIR", 180.0)
    pilot.parameters.set("SIM_WIND_SPD", 7.0)
    bench.simulator.step()
    assert plant.air_velocity_true_enu_mps == pytest.approx((0.0, 7.0, 0.0), abs=1e-9)
    pilot.parameters.set("SIM_WIND_GUST", 2.0)
    assert plant.wind.gust_mps == 2.0
    with pytest.raises(ParameterValueError, match="0 to 30 m/s"):
        pilot.parameters.set("SIM_WIND_SPD", 31.0)


def test_the_traffic_follows_its_parameter(bench):
    bench.autopilot.parameters.set("SIM_TRAFFIC_SPD", 0.0)
    assert bench.plant.traffic_speed == 0.0


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"wind": 31.0}, TestbenchError),
        ({"turbulence": "wild"}, WindError),
        ({"gust": -1.0}, TestbenchError),
        ({"traffic": "dogs=1"}, TrafficError),
    ],
)
def test_impossible_options_are_refused_before_anything_is_built(options, error):
    with pytest.raises(error, match="valid"):
        TestbenchCfg(**options)
