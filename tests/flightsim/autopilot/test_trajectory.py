import math
from dataclasses import replace

from hypothesis import example, given
from hypothesis import strategies as st

from flightsim.autopilot.axis import braking_distance
from flightsim.autopilot.limits import MotionLimits, corner_speed, stoppable_speed
from flightsim.autopilot.trajectory import PathMotion, VelocityMotion, direction_between

DT = 0.02
LIMITS = MotionLimits(
    speed_xy_mps=5.0,
    speed_up_mps=3.0,
    speed_down_mps=1.5,
    acceleration_xy_mps2=3.0,
    acceleration_up_mps2=4.0,
    acceleration_down_mps2=3.0,
    jerk_mps3=4.0,
)
coordinates = st.floats(-30.0, 30.0)
points = st.tuples(coordinates, coordinates, st.floats(0.0, 20.0))


def minus(p, q):
    return tuple(a - b for a, b in zip(p, q, strict=True))


def dot(p, q):
    return sum(a * b for a, b in zip(p, q, strict=True))


def fly(path, seconds=120.0):
    """Step until the path rests; yields it after each tick."""
    for _ in range(round(seconds / DT)):
        path.step(DT)
        yield path
        if path.is_at_rest:
            return


def assert_within_limits(path, factor=1.001):
    vx, vy, vz = path.velocity_enu_mps
    assert math.hypot(vx, vy) <= LIMITS.speed_xy_mps * factor
    assert -LIMITS.speed_down_mps * factor <= vz <= LIMITS.speed_up_mps * factor
    ax, ay, az = path.acceleration_enu_mps2
    assert math.hypot(ax, ay) <= LIMITS.acceleration_xy_mps2 * factor
    assert abs(az) <= LIMITS.acceleration_down_mps2 * factor


