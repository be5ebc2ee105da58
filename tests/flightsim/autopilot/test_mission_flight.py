"""Missions flown in the real physics."""

import math
from itertools import pairwise

import pytest

from autonomy.types import ControlLevel
from flightsim.autopilot.mission_item import Cmd, MissionItem
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.results import CommandResult
from tests.flightsim.autopilot.bench import NAN, Bench
from tests.flightsim.handmade import hills

MISSION_FRAME = 2


def waypoint(bench, x, y, z, *, hold_s=0.0, radius_m=1.0, **fields):
    return bench.item(Cmd.WAYPOINT, x, y, z, param1=hold_s, param2=radius_m, **fields)


def square(bench, **fields):
    """Takeoff, four corners, landing at the start."""
    return [
        bench.item(Cmd.TAKEOFF, 0.0, 0.0, 3.0),
        waypoint(bench, 12.0, 0.0, 4.0, **fields),
        waypoint(bench, 12.0, 12.0, 5.0, **fields),
        waypoint(bench, 0.0, 12.0, 4.0, **fields),
        bench.item(Cmd.LAND, 0.0, 0.0, 0.0),
    ]


def fly(bench, items, seconds=150.0):
    bench.pilot.mission.replace(items)
    assert bench.pilot.start_mission().is_accepted
    assert bench.pilot.arm().is_accepted
    return bench.run(seconds, lambda: not bench.pilot.is_armed)


def closest(bench, x, y, z):
    rest_m = bench.plant.world.airframe.leg_length_m
    return min(math.dist(p, (x, y, z + rest_m)) for p in bench.positions)


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
def test_a_mission_visits_its_waypoints_lands_and_disarms(vehicle):
    bench = Bench(vehicle)
    assert fly(bench, square(bench))
    assert bench.reached == [0, 1, 2, 3, 4]
    for corner in [(12.0, 0.0, 4.0), (12.0, 12.0, 5.0), (0.0, 12.0, 4.0)]:
        assert closest(bench, *corner) < 1.5
    assert bench.position == pytest.approx((0.0, 0.0, 0.0), abs=0.4)
    assert bench.says("Mission finished")
    assert bench.pilot.mode is Mode.HOLD
    assert bench.pilot.mission.current_index == 0, "ready to be flown again"


def test_waypoints_without_hold_are_passed_and_with_hold_are_stopped_at():
    passing, stopping = Bench(), Bench()
    assert fly(passing, square(passing))
    assert fly(stopping, square(stopping, hold_s=1.0, radius_m=0.3))
    assert len(stopping.positions) > len(passing.positions) + 3 * 50

    def slowest_at_corner(bench):
        near = [
            math.hypot(*s.velocity_enu_mps)
            for s in bench.setpoints
            if s.level is ControlLevel.TRAJECTORY
            and math.dist(s.position_enu_m[:2], (12.0, 12.0)) < 1.0
        ]
        return min(near)

    assert slowest_at_corner(stopping) == 0.0
    assert slowest_at_corner(passing) > 0.5
    assert closest(stopping, 12.0, 12.0, 5.0) < 0.35


def test_the_reference_of_a_mission_is_smooth():
    bench = Bench()
    assert fly(bench, square(bench))
    flown = [s for s in bench.setpoints if s.level is ControlLevel.TRAJECTORY]
    for before, after in pairwise(flown):
        assert math.dist(before.position_enu_m, after.position_enu_m) < 0.12
        assert math.dist(before.velocity_enu_mps, after.velocity_enu_mps) < 0.11
        assert math.dist(before.acceleration_enu_mps2, after.acceleration_enu_mps2) < 0.15


def test_a_mission_without_takeoff_climbs_first():
    bench = Bench()
    items = [waypoint(bench, 10.0, 0.0, 5.0), bench.item(Cmd.LAND, 10.0, 0.0, 0.0)]
    assert fly(bench, items)
    for x, y, z in bench.positions:
        assert math.hypot(x, y) < 0.5 or z > 0.5 or x > 9.0


def test_without_a_landing_it_loiters_at_the_end_and_can_be_flown_again():
    bench = Bench()
    assert not fly(bench, square(bench)[:2], seconds=20.0)
    assert bench.pilot.mode is Mode.MISSION
    assert bench.pilot.mission.is_finished
    assert bench.position == pytest.approx((12.0, 0.0, 4.0), abs=0.4)
    assert bench.says("Mission finished, loitering")
    bench.reached.clear()
    assert bench.pilot.start_mission().is_accepted
    bench.run(15.0)
    assert bench.reached == [0, 1]


