"""What the autopilot does when something is lost."""

import pytest

from autonomy.types import ControlLevel, Setpoint
from flightsim.autopilot.modes import BatteryWarning, FailsafeReason, Mode, SystemState
from flightsim.autopilot.results import CommandResult
from flightsim.sensors.failure import Failure
from flightsim.vehicles.battery import Battery
from tests.flightsim.autopilot.bench import Bench

CRUISING = Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(2.0, 0.0, 0.0))


def in_offboard(**parameters):
    bench = Bench(initial_parameters=parameters).take_off()
    bench.pilot.set_offboard_setpoint(CRUISING)
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    bench.stream(CRUISING, 2.0)
    return bench


def discharge(bench, remaining):
    bench.plant.battery = Battery(bench.plant.world.airframe.battery, remaining)


@pytest.mark.parametrize(
    ("measure", "mode"),
    [(0, Mode.HOLD), (3, Mode.RETURN), (4, Mode.LAND), (5, Mode.HOLD), (6, Mode.TERMINATION)],
)
def test_offboard_that_falls_silent_is_left_once_and_for_good(measure, mode):
    bench = in_offboard(COM_OBL_RC_ACT=measure)
    bench.run(0.9)
    assert bench.pilot.mode is Mode.OFFBOARD
    bench.run(0.4)
    assert bench.pilot.mode is mode
    assert bench.pilot.failsafe is FailsafeReason.OFFBOARD_LOST
    bench.stream(CRUISING, 0.6)
    assert bench.pilot.mode is mode
    said = [text for text in bench.texts if "offboard setpoints lost" in text]
    assert len(said) == 1


def test_offboard_loss_gives_the_sticks_back_to_a_pilot():
    bench = in_offboard()
    bench.steer(2.0)
    assert bench.pilot.mode is Mode.POSITION


def test_offboard_can_be_entered_again_after_a_loss():
    bench = in_offboard()
    bench.run(2.0)
    bench.pilot.set_offboard_setpoint(CRUISING)
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    assert bench.pilot.failsafe is None
    bench.stream(CRUISING, 1.0)
    assert bench.pilot.mode is Mode.OFFBOARD
    bench.run(2.0)
    assert bench.pilot.mode is Mode.HOLD, "a second loss is acted on as the first"


def test_by_default_a_lost_ground_station_changes_nothing_but_is_said():
    bench = Bench().take_off()
    bench.pilot.on_link_heartbeat("gcs")
    bench.run(12.0)
    assert bench.says("Connection to ground station lost")
    assert bench.pilot.mode is Mode.HOLD
    assert bench.pilot.failsafe is None
    bench.pilot.on_link_heartbeat("gcs")
    bench.run(0.5)
    assert bench.says("Connection to ground station regained")


@pytest.mark.parametrize(
    ("measure", "mode"), [(1, Mode.HOLD), (2, Mode.RETURN), (3, Mode.LAND), (5, Mode.TERMINATION)]
)
def test_a_lost_ground_station_is_acted_on_as_the_parameter_says(measure, mode):
    bench = Bench(initial_parameters={"NAV_DLL_ACT": measure, "COM_DL_LOSS_T": 5})
    bench.pilot.on_link_heartbeat("gcs")
    bench.pilot.arm()
    bench.pilot.goto(bench.geodetic(30.0, 0.0, 10.0))
    assert bench.run(12.0, lambda: bench.says("Failsafe activated: ground station lost"))
    assert bench.pilot.mode is mode


def test_without_any_ground_station_there_is_none_to_lose():
    bench = Bench(initial_parameters={"NAV_DLL_ACT": 2, "COM_DL_LOSS_T": 5}).take_off()
    bench.run(8.0)
    assert bench.pilot.mode is Mode.HOLD


def test_one_of_two_ground_stations_is_enough():
    bench = Bench(initial_parameters={"NAV_DLL_ACT": 2, "COM_DL_LOSS_T": 5})
    bench.pilot.on_link_heartbeat("a")
    bench.take_off()
    bench.run(8.0, each=lambda: bench.pilot.on_link_heartbeat("b"))
    assert bench.pilot.mode is Mode.HOLD


