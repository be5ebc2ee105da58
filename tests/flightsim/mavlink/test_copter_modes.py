"""What ArduCopter 4.5 answers to SET_MODE, CIRCLE, and the terrain bit of SYS_STATUS."""

import math

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from tests.flightsim.mavlink.test_personalities import copter, fly, heartbeat, set_mode
from tests.flightsim.mavlink.wire import named

__all__ = ["copter"]

_SET_MODE, _CUSTOM = 11, 1
_GUIDED, _LOITER, _CIRCLE, _AUTO, _NO_MODE = 4, 5, 7, 3, 99
_TERRAIN = 1 << 22


@pytest.mark.parametrize(
    ("base_mode", "number", "result"),
    [
        (_CUSTOM, _LOITER, mav.MAV_RESULT_ACCEPTED),
        (_CUSTOM, _NO_MODE, mav.MAV_RESULT_FAILED),
        (_CUSTOM, _AUTO, mav.MAV_RESULT_FAILED),  # no mission
        (0, _LOITER, mav.MAV_RESULT_DENIED),
    ],
)
def test_set_mode_is_acknowledged_by_the_number_of_the_message(copter, base_mode, number, result):
    copter.become_ready()
    copter.send("SET_MODE", 1, base_mode, number)
    (ack,) = named(copter.step(2), "COMMAND_ACK")
    assert (ack.command, ack.result) == (_SET_MODE, result)
    assert (ack.target_system, ack.target_component) == (255, 190)
    words = ("SET_MODE", "no valid mission")
    texts = [m.text for m in named(copter.heard, "STATUSTEXT")]
    is_explained = any(word in text for word in words for text in texts)
    assert is_explained is (result != mav.MAV_RESULT_ACCEPTED)


def test_px4_does_not_acknowledge_set_mode_but_says_what_is_wrong(flight):
    flight.send("SET_MODE", 1, _CUSTOM, _NO_MODE)
    came = flight.step(2)
    assert named(came, "COMMAND_ACK") == []
    assert "SET_MODE denied" in "".join(m.text for m in named(came, "STATUSTEXT"))


def test_a_circle_is_flown_about_the_point_ahead_of_the_nose(copter):
    copter.become_ready()
    assert set_mode(copter, _CIRCLE) == mav.MAV_RESULT_FAILED  # on the ground
    fly(copter)
    start, yaw_rad = copter.plant.truth.position_enu_m, copter.autopilot._vehicle.yaw_rad
    centre = (start[0] + 10.0 * math.cos(yaw_rad), start[1] + 10.0 * math.sin(yaw_rad))
    assert set_mode(copter, _CIRCLE) == mav.MAV_RESULT_ACCEPTED
    assert heartbeat(copter).custom_mode == _CIRCLE
    assert copter.autopilot.mode is Mode.ORBIT
    copter.skip(12.0)
    here = copter.plant.truth.position_enu_m
    assert math.dist(here[:2], centre) == pytest.approx(10.0, abs=0.7)
    assert math.dist(here, start) > 5.0
    assert set_mode(copter, _GUIDED) == mav.MAV_RESULT_ACCEPTED


def test_copters_report_terrain_and_px4_does_not(copter, flight):
    for vehicle, is_there in ((copter, True), (flight, False)):
        vehicle.run(2.5)
        status = vehicle.last("SYS_STATUS")
        for bits in (
            status.onboard_control_sensors_present,
            status.onboard_control_sensors_enabled,
            status.onboard_control_sensors_health,
        ):
            assert bool(bits & _TERRAIN) is is_there