def test_delay_speed_yaw_jump_and_foreign_items():
    bench = Bench()
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        bench.item(Cmd.CHANGE_SPEED, frame=MISSION_FRAME, param1=1.0, param2=2.0),
        waypoint(bench, 8.0, 0.0, 3.0, hold_s=0.5),
        bench.item(2000, frame=MISSION_FRAME),
        bench.item(Cmd.DELAY, frame=MISSION_FRAME, param1=2.0),
        bench.item(Cmd.CONDITION_YAW, frame=MISSION_FRAME, param1=180.0, param4=0.0),
        waypoint(bench, 0.0, 0.0, 3.0),
        bench.item(Cmd.JUMP, frame=MISSION_FRAME, param1=2.0, param2=1.0),
        bench.item(Cmd.RETURN, frame=MISSION_FRAME),
    ]
    bench.pilot.mission.replace(items)
    bench.pilot.start_mission()
    bench.pilot.arm()
    speeds, yaws = [], []

    def watch():
        speeds.append(bench.speed_mps)
        if bench.reached and bench.reached[-1] == 5:
            yaws.append(bench.yaw_rad)

    assert bench.run(120.0, lambda: not bench.pilot.is_armed, each=watch)
    assert bench.reached == [0, 1, 2, 3, 4, 5, 6, 7, 2, 3, 4, 5, 6, 7, 8]
    assert max(speeds) < 2.4
    assert yaws[0] == pytest.approx(-math.pi / 2, abs=0.3), "180 degrees by compass is south"
    assert math.hypot(*bench.position[:2]) < 0.5


def test_loiter_turns_circle_clockwise_at_their_radius():
    bench = Bench()
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        bench.item(Cmd.LOITER_TURNS, 8.0, 0.0, 4.0, param1=2.0, param3=5.0),
        bench.item(Cmd.LAND, 0.0, 0.0, 0.0),
    ]
    swept, last = 0.0, None
    bench.pilot.mission.replace(items)
    bench.pilot.start_mission()
    bench.pilot.arm()
    while bench.pilot.is_armed and len(bench.positions) < 8000:
        bench.step()
        x, y, _ = bench.position
        angle = math.atan2(y, x - 8.0)
        if 0 in bench.reached and 1 not in bench.reached and abs(math.hypot(x - 8, y) - 5) < 0.5:
            if last is not None:
                swept += (angle - last + math.pi) % (2 * math.pi) - math.pi
            last = angle
    assert swept == pytest.approx(-4 * math.pi, abs=0.7)
    assert bench.reached == [0, 1, 2]


def test_loiter_time_waits_and_unlimited_waits_on():
    bench = Bench()
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        bench.item(Cmd.LOITER_TIME, 4.0, 0.0, 3.0, param1=3.0),
        bench.item(Cmd.LOITER_UNLIMITED, 4.0, 4.0, 3.0),
        MissionItem(frame=6, command=Cmd.LAND, x=NAN, y=NAN),
    ]
    assert not fly(bench, items, seconds=40.0)
    assert bench.reached == [0, 1]
    assert bench.position == pytest.approx((4.0, 4.0, 3.0), abs=0.4)
    assert bench.pilot.set_current_mission_item(3).is_accepted
    assert bench.run(30.0, lambda: not bench.pilot.is_armed)
    assert bench.position[:2] == pytest.approx((4.0, 4.0), abs=0.4)


def test_pause_stops_and_resume_goes_on_with_the_same_item():
    bench = Bench()
    bench.pilot.mission.replace(square(bench))
    bench.pilot.start_mission()
    bench.pilot.arm()
    assert bench.run(30.0, lambda: 1 in bench.reached)
    bench.run(1.5)
    assert bench.pilot.pause().is_accepted
    bench.run(4.0)
    assert bench.speed_mps < 0.2
    assert bench.pilot.mission.current_index == 2
    assert bench.pilot.resume().is_accepted
    assert bench.run(90.0, lambda: not bench.pilot.is_armed)
    assert bench.reached == [0, 1, 2, 3, 4]


