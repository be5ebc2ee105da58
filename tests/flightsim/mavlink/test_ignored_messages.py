"""What changes nothing is said to its sender, once for each kind of message."""

import math

import pytest

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.ignored_messages import _REASONS
from flightsim.payload import PayloadCfg
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.test_personalities import copter
from tests.flightsim.mavlink.wire import Wire, named

__all__ = ["copter"]


def _texts(messages):
    return "".join(m.text for m in named(messages, "STATUSTEXT"))


def test_every_reason_is_of_a_message_that_exists_and_is_not_handled(flight):
    for name in _REASONS:
        handled = LAYOUTS[name].message_id in flight.server._handlers if name in LAYOUTS else False
        assert name == "ACTUATOR_CONTROL_TARGET" or name in LAYOUTS, name
        assert not handled, name


def test_a_message_without_a_service_is_answered_by_one_text(flight):
    for _ in range(3):
        flight.send("SET_ACTUATOR_CONTROL_TARGET", 0, 0, 1, 1, [0.0] * 8)
    came = flight.step(3)
    text = _texts(came)
    assert text.count("SET_ACTUATOR_CONTROL_TARGET is ignored: valid are setpoints") == 1
    flight.send("GPS_RTCM_DATA", 0, 4, [0] * 180)
    assert "GPS_RTCM_DATA is ignored" in _texts(flight.step(2))
    flight.send("PARAM_EXT_REQUEST_LIST", 1, 1)
    assert "PARAM_EXT_REQUEST_LIST is ignored: this vehicle does not use it" in _texts(
        flight.step(2)
    )


def test_telemetry_of_others_and_answers_are_taken_without_a_word(flight):
    flight.wire = Wire(system_id=7, component_id=1)
    flight.send("ATTITUDE", 0, 0, 0, 0, 0, 0, 0)
    flight.send("DISTANCE_SENSOR", *(0, 1, 100, 50, 0, 0, 25, 255))
    flight.send("COMMAND_ACK", 400, 0)
    flight.send("ODOMETRY", *(0, 1, 12, 50.0, 0, 0, [1, 0, 0, 0], *[0] * 6), [0] * 21, [0] * 21)
    assert _texts(flight.run(0.5)) == ""
    assert not flight.plant.external_aids.is_fed_poses


def test_a_component_says_what_it_ignores(field):
    flight = Flight(field, payload=PayloadCfg())
    try:
        flight.send("PARAM_EXT_REQUEST_LIST", 1, 100)
        came = flight.step(3)
        assert "PARAM_EXT_REQUEST_LIST is ignored: component 100: " in _texts(came)
    finally:
        flight.close()


@pytest.mark.parametrize(
    ("name", "values", "reason"),
    [
        (
            "SET_POSITION_TARGET_LOCAL_NED",
            (0, 1, 1, 3, 0, *[0.0] * 11),
            "frame 3; valid are 1, 7, 8, 9, 12",
        ),
        ("SET_ATTITUDE_TARGET", (0, 1, 1, 0, [0, 0, 0, 0], 0, 0, 0, 0.5), "q is no attitude"),
        ("FOLLOW_TARGET", (0, 0, 0, 0, 0, *[[0.0] * n for n in (3, 3, 4, 3, 3)], 0), "no position"),
        ("LANDING_TARGET", (0, 0, 8, math.nan, 0, 0, 0, 0), "no position in frame 1 or 12"),
        ("OBSTACLE_DISTANCE", (0, 0, [0] * 72, 0, 1, 100), "step of 0 deg"),
    ],
)
def test_a_stream_that_is_dropped_whole_is_told(flight, name, values, reason):
    flight.send(name, *values)
    flight.send(name, *values)
    assert _texts(flight.step(3)).count(f"{name} is ignored: {reason}") == 1


def test_setpoints_to_a_copter_that_does_not_fly_are_told(copter):
    copter.send("SET_POSITION_TARGET_LOCAL_NED", 0, 1, 1, 1, 0xDF8, 5.0, 0.0, -14.0, *[0.0] * 8)
    text = "SET_POSITION_TARGET_LOCAL_NED is ignored: not flying in guided mode"
    assert text in _texts(copter.step(3))
    assert mav.MAV_COMP_ID_AUTOPILOT1 == 1
