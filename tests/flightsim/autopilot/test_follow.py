"""Follow mode: a distance, a height and an angle to a target that tells where it is."""

import math

import pytest

from flightsim.autopilot.modes import Mode
from tests.flightsim.autopilot.bench import Bench


@pytest.fixture
def bench():
    bench = Bench()
    bench.take_off(8.0)
    assert bench.pilot.set_mode(Mode.FOLLOW).is_accepted
    return bench


def report(bench, seconds, place, velocity=(0.0, 0.0, 0.0)):
    """Report a target that moves as it says, five times a second; return where it ended."""
    for number in range(round(5 * seconds)):
        position = tuple(p + v * 0.2 * number for p, v in zip(place, velocity, strict=True))
        bench.pilot.follow_target.receive(position, velocity, bench.plant.time_us)
        bench.run(0.2)
    return position


def offset(bench, target):
    x, y, z = bench.plant.truth.position_enu_m
    return x - target[0], y - target[1], z


def test_a_standing_target_is_kept_at_distance_from_the_side_where_the_vehicle_is(bench):
    target = report(bench, 20.0, (30.0, 0.0, 0.0))
    dx, dy, z = offset(bench, target)
    assert (dx, dy) == pytest.approx((-8.0, 0.0), abs=0.3)
    assert z == pytest.approx(8.0, abs=0.3)
    assert bench.pilot.mode is Mode.FOLLOW


@pytest.mark.parametrize(("angle_deg", "side"), [(180.0, (-8.0, 0.0)), (90.0, (0.0, -8.0))])
def test_a_moving_target_is_followed_at_the_angle_to_its_course(bench, angle_deg, side):
    bench.pilot.parameters.set("FLW_TGT_FA", angle_deg)
    bench.pilot.parameters.set("FLW_TGT_RS", 0.0)
    target = report(bench, 40.0, (0.0, 20.0, 0.0), (1.0, 0.0, 0.0))  # to the east
    dx, dy, _ = offset(bench, target)
    assert (dx, dy) == pytest.approx(side, abs=1.5)
    facing = math.atan2(-dy, -dx)
    assert abs(math.remainder(bench.pilot._vehicle.yaw_rad - facing, 2 * math.pi)) < 0.3


def test_the_height_counts_from_the_target_if_it_is_told_so(bench):
    bench.pilot.parameters.set("FLW_TGT_ALT_M", 2)
    report(bench, 25.0, (20.0, 0.0, 5.0))
    assert bench.plant.truth.position_enu_m[2] == pytest.approx(13.0, abs=0.4)


def test_the_vehicle_stays_where_the_reports_end(bench):
    report(bench, 20.0, (30.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    bench.run(6.0)
    here = bench.plant.truth.position_enu_m
    bench.run(4.0)
    assert math.dist(here, bench.plant.truth.position_enu_m) < 0.3
    assert bench.pilot.mode is Mode.FOLLOW


def test_it_waits_within_the_fence_while_the_target_is_beyond_it(bench):
    strip = ((14.0, -30.0), (16.0, -30.0), (16.0, 30.0), (14.0, 30.0))
    items = [bench.item(5002, x, y, param1=len(strip)) for x, y in strip]
    bench.pilot.fence.replace(items)
    east_m = []
    for x in range(8, 40, 2):
        report(bench, 1.0, (float(x), 0.0, 0.0), (2.0, 0.0, 0.0))
        east_m.append(bench.plant.truth.position_enu_m[0])
    assert 8.0 < max(east_m) < 14.0, "it goes along as far as it may"
    assert bench.pilot.mode is Mode.FOLLOW
    assert not bench.says("geofence breached")
    assert bench.says("Follow: waiting within the geofence")
    report(bench, 15.0, (8.0, 0.0, 0.0))
    assert bench.plant.truth.position_enu_m[0] < 4.0, "it goes on when the target is back"


def test_it_is_no_mode_to_take_off_in():
    bench = Bench()
    assert bench.pilot.set_mode(Mode.FOLLOW).is_accepted
    assert not bench.pilot.arm().is_accepted
