import math

from hypothesis import example, given
from hypothesis import strategies as st

from flightsim.autopilot.axis import AxisMotion, braking_distance

DT = 0.02
limits = st.tuples(
    st.floats(0.3, 12.0),  # speed
    st.floats(1.0, 6.0),  # acceleration
    st.floats(2.0, 40.0),  # jerk
)


def drive(motion, v_max, a_max, j_max, n_ticks=20_000):
    """Step to the goal; yield the motion after each tick until it rests."""
    for _ in range(n_ticks):
        if motion.is_at_rest:
            return
        motion.step_to_goal(v_max, a_max, j_max, DT)
        yield motion


def fastest_s(distance, v_max, a_max, j_max):
    """Duration of the time-optimal motion from rest to rest, in closed form."""
    if v_max * j_max >= a_max**2:
        ramp_s, to_speed_s = a_max / j_max, a_max / j_max + v_max / a_max
    else:
        ramp_s, to_speed_s = math.sqrt(v_max / j_max), 2 * math.sqrt(v_max / j_max)
    cruise_s = distance / v_max - to_speed_s
    if cruise_s > 0:
        return 2 * to_speed_s + cruise_s
    ramp_s = a_max / j_max
    if distance >= 2 * a_max * ramp_s**2:
        return ramp_s + 2 * math.sqrt(ramp_s**2 / 4 + distance / a_max)
    return 4 * (distance / (2 * j_max)) ** (1 / 3)


@given(st.floats(1e-3, 60.0), limits)
@example(10.0, (5.0, 3.0, 4.0))
def test_from_rest_limits_hold_and_the_goal_is_never_passed(distance, bounds):
    v_max, a_max, j_max = bounds
    motion = AxisMotion(-distance)
    for m in drive(motion, *bounds):
        # A switch of the jerk falls within a tick.
        assert abs(m.v) <= v_max + 0.25 * j_max * DT**2
        assert abs(m.a) <= a_max * 1.001
        assert abs(m.j) <= j_max * 1.001
        assert m.x < 1e-3 + j_max * DT**2
    assert motion.is_at_rest
    assert motion.x == 0.0


@given(st.floats(0.01, 60.0), limits)
def test_from_rest_the_motion_is_as_fast_as_the_limits_allow(distance, bounds):
    n_ticks = sum(1 for _ in drive(AxisMotion(-distance), *bounds))
    assert n_ticks * DT <= fastest_s(distance, *bounds) + 0.3


@given(st.floats(-20.0, 20.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), limits)
@example(0.0, 1.0, 1.0, (5.0, 3.0, 4.0))
def test_any_motion_within_limits_comes_to_rest_at_the_goal(x, v_share, a_share, bounds):
    v_max, a_max, j_max = bounds
    motion = AxisMotion(x, v_share * v_max, a_share * a_max)
    # A speed that the present acceleration cannot help reaching counts as a limit.
    highest = max(v_max, abs(motion.v + motion.a * abs(motion.a) / (2 * j_max)))
    for m in drive(motion, *bounds):
        assert abs(m.v) <= highest + 0.25 * j_max * DT**2
        assert abs(m.a) <= a_max * 1.001
        assert abs(m.j) <= j_max * 1.001
    assert motion.is_at_rest


@given(st.floats(-10.0, 10.0), limits, st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=6))
def test_a_goal_that_jumps_never_makes_the_motion_jump(x, bounds, jumps):
    v_max, a_max, j_max = bounds
    motion = AxisMotion(x)
    for jump in jumps:
        motion.x += jump
        for _ in range(20):
            x0, v0, a0 = motion.x, motion.v, motion.a
            motion.step_to_goal(v_max, a_max, j_max, DT)
            assert abs(motion.a - a0) <= j_max * DT * 1.001
            assert abs(motion.v - v0) <= a_max * DT * 1.001 + j_max * DT**2
            assert abs(motion.x - x0) <= v_max * DT * 1.001 + 1e-3


@given(st.floats(0.0, 10.0), st.floats(-3.0, 3.0), st.floats(3.0, 6.0), st.floats(1.0, 20.0))
def test_braking_distance_is_that_of_the_integrated_motion(v, a, a_max, j_max):
    expected = braking_distance(v, a, 0.0, a_max, j_max)
    motion = AxisMotion(0.0, v, a)
    for _ in range(200_000):
        if abs(motion.v) < 1e-6 and abs(motion.a) < 1e-6:
            break
        motion.step_to_velocity(0.0, a_max, j_max, 0.001)
    assert math.isclose(motion.x, expected, abs_tol=0.02 + 0.005 * abs(expected))


@given(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), limits)
def test_a_wanted_velocity_is_reached_without_overshoot(v, goal, bounds):
    _, a_max, j_max = bounds
    motion = AxisMotion(0.0, v)
    tolerance = 0.25 * j_max * DT**2  # a switch of the jerk falls within a tick
    low, high = min(v, goal) - tolerance, max(v, goal) + tolerance
    for _ in range(3000):
        motion.step_to_velocity(goal, a_max, j_max, DT)
        assert low <= motion.v <= high
        assert abs(motion.a) <= a_max * 1.001
        assert abs(motion.j) <= j_max * 1.001
    assert math.isclose(motion.v, goal, abs_tol=1e-3)


def test_with_an_exit_speed_the_goal_is_passed_at_it():
    motion = AxisMotion(-20.0)
    while motion.x < 0.0:
        motion.step_to_goal(5.0, 3.0, 4.0, DT, v_exit=2.0)
    assert math.isclose(motion.v, 2.0, abs_tol=0.05)
    for _ in range(500):
        motion.step_to_goal(5.0, 3.0, 4.0, DT, v_exit=2.0)
    assert motion.is_at_rest
