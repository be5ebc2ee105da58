"""Precision landing on a target that a companion reports."""

import math

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from tests.flightsim.mavlink.wire import named

LOCAL, BODY = 1, 12
NAN = math.nan
TARGET_NED_M = (2.0, -1.5, 0.0)
"""In the vehicle's local frame, which begins where it starts."""
PRECLAND = (1, 4, 9)
"""Parameters of MAV_CMD_DO_SET_MODE."""


def report(flight, *, position=None, frame=LOCAL, angles=(0.0, 0.0), distance_m=0.0):
    x, y, z = position or (0.0, 0.0, 0.0)
    flight.send(
        "LANDING_TARGET",
        flight.plant.time_us,
        0,
        frame,
        *angles,
        distance_m,
        0.0,
        0.0,
        x=x,
        y=y,
        z=z,
        position_valid=int(position is not None),
    )


def true_offset_ned_m(flight):
    """From the vehicle to the target, by the truth."""
    east, north, up = flight.plant.truth.position_enu_m
    x0, y0, z0 = flight.server._view.origin_enu_m
    x, y, z = TARGET_NED_M
    return (x - (north - y0), y - (east - x0), z + (up - z0))


def land(flight, tell, limit_s=60.0):
    """Let a companion report at 10 Hz until the vehicle has landed; return the miss in metres."""
    for tick in range(round(50 * limit_s)):
        if tick % 5 == 0:
            tell()
        flight.step()
        if not flight.autopilot.is_armed:
            break
    assert not flight.autopilot.is_armed
    return math.hypot(*true_offset_ned_m(flight)[:2])


def test_it_lands_on_a_target_in_the_local_frame(flight):
    flight.take_off(6.0)
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, *PRECLAND) == 0
    assert flight.autopilot.mode is Mode.PRECISION_LAND
    assert land(flight, lambda: report(flight, position=TARGET_NED_M)) < 0.25


def test_it_lands_on_a_target_that_a_camera_sees_at_angles(flight):
    flight.take_off(6.0)
    assert flight.command(mav.MAV_CMD_NAV_LAND, 0, 2, 0, NAN, NAN, NAN, NAN) == 0

    def tell():
        north, east, down = true_offset_ned_m(flight)
        yaw = flight.server._view.rpy_rad[2]
        forward = math.cos(yaw) * north + math.sin(yaw) * east
        right = math.cos(yaw) * east - math.sin(yaw) * north
        down = max(down, 0.05)
        report(
            flight, angles=(math.atan2(right, down), -math.atan2(forward, down)), distance_m=down
        )

    assert land(flight, tell) < 0.3


def test_a_target_that_moves_is_followed_down(flight):
    flight.take_off(5.0)
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, *PRECLAND) == 0
    start_us, moved_m = flight.plant.time_us, 0.0

    def tell():
        nonlocal moved_m
        moved_m = min(0.15e-6 * (flight.plant.time_us - start_us), 1.0)
        report(flight, position=(TARGET_NED_M[0], TARGET_NED_M[1] + moved_m, 0.0))

    land(flight, tell)
    north_m, east_m, _ = true_offset_ned_m(flight)
    assert moved_m == 1.0
    assert math.hypot(north_m, east_m + moved_m) < 0.25


@pytest.mark.parametrize(("mode", "waits_s"), [(1, 0.0), (2, 4.0)])
def test_without_a_target_it_lands_where_it_is_at_once_or_after_a_wait(flight, mode, waits_s):
    flight.take_off(4.0)
    flight.autopilot.parameters.set("PLD_SRCH_TOUT", 4.0)
    assert flight.command(mav.MAV_CMD_NAV_LAND, 0, mode, 0, NAN, NAN, NAN, NAN) == 0
    begun_us = flight.plant.time_us
    flight.run_until(lambda: "Landing target not seen" in texts(flight), 20.0)
    assert 1e-6 * (flight.plant.time_us - begun_us) >= waits_s
    flight.run_until(lambda: not flight.autopilot.is_armed, 40.0)


@pytest.mark.parametrize(
    "fields",
    [
        {"position": (NAN, 0.0, 0.0)},
        {"position": (1e6, 0.0, 0.0)},
        {"position": (0.0, 0.0, 0.0), "frame": 3},
        {"angles": (NAN, 0.0), "distance_m": 5.0},
        {"angles": (1.57, 0.0), "distance_m": 5.0},
    ],
)
def test_a_report_that_makes_no_sense_is_dropped(flight, fields):
    report(flight, **fields)
    flight.step()
    assert flight.autopilot.landing_target.at(flight.plant.time_us) is None


def test_a_target_beside_the_body_counts_along_the_heading(flight):
    flight.become_ready()
    report(flight, position=(3.0, 0.0, 1.0), frame=BODY)
    flight.step()
    east, north, _ = flight.autopilot.landing_target.at(flight.plant.time_us)
    x, y, _ = flight.plant.truth.position_enu_m
    assert (east - x, north - y) == pytest.approx(
        (3.0 * math.cos(0.7), 3.0 * math.sin(0.7)), abs=0.3
    )


def test_landings_of_a_precision_that_there_is_not_are_denied(flight):
    flight.take_off(2.0)
    answer = flight.command(mav.MAV_CMD_NAV_LAND, 0, 3, 0, NAN, NAN, NAN, NAN)
    assert answer == mav.MAV_RESULT_DENIED


def texts(flight):
    return "".join(m.text for m in named(flight.heard, "STATUSTEXT"))
