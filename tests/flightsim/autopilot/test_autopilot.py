"""Takeoff, hold, goto, return, land: flights in the real physics."""

import math
from itertools import pairwise

import pytest

from autonomy.types import ControlLevel
from flightsim.autopilot.modes import LandedState, Mode, SystemState
from flightsim.autopilot.results import CommandResult
from flightsim.environment.wind import WindCfg
from flightsim.frames import Geodetic
from tests.flightsim.autopilot.bench import GROUND_AMSL_M, NAN, Bench
from tests.flightsim.handmade import slope


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird", "iris-rotors"])
def test_takeoff_holds_then_lands_and_disarms(vehicle):
    bench = Bench(vehicle)
    pilot = bench.pilot
    assert pilot.system_state is SystemState.STANDBY
    assert pilot.arm().is_accepted
    assert pilot.takeoff().is_accepted
    states = []
    assert bench.run(
        15.0, lambda: pilot.mode is Mode.HOLD, each=lambda: states.append(pilot.landed_state)
    )
    assert {LandedState.ON_GROUND, LandedState.TAKEOFF} <= set(states)
    bench.run(3.0)
    assert pilot.landed_state is LandedState.IN_AIR
    assert bench.position == pytest.approx((0.0, 0.0, 2.5), abs=0.35)
    assert bench.speed_mps < 0.2
    assert pilot.land().is_accepted
    assert bench.run(5.0, lambda: pilot.landed_state is LandedState.LANDING)
    assert bench.run(20.0, lambda: not pilot.is_armed)
    assert bench.position == pytest.approx((0.0, 0.0, 0.0), abs=0.35)
    assert bench.texts == [
        "Armed by external command",
        "Takeoff detected",
        "Landing detected",
        "Disarmed by landing",
    ]
    assert pilot.mode is Mode.HOLD
    assert pilot.setpoint.level is ControlLevel.OFF


def test_touchdown_is_soft_and_there_is_no_bounce():
    bench = Bench().take_off(6.0)
    assert bench.pilot.land().is_accepted
    sink = []
    assert bench.run(
        30.0,
        lambda: bench.is_on_ground,
        each=lambda: sink.append(bench.plant.truth.velocity_enu_mps[2]),
    )
    first = next(i for i, v in enumerate(sink) if bench.positions[-len(sink) + i][2] < 0.13)
    assert -0.5 < min(sink[first - 5 : first + 5]) < 0.0
    assert max(sink[first:]) < 0.15


def test_takeoff_climbs_to_the_commanded_altitude_above_sea_level():
    bench = Bench()
    bench.pilot.arm()
    bench.pilot.takeoff(GROUND_AMSL_M + 7.0, yaw_rad=1.0)
    assert bench.run(20.0, lambda: bench.pilot.mode is Mode.HOLD)
    bench.run(2.0)
    assert bench.position[2] == pytest.approx(7.0, abs=0.35)
    assert bench.yaw_rad == pytest.approx(1.0, abs=0.1)


def test_takeoff_to_a_place_climbs_first_and_goes_there_then():
    bench = Bench()
    place = bench.geodetic(6.0, 0.0)
    bench.pilot.arm()
    bench.pilot.takeoff(
        GROUND_AMSL_M + 4.0, latitude_deg=place.latitude_deg, longitude_deg=place.longitude_deg
    )
    assert bench.run(20.0, lambda: bench.position[0] > 0.5)
    assert bench.position[2] > 3.5
    assert bench.run(20.0, lambda: bench.pilot.mode is Mode.HOLD)
    assert bench.position == pytest.approx((6.0, 0.0, 4.0), abs=0.4)


def test_takeoff_asked_for_before_arming_begins_with_arming():
    bench = Bench()
    assert bench.pilot.takeoff().is_accepted
    bench.run(3.0)
    assert bench.position[2] < 0.05
    assert bench.pilot.arm().is_accepted
    assert bench.run(15.0, lambda: bench.pilot.mode is Mode.HOLD)


def test_rotors_idle_between_arming_and_takeoff():
    bench = Bench()
    bench.pilot.arm()
    bench.run(0.5)
    assert bench.pilot.setpoint.level is ControlLevel.IDLE
    assert bench.position[2] < 0.02


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
def test_goto_flies_straight_and_stops_without_overshoot(vehicle):
    bench = Bench(vehicle).take_off(3.0)
    bench.run(1.0)
    start, n_before = bench.position, len(bench.positions)
    goal = (20.0, 10.0, 12.0)
    assert bench.pilot.goto(bench.geodetic(20.0, 10.0, 12.0)).is_accepted
    bench.run(16.0)
    assert bench.position == pytest.approx(goal, abs=0.35)
    assert bench.speed_mps < 0.2
    assert bench.yaw_rad == pytest.approx(math.atan2(10.0, 20.0), abs=0.15)
    u = [(g - s) / math.dist(start, goal) for g, s in zip(goal, start, strict=True)]
    for p in bench.positions[n_before:]:
        offset = [c - s for c, s in zip(p, start, strict=True)]
        along = sum(a * b for a, b in zip(offset, u, strict=True))
        assert along < math.dist(start, goal) + 0.4
        assert math.dist(offset, [along * c for c in u]) < 0.5


