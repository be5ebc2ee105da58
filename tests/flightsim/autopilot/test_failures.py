"""What becomes of a flight in which a part fails: the reaction that is configured, and its end."""

import math

import numpy as np
import pytest

from flightsim.autopilot.modes import BatteryWarning, FailsafeReason, Mode
from flightsim.environment.wind import WindCfg
from flightsim.sensors.failure import Failure
from flightsim.sensors.optical_flow import OpticalFlowCfg
from tests.flightsim.autopilot.bench import Bench

HEIGHT_M = 8.0
SENSORS_NOT_NEEDED = ("mag", "baro", "range", "airspeed")
ALL_FAILURES = [failure for failure in Failure if failure is not Failure.NONE]


def aloft(vehicle="iris", **parameters):
    return Bench(vehicle, initial_parameters=parameters).take_off(HEIGHT_M)


def land(bench):
    """Land, and return how far from the start it stands and how fast it came down at most."""
    assert bench.pilot.land().is_accepted
    return come_down(bench)


def come_down(bench):
    fastest = 0.0
    for _ in range(50 * 60):
        bench.step()
        fastest = max(fastest, -bench.plant.truth.velocity_enu_mps[2])
        if not bench.pilot.is_armed:
            break
    assert bench.is_on_ground
    return math.hypot(*bench.position[:2]), fastest


@pytest.mark.parametrize(("vehicle", "rotor"), [("iris", 0), ("iris", 3), ("hummingbird", 1)])
def test_with_a_motor_lost_it_spins_and_lands_where_it_was(vehicle, rotor):
    bench = aloft(vehicle)
    bench.plant.failures.fail_rotor(rotor, Failure.OFF)
    bench.run(0.5)
    assert bench.plant.lost_rotors == (rotor,)
    assert bench.pilot.mode is Mode.LAND
    assert bench.pilot.failsafe is FailsafeReason.MOTOR_LOST
    bench.run(2.0)
    assert abs(bench.plant.truth.angular_rate_flu_radps[2]) > 5.0, "nothing holds its yaw"
    away_m, fastest_mps = come_down(bench)
    assert away_m < 3.0
    assert fastest_mps < 4.0
    _, x, y, _ = bench.plant.truth.quat_wxyz
    assert 1.0 - 2.0 * (x * x + y * y) > 0.95, "it stands on its legs"


@pytest.mark.parametrize(("vehicle", "rotor"), [("iris", 0), ("hummingbird", 1)])
def test_with_a_motor_lost_it_comes_down_gently_in_wind(vehicle, rotor):
    bench = Bench(vehicle, wind=WindCfg(speed_mps=5.0, from_deg=270.0)).take_off(8.0)
    bench.plant.failures.fail_rotor(rotor, Failure.OFF)
    before_mps = []
    assert bench.run(
        40.0,
        lambda: bool(bench.plant.history["is_touching"].any()),
        each=lambda: before_mps.append(bench.plant.truth.velocity_enu_mps),
    )
    assert -before_mps[-1][2] < 0.5
    assert math.hypot(*before_mps[-1][:2]) < 0.6
    assert bench.run(10.0, lambda: not bench.pilot.is_armed)
    assert math.hypot(*bench.position[:2]) < 2.0
    _, x, y, _ = bench.plant.truth.quat_wxyz
    assert 1.0 - 2.0 * (x * x + y * y) > 0.95, "it stands on its legs"


def test_with_a_motor_lost_it_holds_a_place_in_wind():
    wind = WindCfg(speed_mps=4.0, from_deg=270.0)
    bench = Bench(initial_parameters={"COM_ACT_FAIL_ACT": 0}, wind=wind).take_off(HEIGHT_M)
    bench.plant.failures.fail_rotor(0, Failure.OFF)
    bench.run(30.0)
    assert bench.position == pytest.approx((0.0, 0.0, HEIGHT_M), abs=0.5)


def test_a_landing_in_a_wind_that_carries_it_away_does_not_wait_for_its_place():
    bench = aloft()
    bench.plant.wind = WindCfg(speed_mps=18.0, from_deg=270.0)
    assert bench.pilot.land().is_accepted
    assert bench.run(40.0, lambda: bench.is_on_ground)


def test_a_lost_motor_can_be_flown_without_where_the_parameter_only_warns():
    bench = aloft(COM_ACT_FAIL_ACT=0)
    bench.plant.failures.fail_rotor(2, Failure.OFF)
    bench.run(20.0)
    assert bench.pilot.mode is Mode.HOLD
    assert bench.says("Failsafe warning: motor lost")
    assert bench.position == pytest.approx((0.0, 0.0, HEIGHT_M), abs=1.0)


def test_a_lost_motor_ends_the_flight_where_the_parameter_says_so():
    bench = aloft(COM_ACT_FAIL_ACT=4)
    bench.plant.failures.fail_rotor(2, Failure.OFF)
    bench.run(0.5)
    assert bench.pilot.mode is Mode.TERMINATION
    assert bench.plant.rotor_speed_commands_radps == (0.0,) * 4


