"""The course: trajectories one after the other, then straight down onto the surface."""

import numpy as np
import pytest

from autonomy.planning import FlightLimits, plan_leg
from flightsim.mavlink.client.telemetry import Telemetry
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.pilot.course import Course

SECOND_US = 1_000_000


def leg(a, b):
    return plan_leg(a, b, 0.4, FlightLimits(), AIRFRAMES["iris"].quadrotor)


def test_nothing_is_followed_before_the_first_flight():
    course = Course(leg((0, 0, 1), (0, 0, 3)))
    assert not course.has_begun
    course.fly(leg((0, 0, 1), (0, 0, 3)), 5 * SECOND_US)
    assert course.has_begun
    assert course.reference(5 * SECOND_US).position_enu_m == (0, 0, 1)


def test_arrival_needs_time_place_and_rest():
    course = Course(leg((0, 0, 1), (4, 0, 3)))
    course.fly(course.trajectory, 0)
    late = round(course.trajectory.duration_s * 1e6) + 1
    there = Telemetry(position_enu_m=(4.0, 0.1, 3.0), velocity_enu_mps=(0.0, 0.0, 0.05))
    assert course.has_arrived(late, there)
    assert not course.has_arrived(late // 2, there)
    there.velocity_enu_mps = (0.5, 0.0, 0.0)
    assert not course.has_arrived(late, there)
    there.velocity_enu_mps, there.position_enu_m = (0.0, 0.0, 0.0), (4.0, 0.5, 3.0)
    assert not course.has_arrived(late, there)


def test_the_last_metre_is_steady_and_ends_below_the_surface():
    course = Course(leg((2, 3, 6), (2, 3, 4)))
    course.fly(course.trajectory, 0)
    begin_us = 10 * SECOND_US
    course.touch_down(begin_us, resting_height_m=3.1, speed_mps=0.8)
    heights, speeds = [], []
    for tick in range(300):
        reference = course.reference(begin_us + tick * 20_000)
        assert reference.position_enu_m[:2] == pytest.approx((2, 3))
        assert reference.yaw_rad == 0.4
        heights.append(reference.position_enu_m[2])
        speeds.append(-reference.velocity_enu_mps[2])
    assert heights[0] == pytest.approx(4.0)
    fall = -np.diff(heights) / 0.02
    above_m = np.array(heights[1:]) - 3.1
    assert fall[above_m > 0.45] == pytest.approx(0.8)
    is_sinking = above_m > -0.3
    assert np.all(np.diff(fall[is_sinking]) < 1e-9)
    assert fall[is_sinking] == pytest.approx(np.array(speeds[1:])[is_sinking], abs=0.03)
    assert fall[(above_m < 0.19) & (above_m > -0.2)] == pytest.approx(0.3)
    assert 2.5 < heights[-1] < 3.1
    assert course.reference(begin_us + 6 * SECOND_US).velocity_enu_mps == (0.0, 0.0, 0.0)


def test_a_pause_of_the_last_metre_keeps_its_height():
    course = Course(leg((2, 3, 6), (2, 3, 4)))
    course.fly(course.trajectory, 0)
    course.touch_down(10 * SECOND_US, resting_height_m=3.1, speed_mps=0.4)
    for time_us in range(11 * SECOND_US, 13 * SECOND_US, 20_000):
        course.pause(time_us)
        reference = course.reference(time_us)
        assert reference.position_enu_m == pytest.approx((2, 3, 3.6))
        assert reference.velocity_enu_mps == (0.0, 0.0, 0.0)
    later = course.reference(13 * SECOND_US + SECOND_US // 2)
    assert later.position_enu_m[2] == pytest.approx(3.6 - 0.42 * 0.4)


def test_a_pause_may_rise_up_to_a_height():
    course = Course(leg((2, 3, 6), (2, 3, 4)))
    course.fly(course.trajectory, 0)
    course.touch_down(10 * SECOND_US, resting_height_m=3.1, speed_mps=0.4)
    heights = []
    for time_us in range(11 * SECOND_US, 13 * SECOND_US, 20_000):
        course.pause(time_us, rise_to_m=3.8)
        heights.append(course.reference(time_us).position_enu_m[2])
    assert heights[0] == pytest.approx(3.6, abs=0.02)
    assert np.diff(heights).max() <= 0.0101
    assert heights[-1] == pytest.approx(3.8)


def test_it_sinks_on_from_another_place_onto_another_surface():
    course = Course(leg((2, 3, 6), (2, 3, 4)))
    course.fly(course.trajectory, 0)
    course.touch_down(10 * SECOND_US, resting_height_m=3.1, speed_mps=0.4)
    course.sink_from(11 * SECOND_US, (2.2, 3.1, 3.15), 2.9)
    assert course.reference(11 * SECOND_US).position_enu_m == pytest.approx((2.2, 3.1, 3.15))
    later = course.reference(12 * SECOND_US).position_enu_m
    assert later[:2] == pytest.approx((2.2, 3.1))
    assert later[2] == pytest.approx(2.85, abs=0.03)
    lowest = course.reference(30 * SECOND_US).position_enu_m
    assert lowest == pytest.approx((2.2, 3.1, 2.5))  # as far below that surface as before


def test_until_a_plan_takes_over_the_one_before_is_followed():
    first, second = leg((0, 0, 1), (4, 0, 1)), leg((1, 2, 1), (1, 2, 5))
    course = Course(first)
    course.fly(first, 0)
    course.fly(second, 2 * SECOND_US)
    assert course.trajectory is second
    before = course.reference(2 * SECOND_US - 1).position_enu_m
    assert before == pytest.approx(first.sample(2.0).position_enu_m, abs=1e-4)
    assert course.reference(2 * SECOND_US).position_enu_m == pytest.approx((1, 2, 1))
    assert course.elapsed_s(1 * SECOND_US) == -1.0


def test_a_new_flight_ends_the_touchdown():
    course = Course(leg((0, 0, 4), (0, 0, 2)))
    course.fly(course.trajectory, 0)
    course.touch_down(9 * SECOND_US, 1.0, 0.8)
    course.fly(leg((0, 0, 2), (0, 0, 5)), 10 * SECOND_US)
    assert course.reference(60 * SECOND_US).position_enu_m == pytest.approx((0, 0, 5))