def test_a_new_mission_in_flight_is_flown_from_its_beginning():
    bench = Bench()
    bench.pilot.mission.replace(square(bench))
    bench.pilot.start_mission()
    bench.pilot.arm()
    assert bench.run(30.0, lambda: 1 in bench.reached)
    bench.pilot.mission.replace([waypoint(bench, -5.0, 0.0, 6.0, hold_s=1.0)])
    bench.run(12.0)
    assert bench.position == pytest.approx((-5.0, 0.0, 6.0), abs=0.4)
    bench.pilot.mission.replace(())
    bench.run(2.0)
    assert bench.position == pytest.approx((-5.0, 0.0, 6.0), abs=0.4)


def test_only_a_part_of_a_mission_can_be_flown():
    bench = Bench().take_off()
    bench.pilot.mission.replace(square(bench))
    assert bench.pilot.start_mission(1, 2).is_accepted
    bench.run(25.0)
    assert bench.reached == [1, 2]
    assert bench.pilot.mission.is_finished


def test_items_in_local_frames_are_flown():
    bench = Bench()
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        MissionItem(frame=1, command=Cmd.WAYPOINT, param1=1.0, param2=0.5, x=6.0, y=-3.0, z=-4.0),
        MissionItem(frame=4, command=Cmd.LOITER_UNLIMITED, x=-3.0, y=8.0, z=5.0),
    ]
    fly(bench, items, seconds=20.0)
    assert closest(bench, -3.0, 6.0, 4.0) < 0.6
    assert bench.position == pytest.approx((-3.0, 8.0, 5.0), abs=0.5)


def test_a_landing_in_between_a_wait_and_another_takeoff():
    bench = Bench()
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        bench.item(Cmd.LAND, 3.0, 0.0, 0.0),
        bench.item(Cmd.DELAY, frame=MISSION_FRAME, param1=4.0),
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        bench.item(Cmd.LAND, 0.0, 0.0, 0.0),
    ]
    assert fly(bench, items)
    assert bench.reached == [0, 1, 2, 3, 4]
    assert bench.texts.count("Landing detected") == 2


def test_a_ring_of_jumps_ends_in_a_hold():
    bench = Bench()
    jump = {"frame": MISSION_FRAME, "param2": -1.0}
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        bench.item(Cmd.JUMP, param1=2.0, **jump),
        bench.item(Cmd.JUMP, param1=1.0, **jump),
    ]
    assert not fly(bench, items, seconds=12.0)
    assert bench.says("Mission stopped: its items only jump")
    assert bench.position[2] == pytest.approx(3.0, abs=0.4)


def test_without_autocontinue_the_mission_holds_after_the_item():
    bench = Bench()
    items = square(bench)
    items[1] = waypoint(bench, 12.0, 0.0, 4.0, is_autocontinue=False)
    assert not fly(bench, items, seconds=25.0)
    assert bench.pilot.mode is Mode.HOLD
    assert bench.pilot.mission.current_index == 2


@pytest.mark.parametrize(
    ("parameters", "x", "why"),
    [
        ({"MIS_DIST_1WP": 50}, 60.0, "first waypoint too far away: 60 m"),
        ({"GF_MAX_HOR_DIST": 50}, 60.0, "item 0 is outside the geofence"),
    ],
)
def test_a_mission_that_leads_too_far_is_not_started(parameters, x, why):
    bench = Bench(initial_parameters=parameters)
    bench.pilot.mission.replace([waypoint(bench, x, 0.0, 5.0)])
    reply = bench.pilot.start_mission()
    assert reply.result is CommandResult.DENIED
    assert why in reply.reason


WALL = ((10.0, -20.0), (12.0, -20.0), (12.0, 6.0), (10.0, 6.0))
"""A part of the field that an exclusion forbids: a strip from south to north."""


def forbid(bench, corners=WALL):
    items = [bench.item(5002, x, y, param1=len(corners)) for x, y in corners]
    bench.pilot.fence.replace(items)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ([(20.0, 0.0)], "the way to item 1 leaves the geofence"),
        ([(5.0, 0.0), (20.0, 0.0)], "the way to item 2 leaves the geofence"),
        ([(0.0, 12.0), (20.0, 12.0), (20.0, -5.0)], None),
        ([(11.0, 0.0)], "item 1 is outside the geofence (outside the uploaded fence)"),
    ],
)
def test_a_leg_across_what_the_fence_forbids_is_not_started(more, why):
    bench = Bench()
    forbid(bench)
    places = [waypoint(bench, x, y, 4.0) for x, y in more]
    bench.pilot.mission.replace([bench.item(Cmd.TAKEOFF, up_m=4.0), *places])
    reply = bench.pilot.start_mission()
    assert reply.is_accepted is (why is None)
    assert why is None or why in reply.reason