@pytest.mark.parametrize(
    ("measure", "mode"),
    [(1, Mode.HOLD), (2, Mode.RETURN), (3, Mode.LAND), (5, Mode.TERMINATION)],
)
def test_lost_sticks_are_acted_on_as_the_parameter_says(measure, mode):
    bench = Bench(initial_parameters={"NAV_RCL_ACT": measure}).take_off()
    bench.steer(1.0)
    assert bench.pilot.set_mode(Mode.ALTITUDE).is_accepted
    assert bench.run(2.0, lambda: bench.says("Failsafe activated: manual control lost"))
    assert bench.pilot.mode is mode


@pytest.mark.parametrize("parameter", ["NAV_RCL_ACT", "NAV_DLL_ACT", "COM_OBL_RC_ACT"])
def test_a_lost_link_disarms_where_the_parameter_says_so(parameter):
    measure = 7 if parameter == "COM_OBL_RC_ACT" else 6
    bench = in_offboard(**{parameter: measure, "COM_DL_LOSS_T": 5})
    if parameter == "COM_OBL_RC_ACT":
        bench.run(1.5)
    elif parameter == "NAV_DLL_ACT":
        bench.pilot.on_link_heartbeat("gcs")
        bench.stream(CRUISING, 6.0)
    else:
        bench.pilot.set_manual_control(pitch=0.0, roll=0.0, throttle=0.5, yaw=0.0)
        bench.stream(CRUISING, 1.5)
    assert not bench.pilot.is_armed
    assert bench.says("Disarmed by failsafe")


def test_lost_sticks_return_by_default_and_hold_where_they_are_excepted():
    bench = Bench().take_off()
    bench.steer(1.0)
    assert bench.pilot.set_mode(Mode.POSITION).is_accepted
    bench.run(1.0)
    assert bench.pilot.mode is Mode.RETURN
    assert bench.pilot.failsafe is FailsafeReason.MANUAL_CONTROL_LOST
    excepted = Bench(initial_parameters={"COM_RCL_EXCEPT": 2}).take_off()
    excepted.steer(1.0)
    excepted.run(2.0)
    assert excepted.pilot.mode is Mode.HOLD


def test_battery_warns_then_returns_then_lands():
    bench = Bench().take_off(12.0)
    bench.pilot.goto(bench.geodetic(30.0, 0.0))
    bench.run(10.0)
    discharge(bench, 0.14)
    bench.run(1.0)
    assert bench.pilot.battery.warning is BatteryWarning.LOW
    assert bench.pilot.mode is Mode.HOLD
    assert bench.pilot.system_state is SystemState.ACTIVE
    discharge(bench, 0.065)
    bench.run(1.5)
    assert bench.pilot.mode is Mode.RETURN
    assert bench.pilot.system_state is SystemState.CRITICAL
    discharge(bench, 0.045)
    bench.run(1.5)
    assert bench.pilot.mode is Mode.LAND
    assert bench.pilot.system_state is SystemState.EMERGENCY
    assert bench.run(60.0, lambda: not bench.pilot.is_armed)
    assert bench.pilot.arm().reason == "arming denied: battery too low"
    assert bench.says("Low battery level")
    assert bench.says("Critical battery level")


def test_a_critical_battery_lands_at_once_where_the_parameter_says_so():
    bench = Bench(initial_parameters={"COM_LOW_BAT_ACT": 2}).take_off(5.0)
    discharge(bench, 0.065)
    bench.run(1.5)
    assert bench.pilot.mode is Mode.LAND
    assert bench.run(40.0, lambda: not bench.pilot.is_armed)


def test_battery_can_be_left_to_the_pilot():
    bench = Bench(initial_parameters={"COM_LOW_BAT_ACT": 0}).take_off()
    discharge(bench, 0.06)
    bench.run(2.0)
    assert bench.pilot.mode is Mode.HOLD
    assert bench.pilot.failsafe is None


def test_a_client_may_overrule_a_failsafe_and_is_not_overruled_in_turn():
    bench = Bench().take_off(12.0)
    bench.pilot.goto(bench.geodetic(30.0, 0.0))
    bench.run(8.0)
    discharge(bench, 0.065)
    bench.run(1.5)
    assert bench.pilot.mode is Mode.RETURN
    assert bench.pilot.set_mode(Mode.HOLD).is_accepted
    bench.run(3.0)
    assert bench.pilot.mode is Mode.HOLD
    assert bench.pilot.failsafe is FailsafeReason.BATTERY_CRITICAL, "the condition is still there"


