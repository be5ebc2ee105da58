"""OBSTACLE_DISTANCE both ways: the vehicle's own ring scan, and what a companion reports."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.mavlink.conftest import START_ENU_M, Flight
from tests.flightsim.mavlink.wire import named
from tests.scenarios.landing_scenes import thing

AHEAD_M = 12.0
"""From the start to the wall, which faces the nose."""
WALL_SIZE_M = (1.0, 30.0, 10.0)
YAW_RAD = 0.7
NONE_CM, UNKNOWN_CM = 3001, 0xFFFF
BODY_FRD = mav.MAV_FRAME_BODY_FRD
FULL_AHEAD = 1000


@pytest.fixture(scope="module")
def walled(field):
    """The field with a wall ahead of the vehicle."""
    middle_m = AHEAD_M + 0.5 * WALL_SIZE_M[0]
    center = (
        START_ENU_M[0] + middle_m * math.cos(YAW_RAD),
        START_ENU_M[1] + middle_m * math.sin(YAW_RAD),
        0.5 * WALL_SIZE_M[2],
    )
    wall = thing(1, "container", center, WALL_SIZE_M, yaw_rad=YAW_RAD)
    scene = replace(field.scene, objects=(replace(wall, scene_id=field.scene.scene_id),))
    return build_world(scene, AIRFRAMES["iris"])


@pytest.fixture
def facing(walled):
    """A vehicle 3 m up, before the wall."""
    flight = Flight(walled)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.take_off(3.0)
    yield flight
    flight.close()


def scanned_cm(flight):
    message_id = layout("OBSTACLE_DISTANCE").message_id
    assert flight.command(mav.MAV_CMD_REQUEST_MESSAGE, message_id) == 0
    return flight.last("OBSTACLE_DISTANCE")


def to_wall_m(flight):
    """True distance ahead."""
    offset = np.array(flight.plant.truth.position_enu_m) - START_ENU_M
    return AHEAD_M - offset[0] * np.cos(YAW_RAD) - offset[1] * np.sin(YAW_RAD)


def test_the_ring_scan_sees_the_wall_where_it_is(facing):
    scan = scanned_cm(facing)
    assert (scan.increment, scan.frame, scan.max_distance) == (5, BODY_FRD, 3000)
    assert scan.distances[0] == pytest.approx(100.0 * to_wall_m(facing), abs=15)
    for beam in (3, -3):
        slant = 100.0 * to_wall_m(facing) / np.cos(np.radians(15.0))
        assert scan.distances[beam] == pytest.approx(slant, abs=40)
    assert set(scan.distances[18:55]) == {NONE_CM}


def fly_ahead(flight, seconds, distances_cm=None, *, frame=BODY_FRD, offset_deg=0.0, step_deg=5.0):
    """Push the stick forward, and report what a companion sees, at 10 Hz."""
    assert flight.autopilot.set_mode(Mode.POSITION).is_accepted
    for tick in range(round(50 * seconds)):
        if tick % 5 == 0:
            flight.send("MANUAL_CONTROL", 1, FULL_AHEAD, 0, 500, 0, 0)
            if distances_cm is not None:
                seen = distances_cm if isinstance(distances_cm, list) else distances_cm()
                flight.send(
                    "OBSTACLE_DISTANCE",
                    *(0, 0, seen, 0, 20, 3000),
                    increment_f=step_deg,
                    angle_offset=offset_deg,
                    frame=frame,
                )
        flight.step()


def closest_m(flight, seconds, *args, **named_args):
    """Least true distance to the wall while it flies ahead."""
    least = [to_wall_m(flight)]
    step = flight.step

    def watched(count=1):
        came = step(count)
        least[0] = min(least[0], to_wall_m(flight))
        return came

    flight.step = watched
    fly_ahead(flight, seconds, *args, **named_args)
    flight.step = step
    return least[0]


def wall_ahead(flight):
    """What a forward sensor of 90 degrees sees of the wall, in sectors of 5 degrees."""

    def seen():
        slants = to_wall_m(flight) / np.cos(np.radians(np.arange(-45.0, 46.0, 5.0)))
        sectors = [round(100.0 * max(0.2, slant)) for slant in slants]
        return sectors + [UNKNOWN_CM] * (72 - len(sectors))

    return seen


def test_sticks_stop_at_the_distance_to_keep(facing):
    facing.autopilot.parameters.set("CP_DIST", 3.0)
    least_m = closest_m(facing, 15.0, wall_ahead(facing), offset_deg=-45.0)
    assert 2.7 < least_m < 3.3
    assert np.linalg.norm(facing.plant.truth.velocity_enu_mps) < 0.3


def test_without_collision_prevention_sticks_fly_into_the_wall(facing):
    assert closest_m(facing, 6.0, wall_ahead(facing), offset_deg=-45.0) < 1.0


@pytest.mark.parametrize("goes_blind", [0, 1])
def test_where_nothing_is_reported_the_way_is_closed_or_open(facing, goes_blind):
    facing.autopilot.parameters.set("CP_DIST", 3.0)
    facing.autopilot.parameters.set("CP_GO_NO_DATA", goes_blind)
    start_m = to_wall_m(facing)
    fly_ahead(facing, 2.0)
    assert (start_m - to_wall_m(facing) > 1.0) == bool(goes_blind)


def test_obstacles_aside_do_not_stop_it(facing):
    facing.autopilot.parameters.set("CP_DIST", 3.0)
    aside = [NONE_CM] * 72
    aside[18] = aside[54] = 350
    start_m = to_wall_m(facing)
    fly_ahead(facing, 2.0, aside)
    assert start_m - to_wall_m(facing) > 1.0


def test_sectors_may_count_from_north_and_counterclockwise(facing):
    facing.autopilot.parameters.set("CP_DIST", 3.0)
    bearing_deg = 90.0 - np.degrees(YAW_RAD)
    ahead_only = [NONE_CM] * 72
    ahead_only[0] = 500
    start_m = to_wall_m(facing)
    fly_ahead(
        facing, 2.0, ahead_only, frame=mav.MAV_FRAME_GLOBAL, offset_deg=bearing_deg, step_deg=-5.0
    )
    assert start_m - to_wall_m(facing) < 4.0


@pytest.mark.parametrize(
    "fault",
    [
        {"increment_f": 0.0},
        {"increment_f": float("nan")},
        {"increment_f": 0.5},
        {"angle_offset": float("inf")},
        {"frame": 200},
    ],
)
def test_an_impossible_report_is_dropped_whole(flight, fault):
    fields = {"increment_f": 5.0, "angle_offset": 0.0, "frame": BODY_FRD} | fault
    flight.send("OBSTACLE_DISTANCE", 0, 0, [100] * 72, 0, 20, 3000, **fields)
    flight.step()
    assert flight.autopilot.collision_prevention._received_us is None
    assert not [m for m in named(flight.heard, "STATUSTEXT") if "error" in m.text.lower()]
