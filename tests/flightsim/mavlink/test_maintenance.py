"""Motor tests, calibration and reboot, on the ground only."""

import math

import pytest

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.personalities import PERSONALITIES
from flightsim.sensors.failure import Failure
from flightsim.vehicles.catalogue import AIRFRAMES
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

ACTUATOR_TEST, MOTOR_TEST = mav.MAV_CMD_ACTUATOR_TEST, mav.MAV_CMD_DO_MOTOR_TEST
FRONT_RIGHT, REAR_LEFT, FRONT_LEFT, REAR_RIGHT = 0, 1, 2, 3  # rotors of the Iris
PERCENT, PWM, PILOT = 0, 1, 2


def turning(flight):
    """Rotors that are driven."""
    return [i for i, speed in enumerate(flight.plant.rotor_speed_commands_radps) if speed > 0.0]


def texts(flight):
    return [m.text for m in named(flight.heard, "STATUSTEXT")]


@pytest.mark.parametrize(
    ("motor", "rotor"),
    [(1, FRONT_RIGHT), (2, REAR_LEFT), (3, FRONT_LEFT), (4, REAR_RIGHT)],
)
def test_an_actuator_test_turns_one_motor_for_its_time(flight, motor, rotor):
    assert flight.command(ACTUATOR_TEST, 0.2, 1.0, 0, 0, motor) == 0
    flight.step(2)
    assert turning(flight) == [rotor]
    flight.skip(0.8)
    most = flight.plant.world.airframe.quadrotor.rotors[rotor].max_speed_radps
    assert flight.plant.rotor_speeds_radps[rotor] == pytest.approx(0.2 * most, rel=0.02)
    flight.skip(0.4)
    assert turning(flight) == []


def test_an_actuator_test_is_ended_by_a_value_that_is_none(flight):
    assert flight.command(ACTUATOR_TEST, 0.2, 60.0, 0, 0, 1) == 0
    flight.step(2)
    assert turning(flight) == [FRONT_RIGHT]
    assert flight.command(ACTUATOR_TEST, math.nan, 0.0, 0, 0, 1) == 0
    flight.step(2)
    assert turning(flight) == []


@pytest.mark.parametrize("function", [0, 5, 33, 1000, -1, 1.5])
def test_an_actuator_that_is_not_there_is_told_as_unsupported(flight, function):
    answer = flight.command(ACTUATOR_TEST, 0.2, 1.0, 0, 0, function)
    assert answer == mav.MAV_RESULT_UNSUPPORTED


@pytest.mark.parametrize("params", [(-0.5, 1.0), (1.5, 1.0), (0.2, -1.0), (0.2, 1e9)])
def test_a_test_out_of_range_is_denied(flight, params):
    assert flight.command(ACTUATOR_TEST, *params, 0, 0, 1) == mav.MAV_RESULT_DENIED
    flight.step(2)
    assert turning(flight) == []


@pytest.mark.parametrize(
    ("name", "number", "order", "rotor"),
    [
        ("px4", 2, 0, REAR_LEFT),
        ("ardupilot", 2, 0, REAR_RIGHT),
        ("ardupilot", 4, 0, FRONT_LEFT),
        ("ardupilot", 2, 2, REAR_LEFT),
        ("px4", 2, 1, REAR_RIGHT),
    ],
)
def test_motors_are_numbered_as_by_the_flight_stack(field, name, number, order, rotor):
    flight = Flight(field, PERSONALITIES[name])
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    assert flight.command(MOTOR_TEST, number, PERCENT, 15, 1.0, 1, order) == 0
    flight.step(2)
    assert turning(flight) == [rotor]
    flight.server.close()


def test_several_motors_turn_one_after_the_other(flight):
    assert flight.command(MOTOR_TEST, 1, PWM, 1150, 0.5, 3, 1) == 0
    seen = [[]]
    for _ in range(100):
        flight.step()
        seen += [turning(flight)] if turning(flight) != seen[-1] else []
    assert seen == [[], [FRONT_RIGHT], [REAR_RIGHT], [REAR_LEFT], []]


@pytest.mark.parametrize(
    ("params", "answer"),
    [
        ((1, PILOT, 15, 1.0), mav.MAV_RESULT_UNSUPPORTED),
        ((5, PERCENT, 15, 1.0), mav.MAV_RESULT_DENIED),
        ((0, PERCENT, 15, 1.0), mav.MAV_RESULT_DENIED),
        ((3, PERCENT, 15, 1.0, 3), mav.MAV_RESULT_DENIED),
        ((1, PERCENT, 150, 1.0), mav.MAV_RESULT_DENIED),
        ((1, PERCENT, 15, 1.0, 1, 7), mav.MAV_RESULT_UNSUPPORTED),
    ],
)
def test_motor_tests_that_make_no_sense_are_refused(flight, params, answer):
    assert flight.command(MOTOR_TEST, *params) == answer
    flight.step(2)
    assert turning(flight) == []


def test_an_armed_vehicle_tests_no_motors_and_arming_ends_a_test(flight):
    flight.become_ready()
    assert flight.command(ACTUATOR_TEST, 0.2, 60.0, 0, 0, 1) == 0
    flight.step(2)
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    assert flight.command(ACTUATOR_TEST, 0.2, 1.0, 0, 0, 1) == mav.MAV_RESULT_DENIED
    assert flight.command(MOTOR_TEST, 1, PERCENT, 15, 1.0) == mav.MAV_RESULT_DENIED
    assert any("the vehicle is armed" in text for text in texts(flight))
    assert flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 0) == 0
    flight.step(2)
    assert turning(flight) == []