def test_without_two_motors_the_flight_is_ended():
    bench = aloft(COM_ACT_FAIL_ACT=0)
    for rotor in (0, 1):
        bench.plant.failures.fail_rotor(rotor, Failure.OFF)
    bench.run(0.5)
    assert bench.pilot.mode is Mode.TERMINATION
    assert bench.says("Failsafe activated: motor lost, switching to Termination")


@pytest.mark.parametrize("failure", [Failure.STUCK, Failure.SLOW])
def test_a_motor_that_turns_wrongly_is_flown_with(failure):
    bench = aloft()
    bench.plant.failures.fail_rotor(1, failure)
    bench.run(5.0)
    assert bench.position == pytest.approx((0.0, 0.0, HEIGHT_M), abs=1.0)
    away_m, fastest_mps = land(bench)
    assert away_m < 1.5
    assert fastest_mps < 2.5


@pytest.mark.parametrize("sensor", SENSORS_NOT_NEEDED)
@pytest.mark.parametrize("failure", ALL_FAILURES)
def test_a_sensor_that_is_not_needed_is_flown_without(sensor, failure):
    bench = aloft()
    bench.plant.failures.fail_sensor(sensor, failure)
    assert bench.pilot.goto(bench.geodetic(6.0, 3.0)).is_accepted
    bench.run(8.0)
    assert bench.position == pytest.approx((6.0, 3.0, HEIGHT_M), abs=0.6)
    away_m, fastest_mps = land(bench)
    assert away_m == pytest.approx(math.hypot(6.0, 3.0), abs=0.6)
    assert fastest_mps < 2.0


@pytest.mark.parametrize("failure", [Failure.OFF, Failure.STUCK])
@pytest.mark.parametrize("sensor", ["mag", "baro", "range"])
def test_a_sensor_that_falls_silent_is_told_and_forbids_arming_where_it_is_needed(sensor, failure):
    bench = Bench()
    bench.plant.failures.fail_sensor(sensor, failure)
    bench.run(2.5)
    title = {"mag": "Magnetometer", "baro": "Barometer", "range": "Rangefinder"}[sensor]
    assert bench.says(f"{title} lost")
    assert bench.pilot.arm().is_accepted is (sensor == "range")
    bench.pilot.disarm()
    bench.plant.failures.fail_sensor(sensor, Failure.NONE)
    bench.run(1.0)
    assert bench.says(f"{title} regained")
    assert bench.pilot.arm().is_accepted


@pytest.mark.parametrize("failure", [Failure.OFF, Failure.STUCK, Failure.GARBAGE])
@pytest.mark.parametrize(("sensor", "plant"), [("gnss", {}), ("vio", {"aiding": "vio"})])
def test_without_what_tells_its_place_it_comes_down_level(sensor, plant, failure):
    bench = Bench(**plant).take_off(HEIGHT_M)
    bench.plant.failures.fail_sensor(sensor, failure)
    assert bench.run(60.0, lambda: bench.pilot.mode is Mode.DESCEND)
    assert bench.pilot.failsafe is FailsafeReason.POSITION_LOST
    _, fastest_mps = come_down(bench)
    assert fastest_mps < 2.5


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
def test_a_descent_without_any_position_is_not_carried_along_by_the_wind(vehicle):
    bench = Bench(vehicle, wind=WindCfg(speed_mps=5.0, from_deg=270.0)).take_off(HEIGHT_M)
    bench.plant.failures.fail_sensor("gnss", Failure.OFF)
    assert bench.run(60.0, lambda: bench.pilot.mode is Mode.DESCEND)
    fastest_mps = 0.0
    while bench.pilot.is_armed:
        bench.step()
        east_mps, north_mps, _ = bench.plant.truth.velocity_enu_mps
        fastest_mps = max(fastest_mps, math.hypot(east_mps, north_mps))
    assert bench.is_on_ground
    assert fastest_mps < 1.8


def test_landing_it_descends_where_it_is_if_nothing_measures_its_place():
    bench = aloft()
    bench.plant.failures.fail_sensor("gnss", Failure.OFF)
    bench.run(3.0)
    assert bench.plant.estimator.is_dead_reckoning
    assert bench.pilot.land().is_accepted
    bench.run(0.1)
    assert bench.pilot.target_enu_m is None, "it holds no place"
    assert bench.plant.truth.velocity_enu_mps[2] < -0.05, "it waits for none"
    _, fastest_mps = come_down(bench)
    assert fastest_mps < 2.5


@pytest.mark.parametrize(
    ("failure", "most_m"),
    [(Failure.SLOW, 0.5), (Failure.INTERMITTENT, 0.5), (Failure.DELAYED, 4.0)],
)
def test_satellites_that_are_poor_are_flown_with(failure, most_m):
    bench = aloft()
    bench.plant.failures.fail_sensor("gnss", failure)
    bench.run(10.0)
    assert bench.pilot.mode is Mode.HOLD
    away_m, _ = land(bench)
    assert away_m < most_m