def test_goto_keeps_what_is_left_open_and_flies_as_fast_as_asked():
    bench = Bench().take_off(4.0)
    assert bench.pilot.goto(
        Geodetic(bench.geodetic(15.0, 0.0).latitude_deg, NAN, NAN), yaw_rad=0.5
    ).is_accepted
    bench.run(3.0)
    assert bench.position == pytest.approx((0.0, 0.0, 4.0), abs=0.4)
    assert bench.yaw_rad == pytest.approx(0.5, abs=0.1)
    assert bench.pilot.goto(bench.geodetic(15.0, 0.0), speed_mps=1.5).is_accepted
    bench.run(6.0)
    assert bench.speed_mps == pytest.approx(1.5, abs=0.25)
    assert bench.position[2] == pytest.approx(4.0, abs=0.4)


def test_goto_on_the_ground_takes_off():
    bench = Bench()
    bench.pilot.arm()
    bench.run(1.0)
    assert bench.pilot.goto(bench.geodetic(5.0, 5.0, 6.0)).is_accepted
    bench.run(12.0)
    assert bench.position == pytest.approx((5.0, 5.0, 6.0), abs=0.4)


def test_hold_stops_a_flight_on_the_spot():
    bench = Bench().take_off(3.0)
    bench.pilot.goto(bench.geodetic(30.0, 0.0, 3.0))
    bench.run(5.0)
    assert bench.speed_mps > 4.0
    x = bench.position[0]
    assert bench.pilot.set_mode(Mode.HOLD).is_accepted
    bench.run(6.0)
    assert bench.speed_mps < 0.2
    assert 3.0 < bench.position[0] - x < 8.0


def test_a_heading_can_be_set_while_holding():
    bench = Bench().take_off(3.0)
    assert bench.pilot.set_yaw(-2.0).is_accepted
    bench.run(5.0)
    assert bench.yaw_rad == pytest.approx(-2.0, abs=0.1)


def test_return_climbs_flies_home_descends_and_lands():
    bench = Bench().take_off(3.0)
    bench.pilot.parameters.set("RTL_RETURN_ALT", 15)
    bench.pilot.goto(bench.geodetic(30.0, 0.0, 4.0))
    bench.run(12.0)
    assert bench.pilot.return_to_launch().is_accepted
    highest = []
    assert bench.run(
        90.0, lambda: not bench.pilot.is_armed, each=lambda: highest.append(bench.position[2])
    )
    assert max(highest) == pytest.approx(15.0, abs=0.4)
    assert bench.position == pytest.approx((0.0, 0.0, 0.0), abs=0.4)
    assert bench.says("RTL: climb to 503 m (15 m above destination)")


def test_return_near_home_lands_without_climbing():
    bench = Bench().take_off(3.0)
    bench.pilot.goto(bench.geodetic(3.0, 0.0, 3.0))
    bench.run(6.0)
    bench.pilot.return_to_launch()
    highest = []
    assert bench.run(
        40.0, lambda: not bench.pilot.is_armed, each=lambda: highest.append(bench.position[2])
    )
    assert max(highest) < 3.5
    assert math.hypot(*bench.position[:2]) < 0.4


def test_return_takes_the_nearest_rally_point():
    bench = Bench().take_off(3.0)
    bench.pilot.rally.replace([bench.item(5100, 18.0, 0.0)])
    bench.pilot.goto(bench.geodetic(20.0, 0.0, 3.0))
    bench.run(10.0)
    bench.pilot.return_to_launch()
    assert bench.run(40.0, lambda: not bench.pilot.is_armed)
    assert bench.position[0] == pytest.approx(18.0, abs=0.4)


def test_home_is_where_it_was_armed_unless_a_client_moved_it():
    bench = Bench()
    assert bench.pilot.home is not None
    assert not bench.pilot.home.is_manual
    assert bench.pilot.set_home(bench.geodetic(7.0, 0.0, 0.0)).is_accepted
    bench.take_off(3.0)
    assert bench.pilot.home.position_enu_m == pytest.approx((7.0, 0.0, 0.0), abs=1e-6)
    bench.pilot.return_to_launch()
    assert bench.run(60.0, lambda: not bench.pilot.is_armed)
    assert bench.position[0] == pytest.approx(7.0, abs=0.4)


def test_land_elsewhere():
    bench = Bench().take_off(5.0)
    place = bench.geodetic(8.0, -4.0)
    assert bench.pilot.land(
        latitude_deg=place.latitude_deg, longitude_deg=place.longitude_deg
    ).is_accepted
    assert bench.run(40.0, lambda: not bench.pilot.is_armed)
    assert bench.position == pytest.approx((8.0, -4.0, 0.0), abs=0.4)


