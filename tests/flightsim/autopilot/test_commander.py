"""Arming, disarming, refusals, mode changes."""

import math

import pytest

from autonomy.types import ControlLevel
from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.modes import LandedState, Mode, SystemState
from flightsim.autopilot.results import CommandResult
from flightsim.environment.wind import WindCfg
from flightsim.plant import Plant, PlantCfg
from flightsim.sensors.failure import Failure
from flightsim.vehicles.catalogue import AIRFRAMES
from tests.flightsim.autopilot.bench import Bench

REJECTED = CommandResult.TEMPORARILY_REJECTED


def test_arming_waits_for_the_estimator():
    fresh = Bench()
    fresh.plant.failures.fail_sensor("gnss", Failure.OFF)
    assert fresh.run(60.0, lambda: not fresh.pilot.health.is_position_ok)
    reply = fresh.pilot.arm()
    assert reply.result is REJECTED
    fresh.step()
    assert fresh.says("Arming denied: position estimate not valid")
    assert not fresh.pilot.is_armed
    assert not fresh.pilot.health.is_armable
    assert fresh.pilot.prearm.reasons == ("position estimate not valid",)


def test_forced_arming_skips_the_checks():
    bench = Bench()
    bench.plant.failures.fail_sensor("gnss", Failure.OFF)
    assert bench.run(60.0, lambda: not bench.pilot.health.is_position_ok)
    assert bench.pilot.arm(is_forced=True).is_accepted
    assert bench.pilot.is_armed


def test_a_satellite_fix_is_asked_for_where_a_parameter_says_so():
    bench = Bench()
    bench.pilot.parameters.set("COM_ARM_WO_GPS", 0)
    assert bench.pilot.run_prearm_checks().is_ok
    bench.plant.failures.fail_sensor("gnss", Failure.OFF)
    bench.run(1.0)
    assert bench.pilot.arm().reason == "arming denied: no satellite fix"
    bench.pilot.run_prearm_checks()
    bench.step()
    assert bench.says("Preflight fail: no satellite fix")


@pytest.mark.parametrize("mode", [Mode.LAND, Mode.RETURN])
def test_modes_that_end_a_flight_do_not_begin_one(mode):
    bench = Bench()
    assert bench.pilot.set_mode(mode).is_accepted
    assert "not suitable for takeoff" in bench.pilot.arm().reason


def test_disarming_in_the_air_needs_force():
    bench = Bench().take_off()
    assert bench.pilot.disarm().result is REJECTED
    bench.step()
    assert bench.says("Disarming denied: not landed")
    assert bench.pilot.is_armed
    assert bench.pilot.disarm(is_forced=True).is_accepted
    bench.run(2.0)
    assert bench.pilot.setpoint.level is ControlLevel.OFF
    assert bench.position[2] < 0.5


def test_a_forgotten_vehicle_disarms():
    bench = Bench()
    bench.pilot.arm()
    bench.run(9.5)
    assert bench.pilot.is_armed
    assert bench.run(1.0, lambda: not bench.pilot.is_armed)
    assert bench.says("Disarmed by auto preflight disarming")


def test_a_vehicle_that_cannot_lift_off_disarms():
    bench = Bench()
    for rotor in range(4):
        bench.plant.failures.weaken_rotor(rotor, 0.4)
    bench.pilot.arm()
    bench.pilot.takeoff()
    bench.run(5.0)
    assert bench.pilot.setpoint.level is ControlLevel.TRAJECTORY
    assert bench.run(8.0, lambda: not bench.pilot.is_armed)
    assert bench.position[2] < 0.05


def test_a_negative_time_switches_disarming_off():
    bench = Bench()
    bench.pilot.parameters.set("COM_DISARM_PRFLT", -1)
    bench.pilot.parameters.set("COM_DISARM_LAND", -1)
    bench.take_off()
    bench.pilot.land()
    bench.run(25.0)
    assert bench.is_on_ground
    assert bench.pilot.is_armed
    assert bench.pilot.disarm().is_accepted


def test_arming_and_disarming_twice_is_no_error():
    bench = Bench()
    assert bench.pilot.arm().is_accepted
    assert bench.pilot.arm().is_accepted
    assert bench.pilot.disarm().is_accepted
    assert bench.pilot.disarm().is_accepted