def test_the_way_of_a_jump_back_and_a_circle_count_too():
    bench = Bench()
    forbid(bench)
    start, beyond = waypoint(bench, 0.0, 12.0, 4.0), waypoint(bench, 20.0, 12.0, 4.0)
    south = waypoint(bench, 20.0, 0.0, 4.0)
    first = waypoint(bench, 0.0, 0.0, 4.0)
    bench.pilot.mission.replace([first, start, beyond, south, bench.item(Cmd.JUMP, param1=0.0)])
    assert "the way to item 4 leaves the geofence" in bench.pilot.start_mission().reason
    circle = bench.item(Cmd.LOITER_TURNS, 5.0, 0.0, 4.0, param1=1.0, param3=6.0)
    bench.pilot.mission.replace([circle])
    assert "item 0 is outside the geofence" in bench.pilot.start_mission().reason


def test_a_leg_counts_only_while_the_mission_has_the_fence_on():
    bench = Bench()
    forbid(bench)
    off = bench.item(Cmd.FENCE_ENABLE, param1=0.0)
    bench.pilot.mission.replace([off, waypoint(bench, 20.0, 0.0, 4.0)])
    assert bench.pilot.start_mission().is_accepted


@pytest.mark.parametrize(("first", "last"), [(5, None), (-1, None), (2, 1)])
def test_items_that_do_not_exist_are_denied(first, last):
    bench = Bench()
    bench.pilot.mission.replace(square(bench))
    assert bench.pilot.start_mission(first, last).result is CommandResult.DENIED
    assert bench.pilot.set_current_mission_item(5).result is CommandResult.DENIED


def test_takeoff_can_lead_over_to_the_mission():
    bench = Bench(initial_parameters={"COM_TAKEOFF_ACT": 1})
    bench.pilot.mission.replace(square(bench)[1:])
    bench.pilot.arm()
    bench.pilot.takeoff()
    assert bench.run(90.0, lambda: not bench.pilot.is_armed)
    assert bench.reached == [0, 1, 2, 3]


def test_headings_of_waypoints_are_taken():
    bench = Bench()
    items = [
        bench.item(Cmd.TAKEOFF, up_m=3.0),
        waypoint(bench, 6.0, 0.0, 3.0, hold_s=1.0, param4=270.0),
        waypoint(bench, 6.0, 6.0, 3.0, hold_s=60.0, param4=NAN),
    ]
    yaws = []
    bench.pilot.mission.replace(items)
    bench.pilot.start_mission()
    bench.pilot.arm()
    assert bench.run(30.0, lambda: 1 in bench.reached)
    yaws.append(bench.yaw_rad)
    bench.run(10.0)
    yaws.append(bench.yaw_rad)
    assert abs(abs(yaws[0]) - math.pi) < 0.3, "270 degrees by compass is west"
    assert yaws[1] == pytest.approx(math.pi / 2, abs=0.2), "none given: towards the waypoint"


TERRAIN_FRAME, HOME_FRAME = 10, 6


@pytest.mark.parametrize(
    ("frame", "is_above_terrain"), [(TERRAIN_FRAME, True), (HOME_FRAME, False)]
)
def test_altitudes_above_terrain_count_from_the_relief(frame, is_above_terrain):
    relief = hills()
    bench = Bench(relief=relief)
    x, y = 11.0, -4.0
    ground_m = float(relief.height_m(x, y))
    assert ground_m > 2.0
    items = [
        bench.item(Cmd.TAKEOFF, 0.0, 0.0, 8.0),
        waypoint(bench, x, y, 9.0, hold_s=2.0, frame=frame),
        bench.item(Cmd.LAND, x, y, 0.0, frame=frame),
    ]
    assert fly(bench, items, 90.0)
    base_m = ground_m if is_above_terrain else 0.0
    assert closest(bench, x, y, base_m + 9.0) < 0.8
    # It lands on the slope whatever the altitude of the item says.
    east_m, north_m, _ = bench.plant.truth.position_enu_m
    standing_m = bench.plant.truth.position_enu_m[2] - float(relief.height_m(east_m, north_m))
    assert standing_m == pytest.approx(bench.plant.world.airframe.leg_length_m, abs=0.08)