def test_satellites_that_are_consistently_wrong_are_believed_and_it_stays_controlled():
    bench = aloft()
    bench.plant.failures.fail_sensor("gnss", Failure.WRONG)
    bench.run(15.0)
    assert bench.pilot.mode is Mode.HOLD
    error = np.subtract(bench.plant.estimate.position_enu_m, bench.plant.truth.position_enu_m)
    assert error[:2] == pytest.approx((30.0, 20.0), abs=2.0)
    assert bench.speed_mps < 6.0
    _, fastest_mps = land(bench)
    assert fastest_mps < 2.5


@pytest.mark.parametrize("sensor", ["gyroscope", "accelerometer"])
@pytest.mark.parametrize("failure", [f for f in ALL_FAILURES if f is not Failure.WRONG])
def test_without_its_only_inertial_sensor_the_flight_is_ended(sensor, failure):
    bench = aloft()
    bench.plant.failures.fail_sensor(sensor, failure)
    bench.run(0.6)
    assert bench.pilot.mode is Mode.TERMINATION
    assert bench.says("Failsafe activated: inertial sensor lost, switching to Termination")
    bench.run(5.0)
    assert not any(bench.plant.rotor_speed_commands_radps)
    assert bench.position == pytest.approx((0.0, 0.0, 0.0), abs=2.0)
    assert bench.speed_mps < 0.1


@pytest.mark.parametrize(("sensor", "most_m"), [("gyroscope", 0.5), ("accelerometer", 2.0)])
@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
def test_an_inertial_sensor_that_is_off_by_a_constant_is_learnt(vehicle, sensor, most_m):
    bench = aloft(vehicle)
    bench.plant.failures.fail_sensor(sensor, Failure.WRONG)
    bench.run(20.0)
    assert max(math.hypot(x, y) for x, y, _ in bench.positions) < most_m
    away_m, fastest_mps = land(bench)
    assert away_m < 0.5
    assert fastest_mps < 2.0


@pytest.mark.parametrize("failure", ALL_FAILURES)
def test_odometry_is_flown_without_where_there_are_satellites(failure):
    bench = Bench(aiding="auto").take_off(HEIGHT_M)
    bench.plant.failures.fail_sensor("vio", failure)
    bench.run(10.0)
    assert bench.pilot.mode is Mode.HOLD
    away_m, fastest_mps = land(bench)
    assert away_m < 0.5
    assert fastest_mps < 2.0


@pytest.mark.parametrize(
    ("failure", "most_m"),
    [
        (Failure.WRONG, 0.5),
        (Failure.SLOW, 0.5),
        (Failure.INTERMITTENT, 0.5),
        (Failure.DELAYED, 3.0),
    ],
)
def test_odometry_that_is_poor_is_flown_with(failure, most_m):
    bench = Bench(aiding="vio").take_off(HEIGHT_M)
    bench.plant.failures.fail_sensor("vio", failure)
    bench.run(10.0)
    assert bench.pilot.mode is Mode.HOLD
    away_m, _ = land(bench)
    assert away_m < most_m


@pytest.mark.parametrize(
    ("failure", "warning", "mode"),
    [
        (Failure.OFF, BatteryWarning.EMERGENCY, Mode.LAND),
        (Failure.WRONG, BatteryWarning.LOW, Mode.HOLD),
        (Failure.STUCK, BatteryWarning.NONE, Mode.HOLD),
    ],
)
def test_a_battery_monitor_that_fails_is_believed(failure, warning, mode):
    bench = aloft()
    bench.pilot.battery_monitor.failure = failure
    before = bench.pilot.battery.remaining
    bench.run(3.0)
    assert bench.pilot.battery.warning is warning
    assert bench.pilot.mode is mode
    if failure is Failure.STUCK:
        assert bench.pilot.battery.remaining == before > bench.plant.battery.remaining
    away_m, fastest_mps = land(bench) if mode is Mode.HOLD else come_down(bench)
    assert away_m < 0.5
    assert fastest_mps < 2.0


@pytest.mark.parametrize(
    ("measure", "mode"), [(0, Mode.HOLD), (1, Mode.HOLD), (3, Mode.RETURN), (5, Mode.LAND)]
)
def test_a_wind_that_is_too_strong_is_acted_on_as_the_parameter_says(measure, mode):
    bench = aloft(COM_WIND_MAX=6.0, COM_WIND_MAX_ACT=measure)
    bench.pilot.goto(bench.geodetic(15.0, 0.0))
    bench.run(8.0)
    bench.plant.wind = WindCfg.towards((9.0, 0.0, 0.0))
    bench.run(15.0, lambda: bench.pilot.mode is not Mode.HOLD)
    assert bench.pilot.mode is mode
    assert bench.says("wind too strong") is (measure > 0)


@pytest.mark.parametrize("failure", ALL_FAILURES)
def test_it_is_flown_without_optical_flow(failure):
    bench = Bench(optical_flow=OpticalFlowCfg(is_fitted=True)).take_off(HEIGHT_M)
    bench.plant.failures.fail_sensor("optical_flow", failure)
    bench.run(10.0)
    assert bench.pilot.mode is Mode.HOLD
    away_m, fastest_mps = land(bench)
    assert away_m < 0.5
    assert fastest_mps < 2.0