def test_motor_tests_can_be_forbidden(flight):
    flight.autopilot.parameters.set("COM_MOT_TEST_EN", 0)
    assert flight.command(ACTUATOR_TEST, 0.2, 1.0, 0, 0, 1) == mav.MAV_RESULT_DENIED


def test_a_test_that_lifts_the_vehicle_is_ended(flight):
    flight.become_ready()
    for motor in range(1, 5):
        assert flight.command(ACTUATOR_TEST, 0.9, 60.0, 0, 0, motor) == 0
    flight.run_until(lambda: turning(flight) == [], 5.0)
    assert flight.plant.truth.position_enu_m[2] < 1.5


def requested(flight, name):
    """A message on request."""
    flight.send("COMMAND_LONG", 1, 1, 512, 0, layout(name).message_id, *(0.0,) * 6)
    (message,) = named(flight.step(), name)
    return message


def test_speed_controllers_report_the_motor_that_turns(flight):
    assert flight.command(ACTUATOR_TEST, 0.3, 60.0, 0, 0, 3) == 0
    flight.skip(1.0)
    status = requested(flight, "ESC_STATUS")
    most = flight.plant.world.airframe.quadrotor.rotors[FRONT_LEFT].max_speed_radps
    assert status.rpm == pytest.approx([0, 0, 0.3 * most * 30.0 / math.pi, 0], rel=0.02)
    assert status.current[2] > 0.1 > status.current[0]
    assert all(11.0 < voltage < 13.0 for voltage in status.voltage)
    info = requested(flight, "ESC_INFO")
    assert (info.count, info.info) == (4, 0b1111)


def test_speed_controllers_report_the_motor_that_is_lost(flight):
    flight.take_off(3.0)
    flight.plant.failures.fail_rotor(REAR_LEFT, Failure.OFF)
    flight.skip(2.0)
    assert requested(flight, "ESC_INFO").info == 0b1101
    front_right, rear_left, *_ = requested(flight, "ESC_STATUS").rpm
    assert rear_left < 0.1 * front_right


def test_a_plus_frame_has_its_motors_right_left_front_rear():
    assert AIRFRAMES["hummingbird"].motors == (3, 1, 0, 2)
    assert AIRFRAMES["hummingbird"].rotors_clockwise == (0, 3, 2, 1)
    assert AIRFRAMES["iris"].motors == (FRONT_RIGHT, REAR_LEFT, FRONT_LEFT, REAR_RIGHT)


@pytest.mark.parametrize(
    ("params", "name"),
    [((1,), "gyro"), ((0, 0, 1), "baro"), ((0, 0, 0, 0, 2), "level"), ((0, 0, 0, 0, 4), "accel")],
)
def test_a_calibration_at_rest_is_told_in_the_words_that_sdks_read(flight, params, name):
    flight.become_ready()
    flight.heard.clear()
    assert flight.command(mav.MAV_CMD_PREFLIGHT_CALIBRATION, *params) == 0
    flight.step()
    said = [text for text in texts(flight) if text.startswith("[cal]")]
    assert said[0] == f"[cal] calibration started: 2 {name}"
    assert said[1:-1] == [f"[cal] progress <{percent}>" for percent in (0, 50, 100)]
    assert said[-1] == f"[cal] calibration done: {name}"


@pytest.mark.parametrize(
    ("params", "answer"),
    [
        ((0, 1), mav.MAV_RESULT_DENIED),
        ((0, 0, 0, 0, 1), mav.MAV_RESULT_DENIED),
        ((0, 0, 0, 1), mav.MAV_RESULT_UNSUPPORTED),
        ((7,), mav.MAV_RESULT_UNSUPPORTED),
        ((), mav.MAV_RESULT_ACCEPTED),
    ],
)
def test_a_calibration_that_cannot_be_is_answered(flight, params, answer):
    assert flight.command(mav.MAV_CMD_PREFLIGHT_CALIBRATION, *params) == answer


def test_maintenance_is_for_the_ground(flight):
    flight.take_off(2.0)
    rejected = mav.MAV_RESULT_TEMPORARILY_REJECTED
    assert flight.command(mav.MAV_CMD_PREFLIGHT_CALIBRATION, 1) == rejected
    assert flight.command(mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1) == rejected
    assert flight.autopilot.is_armed


def test_a_reboot_begins_again_and_keeps_what_a_vehicle_keeps(flight):
    flight.become_ready()
    flight.autopilot.parameters.set("MIS_TAKEOFF_ALT", 7.0)
    assert flight.command_int(mav.MAV_CMD_DO_SET_HOME, 0, 0, 0, 0, 0, 474001000, 85001000, 500) == 0
    moved = flight.autopilot.home
    assert flight.command(mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1) == 0
    assert flight.autopilot.home is None
    flight.skip(1.0)
    assert flight.autopilot.home is not None
    assert flight.autopilot.home != moved
    assert flight.autopilot.parameters["MIS_TAKEOFF_ALT"] == 7.0


@pytest.mark.parametrize("param1", [2, 3, 0.5])
def test_the_testbench_is_not_shut_down_by_a_client(flight, param1):
    answer = flight.command(mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, param1)
    assert answer == mav.MAV_RESULT_UNSUPPORTED


def test_there_is_nothing_to_tune(flight):
    assert flight.command(mav.MAV_CMD_DO_AUTOTUNE_ENABLE, 1) == mav.MAV_RESULT_UNSUPPORTED
    assert any("nothing to tune" in text for text in texts(flight))