def test_a_return_does_not_interrupt_a_landing():
    bench = Bench().take_off(6.0)
    bench.pilot.land()
    bench.run(1.0)
    discharge(bench, 0.065)
    bench.run(2.0)
    assert bench.pilot.mode is Mode.LAND


def test_without_a_position_it_comes_down_level():
    bench = Bench().take_off(5.0)
    bench.plant.failures.fail_sensor("gnss", Failure.OFF)
    assert bench.run(60.0, lambda: bench.pilot.mode is Mode.DESCEND)
    assert bench.pilot.failsafe is FailsafeReason.POSITION_LOST
    assert bench.run(40.0, lambda: not bench.pilot.is_armed)
    # Beside the pad, where it may have drifted, the ground is a little lower.
    assert -0.1 < bench.position[2] < 0.05


@pytest.mark.parametrize(
    ("measure", "mode"),
    [
        *((0, Mode.OFFBOARD), (1, Mode.OFFBOARD), (2, Mode.HOLD), (3, Mode.RETURN)),
        *((4, Mode.TERMINATION), (5, Mode.LAND)),
    ],
)
def test_leaving_the_fence_is_acted_on_as_the_parameter_says(measure, mode):
    bench = in_offboard(GF_ACTION=measure, GF_MAX_HOR_DIST=8)
    bench.stream(CRUISING, 4.0)
    assert bench.pilot.mode is mode
    assert bench.says("geofence breached") is (measure > 0)


def test_a_fence_that_is_off_stops_nobody_until_it_is_on_again():
    bench = in_offboard(GF_ACTION=2, GF_MAX_HOR_DIST=8)
    bench.pilot.fence.switch = False
    bench.stream(CRUISING, 4.0)
    assert bench.pilot.mode is Mode.OFFBOARD
    bench.pilot.fence.switch = True
    bench.stream(CRUISING, 1.0)
    assert bench.pilot.mode is Mode.HOLD


def test_an_uploaded_fence_and_a_ceiling_hold_too():
    bench = Bench(initial_parameters={"GF_MAX_VER_DIST": 10}).take_off()
    assert bench.pilot.goto(bench.geodetic(0.0, 0.0, 20.0)).result is CommandResult.DENIED
    bench.pilot.fence.replace([bench.item(5003, 0.0, 0.0, param1=10.0)])
    reply = bench.pilot.goto(bench.geodetic(15.0, 0.0, 5.0))
    assert reply.result is CommandResult.DENIED
    assert "fence" in reply.reason
    assert bench.pilot.goto(bench.geodetic(5.0, 0.0, 5.0)).is_accepted


def test_nothing_is_flown_to_across_what_the_fence_forbids():
    bench = Bench().take_off(4.0)
    strip = ((10.0, -20.0), (12.0, -20.0), (12.0, 6.0), (10.0, 6.0))
    bench.pilot.fence.replace([bench.item(5002, x, y, param1=4) for x, y in strip])
    beyond = bench.geodetic(20.0, 0.0, 4.0)
    for reply in (
        bench.pilot.goto(beyond),
        bench.pilot.land(latitude_deg=beyond.latitude_deg, longitude_deg=beyond.longitude_deg),
        bench.pilot.orbit(bench.geodetic(11.0, -2.0, 4.0), radius_m=6.0, speed_mps=1.0),
    ):
        assert reply.result is CommandResult.DENIED
        assert reply.reason.endswith("the uploaded fence")
    assert bench.pilot.goto(bench.geodetic(20.0, 15.0, 4.0)).is_accepted


def test_outside_the_fence_there_is_no_arming():
    bench = Bench()
    bench.pilot.fence.replace([bench.item(5004, 0.0, 0.0, param1=3.0)])
    assert bench.pilot.arm().reason == "arming denied: outside the geofence"


def test_a_return_stays_below_the_ceiling():
    bench = Bench(initial_parameters={"GF_MAX_VER_DIST": 10}).take_off()
    bench.pilot.goto(bench.geodetic(30.0, 0.0, 4.0))
    bench.run(10.0)
    bench.pilot.return_to_launch()
    heights = []
    assert bench.run(
        90.0, lambda: not bench.pilot.is_armed, each=lambda: heights.append(bench.position[2])
    )
    assert max(heights) < 9.5
    assert bench.pilot.failsafe is None
