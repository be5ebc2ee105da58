"""What a client is told of six motors: kind, outputs, speed controllers, tests and failures."""

import math
import re

import pytest

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.vehicle_type import vehicle_parameters, vehicle_type
from flightsim.sensors.failure import Failure
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

TYPHOON = AIRFRAMES["typhoon"]
ACTUATOR_TEST, MOTOR_TEST = mav.MAV_CMD_ACTUATOR_TEST, mav.MAV_CMD_DO_MOTOR_TEST
RIGHT, LEFT, FRONT_LEFT, REAR_RIGHT, FRONT_RIGHT, REAR_LEFT = range(6)


@pytest.fixture(scope="module")
def world():
    return build_world(empty_scene(), TYPHOON)


@pytest.fixture
def flight(world):
    flight = Flight(world)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    yield flight
    flight.close()


def asked(flight, name):
    """All parts of a message on request."""
    flight.send("COMMAND_LONG", 1, 1, 512, 0, layout(name).message_id, *(0.0,) * 6)
    return named(flight.step(), name)


def test_it_is_a_hexarotor(flight):
    flight.run(1.1)
    assert flight.last("HEARTBEAT").type == mav.MAV_TYPE_HEXAROTOR
    assert vehicle_type(AIRFRAMES["crazyflie"]) == mav.MAV_TYPE_QUADROTOR
    assert vehicle_parameters(AIRFRAMES["iris"]) == {"MAV_TYPE": 2}


def test_its_parameters_say_so_too():
    bench = Testbench(empty_scene(), TestbenchCfg(vehicle="typhoon"), has_network=False)
    with bench:
        parameters = bench.autopilot.parameters
        assert (parameters["MAV_TYPE"], parameters["SYS_AUTOSTART"]) == (13, 6001)
        assert parameters["BAT1_N_CELLS"] == 4


def test_each_motor_has_an_output_and_a_speed_controller(flight):
    flight.take_off(3.0)
    output = asked(flight, "SERVO_OUTPUT_RAW")[-1]
    pulses = [getattr(output, f"servo{number}_raw") for number in range(1, 17)]
    assert min(pulses[:6]) > 1300
    assert pulses[6:] == [0] * 10
    first, second = asked(flight, "ESC_STATUS")
    assert (first.index, second.index) == (0, 4)
    rpm = [*first.rpm, *second.rpm]
    hover = TYPHOON.quadrotor.hover_speed_radps * 30.0 / math.pi
    assert rpm[:6] == pytest.approx([hover] * 6, rel=0.15)
    assert rpm[6:] == [0, 0]
    infos = asked(flight, "ESC_INFO")
    assert [(info.index, info.count, info.info) for info in infos] == [(0, 6, 63), (4, 6, 63)]


@pytest.mark.parametrize("motor", [1, 5, 6])
def test_a_motor_is_tested_by_its_number(flight, motor):
    assert flight.command(ACTUATOR_TEST, 0.2, 1.0, 0, 0, motor) == 0
    flight.step(2)
    speeds = flight.plant.rotor_speed_commands_radps
    assert [i for i, speed in enumerate(speeds) if speed > 0.0] == [motor - 1]
    assert flight.command(ACTUATOR_TEST, 0.2, 1.0, 0, 0, 7) == mav.MAV_RESULT_UNSUPPORTED


def test_motors_are_tested_clockwise_where_the_sequence_is_asked_for(flight):
    turned = []
    assert flight.command(MOTOR_TEST, 1, 0, 20.0, 0.2, 6, mav.MOTOR_TEST_ORDER_SEQUENCE) == 0
    for _ in range(60):
        flight.step()
        speeds = flight.plant.rotor_speed_commands_radps
        turned += [i for i, speed in enumerate(speeds) if speed > 0.0 and i not in turned]
    assert turned == [FRONT_RIGHT, RIGHT, REAR_RIGHT, REAR_LEFT, LEFT, FRONT_LEFT]


def test_a_failed_motor_is_told_and_flown_without(flight):
    flight.take_off(10.0)
    flight.autopilot.parameters.set("SYS_FAILURE_EN", 1)
    flight.autopilot.parameters.set("COM_ACT_FAIL_ACT", 0)
    answer = flight.command(mav.MAV_CMD_INJECT_FAILURE, 101, Failure.OFF, 7)
    assert answer == mav.MAV_RESULT_DENIED
    assert flight.command(mav.MAV_CMD_INJECT_FAILURE, 101, Failure.OFF, 4) == 0
    before = flight.plant.truth.position_enu_m
    flight.run(8.0)
    truth = flight.plant.truth
    assert flight.plant.lost_rotors == (REAR_RIGHT,)
    assert asked(flight, "ESC_INFO")[0].info == 0b110111
    assert math.dist(before, truth.position_enu_m) < 1.0
    assert abs(truth.angular_rate_flu_radps[2]) < 8.0, "on three rotors it were 30 rad/s"
    assert any(re.search("otor", m.text) for m in named(flight.heard, "STATUSTEXT"))