def test_orbit_circles_its_centre_and_faces_it():
    bench = Bench().take_off(5.0)
    assert bench.pilot.orbit(
        bench.geodetic(10.0, 0.0, 5.0), radius_m=6.0, speed_mps=2.0
    ).is_accepted
    bench.run(12.0)
    for _ in range(20):
        bench.run(0.5)
        x, y, z = bench.position
        assert math.hypot(x - 10.0, y) == pytest.approx(6.0, abs=0.5)
        assert z == pytest.approx(5.0, abs=0.4)
        vx, vy, _ = bench.plant.truth.velocity_enu_mps
        assert (x - 10.0) * vy - y * vx < 0.0, "clockwise"
        towards = math.atan2(-y, 10.0 - x)
        assert abs((bench.yaw_rad - towards + math.pi) % (2 * math.pi) - math.pi) < 0.4


def test_arming_again_after_a_landing_flies_again():
    bench = Bench().take_off(3.0)
    bench.pilot.land()
    assert bench.run(20.0, lambda: not bench.pilot.is_armed)
    bench.take_off(3.0)
    assert bench.pilot.n_arms == 2
    assert bench.position[2] == pytest.approx(3.0, abs=0.4)


def test_wind_does_not_move_the_hold():
    bench = Bench(wind=WindCfg.towards((5.0, 0.0, 0.0))).take_off(4.0)
    bench.run(8.0)
    assert bench.position == pytest.approx((0.0, 0.0, 4.0), abs=0.4)


@pytest.mark.parametrize(
    "place",
    [
        Geodetic(400.0, 8.5, 490.0),
        Geodetic(math.inf, 8.5, 490.0),
        Geodetic(47.4, 8.5, 1e9),
        Geodetic(-33.0, 151.0, 500.0),
    ],
)
def test_places_out_of_range_are_denied_and_the_flight_goes_on(place):
    bench = Bench().take_off(3.0)
    assert bench.pilot.goto(place).result is CommandResult.DENIED
    assert bench.pilot.set_home(place).result is CommandResult.DENIED
    bench.run(1.0)
    assert bench.position == pytest.approx((0.0, 0.0, 3.0), abs=0.35)


def test_the_reference_is_continuous_through_a_whole_flight():
    bench = Bench().take_off(4.0)
    bench.pilot.goto(bench.geodetic(12.0, 5.0, 6.0))
    bench.run(4.0)
    bench.pilot.goto(bench.geodetic(-3.0, 8.0, 4.0))
    bench.run(3.0)
    bench.pilot.return_to_launch()
    assert bench.run(60.0, lambda: not bench.pilot.is_armed)
    flown = [s for s in bench.setpoints if s.level is ControlLevel.TRAJECTORY]
    for before, after in pairwise(flown):
        assert math.dist(before.position_enu_m, after.position_enu_m) < 0.15
        assert math.dist(before.velocity_enu_mps, after.velocity_enu_mps) < 0.12
        assert math.dist(before.acceleration_enu_mps2, after.acceleration_enu_mps2) < 0.2


def test_the_same_seed_and_requests_fly_the_same_flight():
    def flight():
        bench = Bench(seed=11).take_off(3.0)
        bench.pilot.goto(bench.geodetic(8.0, 3.0, 5.0))
        bench.run(5.0)
        return bench.positions

    assert flight() == flight()


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_wandering_estimate_does_not_make_the_landing_dance(vehicle, seed):
    wind = WindCfg.towards((4.0, 2.0, 0.0))
    bench = Bench(vehicle, gnss="standard", seed=seed, wind=wind).take_off(5.0)
    bench.pilot.goto(bench.geodetic(6.0, 3.0))
    bench.run(8.0)
    assert not bench.says("Landing detected")
    assert bench.pilot.land().is_accepted
    climbs = []
    assert bench.run(
        60.0,
        lambda: not bench.pilot.is_armed,
        each=lambda: climbs.append((bench.position[2], bench.plant.truth.velocity_enu_mps[2])),
    )
    assert max(climb for height, climb in climbs if height < 0.3) < 0.4


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
@pytest.mark.parametrize("angle_deg", [5.0, 15.0])
def test_it_lands_on_a_slope_and_stays_there(vehicle, angle_deg):
    bench = Bench(vehicle, start=(0.0, 0.0, 5.0), extra=(slope(angle_deg),)).take_off(10.0)
    assert bench.pilot.land().is_accepted
    assert bench.run(40.0, lambda: not bench.pilot.is_armed)
    assert math.dist(bench.position[:2], (0.0, 0.0)) < 0.5
    _, x, y, _ = bench.plant.truth.quat_wxyz
    assert math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y))) == pytest.approx(angle_deg, abs=1.5)
    assert bench.texts.count("Landing detected") == 1
