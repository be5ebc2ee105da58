"""Failure injection."""

import pytest

from flightsim.mavlink.dialect import dialect as mav
from tests.flightsim.mavlink.wire import named

GPS, MAG, MOTOR = 4, 2, 101
OK, OFF, STUCK = 0, 1, 2


def inject(flight, *params):
    return flight.command(mav.MAV_CMD_INJECT_FAILURE, *params)


def test_nothing_fails_unless_the_parameter_allows_it(flight):
    flight.become_ready()
    assert inject(flight, GPS, OFF) == mav.MAV_RESULT_TEMPORARILY_REJECTED
    flight.skip(2.0)
    assert flight.autopilot.health.is_gnss_ok


def test_a_receiver_fails_and_works_again(flight):
    flight.become_ready()
    flight.autopilot.parameters.set("SYS_FAILURE_EN", 1)
    assert inject(flight, GPS, OFF) == 0
    flight.skip(2.0)
    assert not flight.autopilot.health.is_gnss_ok
    assert inject(flight, GPS, OK) == 0
    flight.skip(2.0)
    assert flight.autopilot.health.is_gnss_ok


@pytest.mark.parametrize("unit", [0, 1, MOTOR, 106, -1, 1e9])
def test_a_part_that_cannot_fail_here_is_told_as_unsupported(flight, unit):
    flight.autopilot.parameters.set("SYS_FAILURE_EN", 1)
    assert inject(flight, unit, OFF) == mav.MAV_RESULT_UNSUPPORTED


def test_a_kind_or_an_instance_that_there_is_not_is_refused(flight):
    flight.autopilot.parameters.set("SYS_FAILURE_EN", 1)
    assert inject(flight, MAG, STUCK) == mav.MAV_RESULT_UNSUPPORTED
    assert inject(flight, MAG, OFF, 2) == mav.MAV_RESULT_DENIED


def test_sticks_whose_signal_fails_return_the_vehicle(flight):
    flight.take_off(6.0)
    flight.autopilot.parameters.set("SYS_FAILURE_EN", 1)
    flight.autopilot.parameters.set("NAV_RCL_ACT", 3)
    for tick in range(150):
        if tick == 75:
            assert inject(flight, 104, OFF) == 0
        flight.send("MANUAL_CONTROL", 1, 0, 0, 500, 0, 0)
        flight.step()
    texts = "".join(m.text for m in named(flight.heard, "STATUSTEXT"))
    assert "manual control lost, switching to Land" in texts
