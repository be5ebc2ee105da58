"""Failure injection by command: what is accepted, what is refused, and that it acts."""

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from flightsim.sensors.failure import Failure
from tests.flightsim.mavlink.wire import named

GYRO, MAG, GPS, OPTICAL_FLOW, VIO = 0, 2, 4, 5, 6
BATTERY, MOTOR, SERVO, RC, MAVLINK = 100, 101, 102, 104, 105
OK, OFF, STUCK, GARBAGE, INTERMITTENT = 0, 1, 2, 3, 7


def inject(flight, *params):
    return flight.command(mav.MAV_CMD_INJECT_FAILURE, *params)


@pytest.fixture
def failing(flight):
    flight.autopilot.parameters.set("SYS_FAILURE_EN", 1)
    return flight


def test_nothing_fails_unless_the_parameter_allows_it(flight):
    flight.become_ready()
    assert inject(flight, GPS, OFF) == mav.MAV_RESULT_DENIED
    flight.skip(2.0)
    assert flight.autopilot.health.is_gnss_ok


def test_a_receiver_fails_and_works_again(failing):
    failing.become_ready()
    assert inject(failing, GPS, OFF) == 0
    failing.skip(2.0)
    assert not failing.autopilot.health.is_gnss_ok
    assert inject(failing, GPS, OK) == 0
    failing.skip(2.0)
    assert failing.autopilot.health.is_gnss_ok


def test_an_estimator_without_any_position_says_so_until_it_has_one_again(failing):
    def is_unaided():
        flags = named(failing.heard, "ESTIMATOR_STATUS")[-1].flags
        return bool(flags & mav.ESTIMATOR_CONST_POS_MODE)

    failing.become_ready()
    failing.run(2.5)
    assert not is_unaided()
    inject(failing, GPS, OFF)
    failing.run(4.5)
    assert is_unaided()
    inject(failing, GPS, OK)
    failing.run(4.5)
    assert not is_unaided()


def test_what_the_vehicle_does_not_have_does_not_come_with_its_recovery(failing):
    """Odometry is off in this vehicle, and works no better once its failure is taken back."""
    assert inject(failing, VIO, OFF) == 0
    assert inject(failing, VIO, OK) == 0
    failing.skip(2.0)
    assert failing.plant.filter["has_vio"] == 0


@pytest.mark.parametrize("unit", [OPTICAL_FLOW, SERVO, 103, 106, -1, 1e9])
def test_a_part_that_is_not_there_is_told_as_unsupported(failing, unit):
    assert inject(failing, unit, OFF) == mav.MAV_RESULT_UNSUPPORTED


@pytest.mark.parametrize(
    ("unit", "kind"),
    [(GYRO, 8), (MAG, -1), (MAG, 0.5), (MOTOR, GARBAGE), (BATTERY, INTERMITTENT), (RC, STUCK)],
)
def test_a_kind_that_a_part_cannot_have_is_told_as_unsupported(failing, unit, kind):
    assert inject(failing, unit, kind) == mav.MAV_RESULT_UNSUPPORTED


@pytest.mark.parametrize(("unit", "instance"), [(MAG, 2), (MOTOR, 5), (MOTOR, -1), (MOTOR, 1.5)])
def test_an_instance_that_there_is_not_is_denied(failing, unit, instance):
    assert inject(failing, unit, OFF, instance) == mav.MAV_RESULT_DENIED
    failing.step()
    assert "valid are 0 (all) to" in "".join(m.text for m in named(failing.heard, "STATUSTEXT"))


@pytest.mark.parametrize("unit", [0, 1, 2, 3, 4, 6, 7, 8])
def test_a_sensor_can_fail_in_every_way_and_none_ends_the_loop(failing, unit):
    for kind in Failure:
        assert inject(failing, unit, kind, 1) == 0
        failing.skip(0.5)


def test_a_motor_is_lost_by_its_number_and_the_vehicle_lands(failing):
    failing.take_off(4.0)
    assert inject(failing, MOTOR, OFF, 4) == 0
    failing.skip(0.5)
    assert failing.plant.lost_rotors == (failing.plant.world.airframe.motors[3],)
    assert failing.autopilot.mode is Mode.LAND
    failing.run_until(lambda: not failing.autopilot.is_armed, 40.0)
    assert inject(failing, MOTOR, OK) == 0
    failing.skip(1.0)
    assert failing.autopilot.prearm.is_ok


def test_all_motors_fail_at_once(failing):
    failing.take_off(3.0)
    assert inject(failing, MOTOR, OFF, 0) == 0
    failing.skip(0.6)
    assert failing.autopilot.mode is Mode.TERMINATION


def test_a_battery_that_reads_empty_lands(failing):
    failing.take_off(3.0)
    assert inject(failing, BATTERY, OFF) == 0
    failing.run_until(lambda: not failing.autopilot.is_armed, 40.0)
    assert inject(failing, BATTERY, OK) == 0
    failing.skip(1.0)
    assert failing.autopilot.prearm.is_ok


def test_sticks_whose_signal_fails_land_the_vehicle(failing):
    failing.take_off(4.0)
    failing.autopilot.parameters.set("NAV_RCL_ACT", 3)
    for tick in range(150):
        if tick == 75:
            assert inject(failing, RC, OFF) == 0
        failing.send("MANUAL_CONTROL", 1, 0, 0, 500, 0, 0)
        failing.step()
    texts = "".join(m.text for m in named(failing.heard, "STATUSTEXT"))
    assert "manual control lost, switching to Land" in texts


def test_a_ground_station_that_is_no_longer_heard_counts_as_lost_but_can_take_it_back(failing):
    failing.take_off(4.0)
    failing.autopilot.parameters.set("NAV_DLL_ACT", 1)
    failing.autopilot.parameters.set("COM_DL_LOSS_T", 5)
    assert inject(failing, MAVLINK, OFF) == 0
    for _ in range(7):
        failing.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        failing.run(1.0)
    texts = "".join(m.text for m in named(failing.heard, "STATUSTEXT"))
    assert "Failsafe activated: ground station lost, switching to Hold" in texts
    assert inject(failing, MAVLINK, OK) == 0
    failing.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    failing.run(0.5)
    texts = "".join(m.text for m in named(failing.heard, "STATUSTEXT"))
    assert "Connection to ground station regained" in texts