@pytest.mark.parametrize(
    ("mode", "result", "why"),
    [
        (Mode.OFFBOARD, REJECTED, "no offboard setpoints"),
        (Mode.MISSION, CommandResult.DENIED, "no valid mission"),
        (Mode.STABILIZED, REJECTED, "no manual control"),
        (Mode.ORBIT, CommandResult.DENIED, "no mode to switch to"),
        (Mode.DESCEND, CommandResult.DENIED, "no mode to switch to"),
        (Mode.TERMINATION, CommandResult.DENIED, "no mode to switch to"),
    ],
)
def test_modes_that_cannot_be_entered_say_why_and_nothing_changes(mode, result, why):
    bench = Bench().take_off()
    reply = bench.pilot.set_mode(mode)
    assert reply.result is result
    assert why in reply.reason
    bench.run(1.0)
    assert bench.pilot.mode is Mode.HOLD
    assert bench.position[2] == pytest.approx(3.0, abs=0.4)
    assert bench.says(f"Switching to {mode.value} denied")


@pytest.mark.parametrize("mode", [Mode.POSITION, Mode.ALTITUDE])
def test_without_sticks_the_guided_stick_modes_hold(mode):
    bench = Bench(wind=WindCfg.towards((3.0, 0.0, 0.0))).take_off()
    assert bench.pilot.set_mode(mode).is_accepted
    bench.run(6.0)
    assert bench.position == pytest.approx((0.0, 0.0, 3.0), abs=0.5)


def test_termination_stops_the_rotors_and_disarms_on_the_ground():
    bench = Bench().take_off(2.0)
    assert bench.pilot.terminate().is_accepted
    bench.step()
    assert bench.pilot.setpoint.level is ControlLevel.OFF
    assert bench.pilot.system_state is SystemState.EMERGENCY
    assert not bench.pilot.set_mode(Mode.HOLD).is_accepted
    assert bench.run(10.0, lambda: not bench.pilot.is_armed)
    assert bench.pilot.landed_state is LandedState.ON_GROUND


def test_a_toppled_vehicle_disarms():
    bench = Bench().take_off(4.0)
    bench.plant.failures.weaken_rotor(0, 0.0)
    bench.plant.failures.weaken_rotor(2, 0.0)
    assert bench.run(30.0, lambda: not bench.pilot.is_armed)
    assert bench.says("Failsafe activated: vehicle toppled, disarming")


def test_setting_a_speed_changes_the_flight_in_progress():
    bench = Bench().take_off()
    bench.pilot.goto(bench.geodetic(40.0, 0.0))
    bench.run(4.0)
    assert bench.pilot.set_speed(2.0).is_accepted
    bench.run(3.0)
    assert bench.speed_mps == pytest.approx(2.0, abs=0.3)
    assert bench.pilot.set_speed(math.nan).result is CommandResult.DENIED
    assert bench.pilot.set_speed(-1.0).result is CommandResult.DENIED


def test_a_speed_asked_for_during_the_climb_lasts_until_another_kind_of_flight():
    bench = Bench()
    assert bench.pilot.arm().is_accepted
    assert bench.pilot.takeoff().is_accepted
    bench.run(2.0)
    assert bench.pilot.mode is Mode.TAKEOFF
    assert bench.pilot.set_speed(1.5).is_accepted
    assert bench.run(20.0, lambda: bench.pilot.mode is Mode.HOLD)
    bench.pilot.goto(bench.geodetic(40.0, 0.0))
    bench.run(5.0)
    assert bench.speed_mps == pytest.approx(1.5, abs=0.2)
    assert bench.pilot.return_to_launch().is_accepted
    assert bench.pilot.set_mode(Mode.HOLD).is_accepted
    bench.pilot.goto(bench.geodetic(60.0, 0.0))
    bench.run(5.0)
    assert bench.speed_mps > 3.0


def test_armed_by_force_before_there_is_an_attitude_it_idles():
    bench = Bench()
    plant = Plant(bench.plant.world, PlantCfg(seed=1))
    pilot = Autopilot(plant, bench.frame, airframe=AIRFRAMES["iris"])
    levels = set()

    def hold_the_throttle_up(seconds):
        for _ in range(round(50 * seconds)):
            pilot.set_manual_control(pitch=0.0, roll=0.0, throttle=0.8, yaw=0.0)
            plant.advance()
            pilot.update()
            levels.add(pilot.setpoint.level)

    plant.failures.fail_sensor("gnss", Failure.OFF)
    hold_the_throttle_up(0.1)
    assert pilot.set_mode(Mode.STABILIZED).is_accepted
    assert pilot.arm(is_forced=True).is_accepted
    hold_the_throttle_up(3.0)
    assert levels == {ControlLevel.OFF, ControlLevel.IDLE}
    plant.failures.fail_sensor("gnss", Failure.NONE)
    hold_the_throttle_up(2.0)
    assert ControlLevel.ATTITUDE in levels
