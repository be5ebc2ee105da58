"""Stops that are always at hand: soon, within the limits, clear of what stands and moves."""

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.planning import (
    CertificateError,
    Craft,
    EvasionError,
    FlightLimits,
    LimitsError,
    Obstacles,
    PlannerCfg,
    brake,
    certify,
    plan_leg,
    plan_trajectory,
)
from autonomy.planning.obstacles import join
from autonomy.types import FlatReference
from tests.autonomy.planning_worlds import GROUND, ball, field_of, quadrotor, town

LIMITS = FlightLimits()
CFG = PlannerCfg(vehicle_radius_m=0.4)
EAST = plan_leg((0.0, 0.0, 5.0), (30.0, 0.0, 5.0), 0.0, LIMITS, quadrotor())


def pillar(x, width):
    """In the way east, from the ground to far above it."""
    return Obstacles.boxes(
        np.array([[x, 0.0, 5.0]]), np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[0.4, width, 40.0]])
    )


def stop(plan, at_s, obstacles=GROUND, **options):
    return brake(plan, at_s, obstacles, Craft(LIMITS, quadrotor(), CFG), **options)


@functools.cache
def town_and_plan(seed):
    obstacles = town(np.random.default_rng(seed))
    start, field = FlatReference(position_enu_m=(-12.5, -12.5, 3.0)), field_of(obstacles)
    goal = (12.5, 12.5, 3.0)
    return obstacles, plan_trajectory(
        start, goal, field, obstacles, Craft(LIMITS, quadrotor(), CFG)
    )


def assert_goes_on_to_rest(rest, plan, at_s):
    first, there = rest.sample(0.0), plan.sample(at_s)
    for name in ("position_enu_m", "velocity_enu_mps", "acceleration_enu_mps2"):
        np.testing.assert_allclose(getattr(first, name), getattr(there, name), atol=1e-6)
    end = np.array([rest.duration_s])
    np.testing.assert_allclose(rest.derivatives(end, 1), 0.0, atol=1e-6)
    np.testing.assert_allclose(rest.derivatives(end, 2), 0.0, atol=1e-6)


@settings(max_examples=10)
@given(st.floats(0.0, 1.0), st.integers(0, 2))
def test_there_is_a_stop_from_everywhere_on_a_certified_plan(share, seed):
    obstacles, plan = town_and_plan(seed)
    at_s = share * plan.duration_s
    rest = stop(plan, at_s, obstacles)
    assert_goes_on_to_rest(rest, plan, at_s)
    proof = certify(rest, obstacles, 0.4, LIMITS, quadrotor(), margin_m=CFG.min_margin_m)
    assert rest.min_clearance_m == pytest.approx(proof.min_clearance_m)
    assert rest.duration_s < 5.0


def test_a_stop_in_the_open_takes_little_more_than_the_limits_ask():
    at_s = 0.5 * EAST.duration_s
    speed = EAST.sample(at_s).velocity_enu_mps[0]
    rest = stop(EAST, at_s)
    # The deceleration of least jerk peaks at 3/2 of its mean.
    assert rest.duration_s <= 1.3 * 1.5 * speed / LIMITS.acceleration_mps2
    path = rest.positions(np.linspace(0.0, rest.duration_s, 50))
    np.testing.assert_allclose(path[:, 1:], [[0.0, 5.0]] * 50, atol=1e-6)
    assert np.all(np.diff(path[:, 0]) >= -1e-9)


def test_where_a_straight_stop_would_touch_something_it_leads_aside():
    at_s = 0.5 * EAST.duration_s
    x = EAST.positions(np.array([at_s]))[0, 0]
    straight = stop(EAST, at_s)
    end = straight.positions(np.array([straight.duration_s]))[0, 0]
    obstacles = join([GROUND, pillar(end, 0.8)])
    with pytest.raises(CertificateError, match="clearance falls"):
        certify(straight, obstacles, 0.4, LIMITS, quadrotor())
    rest = stop(EAST, at_s, obstacles)
    assert rest.min_clearance_m > CFG.min_margin_m
    with pytest.raises(CertificateError, match=r"no stop from .* m/s could be proved.*valid"):
        stop(EAST, at_s, join([GROUND, pillar(x + 1.5, 60.0)]))


@pytest.mark.parametrize("velocity", [(0.0, -2.0, 0.0), (-3.0, 0.0, 0.0), (1.0, 1.5, 0.0)])
def test_a_vehicle_at_rest_steps_aside_and_stays_clear_until_the_horizon(velocity):
    stand = plan_leg((0.0, 0.0, 5.0), (0.0, 0.0, 5.0), 0.3, LIMITS, quadrotor())
    comes = ball(np.array((0.0, 0.0, 5.0)) - 2.5 * np.array(velocity), velocity)
    t = np.arange(0.0, comes.horizon_s, 0.01)
    assert comes.distances(stand.positions(t), t)[0].min() < 0
    rest = stop(stand, stand.duration_s + 3.0, moving=comes)
    assert comes.distances(rest.positions(t), t)[0].min() > 0.4
    assert rest.sample(0.0).yaw_rad == pytest.approx(0.3)


def test_what_leaves_no_room_for_a_stop_is_told_and_a_stop_without_it_remains():
    at_s = 0.5 * EAST.duration_s
    x, y, z = EAST.sample(at_s).position_enu_m
    close = ball((x + 1.0, y, z), (-3.0, 0.0, 0.0))
    with pytest.raises(EvasionError, match="no stop from"):
        stop(EAST, at_s, moving=close)
    assert stop(EAST, at_s).duration_s < 5.0


def test_a_start_beyond_the_limits_is_refused():
    fast = FlatReference(position_enu_m=(0.0, 0.0, 5.0), velocity_enu_mps=(9.0, 0.0, 0.0))
    with pytest.raises(LimitsError, match=r"horizontal speed of 9\.00; valid: at most"):
        stop(EAST, 0.0, start=fast)


def test_the_same_question_gets_the_same_stop():
    comes = ball((12.0, 4.0, 5.0), (0.0, -2.0, 0.0))
    one, other = (stop(EAST, 2.0, moving=comes) for _ in range(2))
    assert one.coefficients.tobytes() == other.coefficients.tobytes()


def test_nearer_than_the_margin_already_it_comes_no_nearer():
    # The vehicle's sphere of 0.4 m and a ball of 0.4 m, centres 0.6 m apart, moving on past it.
    at = EAST.sample(3.0).position_enu_m
    other = ball((at[0], at[1] + 0.6, at[2]), (0.0, 0.4, 0.0))
    rest = stop(EAST, 3.0, moving=other)
    times = np.arange(0.0, other.horizon_s, 0.02)
    still = ball((at[0], at[1] + 0.6, at[2]), (0.0, 0.4, 0.0), growth_mps=0.0)
    distances = still.distances(rest.positions(times), times)[0][0]
    assert distances.min() >= distances[0] - 1e-3
    with pytest.raises(EvasionError):
        stop(EAST, 3.0, moving=ball((at[0] + 0.6, at[1], at[2]), (-9.0, 0.0, 0.0)))
