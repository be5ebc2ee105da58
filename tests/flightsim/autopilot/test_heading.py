import math

from hypothesis import given
from hypothesis import strategies as st

from flightsim.autopilot.circle import CircleMotion
from flightsim.autopilot.heading import HeadingMotion, wrap_angle
from flightsim.autopilot.limits import MotionLimits

angles = st.floats(-math.pi, math.pi)
DT = 0.02


@given(angles, angles)
def test_turns_the_shorter_way_and_stops_at_the_goal(start, goal):
    heading = HeadingMotion()
    heading.reset(start)
    heading.goal_yaw_rad = goal
    turned, before = 0.0, start
    for _ in range(600):
        heading.step(DT, 1.0, 1.0)
        turned += wrap_angle(heading.yaw_rad - before)
        before = heading.yaw_rad
        assert abs(heading.yaw_rate_radps) <= 1.001
    assert abs(wrap_angle(heading.yaw_rad - goal)) < 1e-6
    assert abs(turned) <= math.pi + 0.01


@given(st.floats(-100.0, 100.0))
def test_wrapping_keeps_the_direction(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)


def test_a_rate_limit_slows_the_turn():
    heading = HeadingMotion()
    heading.reset(0.0)
    heading.goal_yaw_rad, heading.rate_limit_radps = 3.0, 0.2
    fastest = 0.0
    for _ in range(300):
        heading.step(DT, 1.0, 1.0)
        fastest = max(fastest, heading.yaw_rate_radps)
    assert math.isclose(fastest, 0.2, rel_tol=1e-3)


def test_circle_derivatives_are_those_of_its_positions():
    limits = MotionLimits(
        speed_xy_mps=5.0,
        speed_up_mps=3.0,
        speed_down_mps=1.5,
        acceleration_xy_mps2=3.0,
        acceleration_up_mps2=4.0,
        acceleration_down_mps2=3.0,
        jerk_mps3=4.0,
    )
    circle = CircleMotion((1.0, 2.0, 5.0), 4.0, is_clockwise=True)
    circle.entry_from((9.0, 2.0, 0.0))
    samples = []
    for _ in range(200):
        circle.step(10.0, limits, DT)
        samples.append(circle.derivatives())
    for (p0, v0, _, _), (_, v1, a1, _), (p2, v2, _, _) in zip(
        samples, samples[1:], samples[2:], strict=False
    ):
        for i in range(3):
            assert math.isclose((p2[i] - p0[i]) / (2 * DT), v1[i], abs_tol=2e-3)
            assert math.isclose((v2[i] - v0[i]) / (2 * DT), a1[i], abs_tol=4e-2)
        assert math.hypot(*a1) <= 3.0 * 1.001
    assert samples[10][1][1] < 0.0, "clockwise from the east side is southward"