@given(points, points)
@example((0.0, 0.0, 0.0), (0.0, 0.0, 20.0))
@example((0.0, 0.0, 20.0), (0.0, 0.0, 0.0))
@example((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
def test_a_flight_from_rest_stays_on_its_line_within_limits_and_ends_at_the_goal(start, goal):
    path = PathMotion()
    path.reset(start)
    path.fly_to(goal, LIMITS)
    u = direction_between(start, goal) or (1.0, 0.0, 0.0)
    length = math.dist(start, goal)
    tolerance = 1e-6 if length > 1e-3 else 1e-3  # a way below 0.1 mm has no direction
    for p in fly(path):
        assert_within_limits(p)
        offset = minus(p.position_enu_m, start)
        along = dot(offset, u)
        assert -tolerance <= along <= length + 0.002
        assert math.hypot(*minus(offset, tuple(along * c for c in u))) < tolerance
    assert path.is_at_rest
    assert math.dist(path.position_enu_m, goal) < 1e-9
    assert path.velocity_enu_mps == (0.0, 0.0, 0.0)


@given(points, points, points, st.floats(0.0, 8.0))
def test_a_new_goal_in_flight_keeps_the_motion_continuous_and_is_reached(a, b, c, after_s):
    path = PathMotion()
    path.reset(a)
    path.fly_to(b, LIMITS)
    for _ in range(int(after_s / DT)):
        path.step(DT)
    path.fly_to(c, LIMITS)
    jerk, acceleration = LIMITS.jerk_mps3, LIMITS.acceleration_xy_mps2
    before = (path.position_enu_m, path.velocity_enu_mps, path.acceleration_enu_mps2)
    for p in fly(path):
        # Three axes with the limits of each: at most sqrt(3) of one.
        assert math.dist(p.acceleration_enu_mps2, before[2]) <= math.sqrt(3) * jerk * DT * 1.01
        # An oblique axis has sqrt(2) of the horizontal limit: sqrt(2 + 1 + 1) in the worst case.
        assert math.dist(p.velocity_enu_mps, before[1]) <= 2.3 * acceleration * DT + 2e-3
        assert math.dist(p.position_enu_m, before[0]) <= 10.0 * DT
        before = (p.position_enu_m, p.velocity_enu_mps, p.acceleration_enu_mps2)
    assert path.is_at_rest
    assert math.dist(path.position_enu_m, c) < 1e-6


@given(points, points, st.floats(0.0, 6.0))
def test_a_stop_needs_no_turning_back(start, goal, after_s):
    path = PathMotion()
    path.reset(start)
    path.fly_to(goal, LIMITS)
    for _ in range(int(after_s / DT)):
        path.step(DT)
    velocity = path.velocity_enu_mps
    path.fly_to(path.stopping_point(LIMITS), LIMITS)
    for p in fly(path):
        assert dot(p.velocity_enu_mps, velocity) >= -1e-3 * math.hypot(*velocity)
        assert_within_limits(p)
    assert path.is_at_rest


@given(points, st.floats(3.0, 20.0), st.floats(3.0, 20.0), st.floats(-math.pi, math.pi))
def test_a_corner_is_rounded_inside_its_acceptance_radius(start, first_m, second_m, turn_rad):
    radius_m = min(2.0, 0.5 * first_m)
    corner = (start[0] + first_m, start[1], start[2])
    end = (
        corner[0] + second_m * math.cos(turn_rad),
        corner[1] + second_m * math.sin(turn_rad),
        start[2],
    )
    leaving = direction_between(corner, end)
    assert leaving is not None
    speed = corner_speed((1.0, 0.0, 0.0), leaving, radius_m, second_m, LIMITS)
    path = PathMotion()
    path.reset(start)
    path.fly_to(corner, LIMITS, exit_speed_mps=speed)
    while math.dist(path.position_enu_m, corner) > radius_m:
        path.step(DT)
        assert_within_limits(path)
    path.fly_to(end, LIMITS, line_start_enu_m=corner)
    n = (-leaving[1], leaving[0], 0.0)
    side = dot(minus(start, corner), n)
    for p in fly(path):
        offset = minus(p.position_enu_m, corner)
        across = dot(offset, n)
        # Never beyond the next line on its outer side by more than a hand's length,
        assert across * math.copysign(1.0, side) >= -0.2
        # never outside the radius behind the corner.
        assert dot(offset, leaving) >= -radius_m - 0.2
        assert dot(offset, leaving) <= second_m + 0.2
    assert math.dist(path.position_enu_m, end) < 1e-6


def test_asking_for_the_same_goal_again_changes_nothing():
    once, again = PathMotion(), PathMotion()
    for path in (once, again):
        path.reset((0.0, 0.0, 2.0))
        path.fly_to((10.0, 4.0, 5.0), LIMITS)
    for _ in range(400):
        again.fly_to((10.0, 4.0, 5.0), LIMITS)
        once.step(DT)
        again.step(DT)
        assert once.position_enu_m == again.position_enu_m


def test_other_limits_take_effect_in_flight():
    path = PathMotion()
    path.reset((0.0, 0.0, 2.0))
    path.fly_to((60.0, 0.0, 2.0), LIMITS)
    for _ in range(200):
        path.step(DT)
    assert math.isclose(path.velocity_enu_mps[0], 5.0, rel_tol=1e-3)
    path.fly_to((60.0, 0.0, 2.0), replace(LIMITS, speed_xy_mps=2.0))
    for _ in range(200):
        path.step(DT)
    assert math.isclose(path.velocity_enu_mps[0], 2.0, rel_tol=1e-3)


@given(st.floats(0.0, 200.0), st.floats(0.5, 8.0), st.floats(1.0, 30.0))
def test_the_stoppable_speed_stops_within_the_distance(distance_m, a_max, j_max):
    speed = stoppable_speed(distance_m, a_max, j_max)
    assert math.isclose(
        braking_distance(speed, 0.0, 0.0, a_max, j_max), distance_m, rel_tol=1e-6, abs_tol=1e-9
    )


@given(st.lists(st.tuples(*[st.floats(-5.0, 5.0)] * 3), min_size=1, max_size=8))
def test_a_wanted_velocity_is_followed_within_limits(velocities):
    motion = VelocityMotion()
    motion.reset((0.0, 0.0, 5.0))
    for velocity in velocities:
        for _ in range(25):
            motion.step(velocity, LIMITS, DT)
            for axis in motion.axes:
                assert abs(axis.a) <= 3.0 * 1.001
                assert abs(axis.j) <= 4.0 * 1.001
    for _ in range(400):
        motion.step(velocities[-1], LIMITS, DT)
    for axis, wanted in zip(motion.axes, velocities[-1], strict=True):
        assert math.isclose(axis.v, wanted, abs_tol=1e-3)
