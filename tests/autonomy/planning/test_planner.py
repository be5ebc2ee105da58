"""Whole plans: certified in random towns, or refused with the reason."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings

from autonomy.planning import (
    BlockedError,
    CertificateError,
    Craft,
    FlightLimits,
    LimitsError,
    Obstacles,
    PlannerCfg,
    PlanningError,
    UnreachableError,
    plan_leg,
    plan_trajectory,
)
from autonomy.planning.obstacles import join
from autonomy.types import FlatReference
from tests.autonomy.planning_worlds import GROUND, field_of, quadrotor, seeds, town

LIMITS = FlightLimits()
CFG = PlannerCfg(vehicle_radius_m=0.4)
START = FlatReference(position_enu_m=(-12.0, -12.0, 2.0), yaw_rad=1.0)
GOAL = (12.0, 12.0, 3.0)


def box(center, size):
    return Obstacles.boxes(np.array([center]), np.array([[1.0, 0, 0, 0]]), np.array([size]))


def plan(obstacles, start=START, goal=GOAL, limits=LIMITS, field=None, cfg=CFG):
    field = field_of(obstacles) if field is None else field
    return plan_trajectory(start, goal, field, obstacles, Craft(limits, quadrotor(), cfg))


@given(seeds)
@settings(max_examples=6)
def test_plans_through_towns_are_free_smooth_and_end_at_rest_at_the_goal(seed):
    obstacles = town(np.random.default_rng(seed))
    try:
        trajectory = plan(obstacles)
    except (UnreachableError, BlockedError, CertificateError) as error:
        pytest.fail(f"corners of these towns are always free: {error}")
    dense = np.linspace(0, trajectory.duration_s, 4000)
    clearance = obstacles.signed_distance(trajectory.positions(dense))[0].min() - 0.4
    assert 0 < trajectory.min_clearance_m <= clearance
    first, last = trajectory.sample(0.0), trajectory.sample(trajectory.duration_s)
    np.testing.assert_allclose(first.position_enu_m, START.position_enu_m, atol=1e-6)
    np.testing.assert_allclose(last.position_enu_m, GOAL, atol=1e-6)
    np.testing.assert_allclose(last.velocity_enu_mps, 0, atol=1e-6)
    assert first.yaw_rad == START.yaw_rad
    step = np.diff(trajectory.derivatives(dense, 2), axis=0)
    assert np.abs(step).max() < 0.3


def test_a_moving_start_is_flown_on_from():
    start = dataclasses.replace(START, velocity_enu_mps=(2.0, 2.0, 0.0))
    sample = plan(GROUND, start).sample(0.0)
    np.testing.assert_allclose(sample.velocity_enu_mps, (2.0, 2.0, 0.0), atol=1e-6)


def test_the_vehicle_looks_along_its_way():
    trajectory = plan(GROUND, dataclasses.replace(START, yaw_rad=-2.0))
    on_the_way = np.linspace(0.5, 0.9, 9) * trajectory.duration_s
    for sample in map(trajectory.sample, on_the_way):
        east, north, _ = sample.velocity_enu_mps
        turn = sample.yaw_rad - math.atan2(north, east)
        assert math.hypot(east, north) > 0.5
        assert math.remainder(turn, 2 * math.pi) == pytest.approx(0.0, abs=0.1)


def test_a_narrow_gap_is_taken_where_there_is_no_other():
    left, right = box((0, -7.6, 6), (1, 13.8, 12)), box((0, 7.6, 6), (1, 13.8, 12))
    world = join([left, right, GROUND])
    trajectory = plan(world, field=field_of(world, resolution=0.25, half_extent=14.0))
    assert 0 < trajectory.min_clearance_m < 0.35
    crossing = trajectory.positions(np.linspace(0, trajectory.duration_s, 2000))
    assert np.abs(crossing[np.abs(crossing[:, 0]) < 0.2, 1]).max() < 0.3


def test_start_and_goal_in_an_obstacle_are_told_apart():
    world = join([box((-12, -12, 2), (1, 1, 1)), GROUND])
    with pytest.raises(BlockedError, match=r"start \(-12\.00.*obstacle 0"):
        plan(world)
    with pytest.raises(BlockedError, match=r"goal \(-12\.00"):
        plan(world, START.__class__(position_enu_m=GOAL), (-12.0, -12.0, 2.0))


def test_points_off_the_map_are_refused_with_its_extent():
    with pytest.raises(BlockedError, match="outside the map; valid:"):
        plan(GROUND, goal=(50.0, 0.0, 3.0))


def test_a_goal_behind_walls_is_unreachable():
    walls = [
        box((12 + 2 * dx, 12 + 2 * dy, 5), (0.5 + 4 * abs(dy), 0.5 + 4 * abs(dx), 10.4))
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))
    ]
    lid = box((12, 12, 10), (5, 5, 0.5))
    world = join([*walls, lid, GROUND])
    with pytest.raises(UnreachableError, match="cut off"):
        plan(world)


def test_a_start_faster_than_the_limits_is_named():
    start = dataclasses.replace(START, velocity_enu_mps=(0.0, 7.0, 0.0))
    with pytest.raises(LimitsError, match=r"start has a horizontal speed of 7\.00"):
        plan(GROUND, start)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"vehicle_radius_m": 0.0}, r"vehicle_radius_m 0\.0 is not valid; valid: a positive"),
        ({"margins_m": ()}, r"margins_m \(\) is not valid; valid: one or more"),
        ({"min_margin_m": float("nan")}, r"min_margin_m nan is not valid; valid: not negative"),
        ({"method": "guess"}, r"method 'guess' is not valid; valid: 'optimise' or"),
    ],
)
def test_ways_to_plan_that_are_none_are_refused_by_name(options, message):
    with pytest.raises(PlanningError, match=message):
        PlannerCfg(**({"vehicle_radius_m": 0.4} | options))


def test_states_that_are_not_finite_are_refused():
    nowhere = dataclasses.replace(START, position_enu_m=(float("nan"), 0.0, 2.0))
    with pytest.raises(BlockedError, match=r"start \(nan, 0\.00, 2\.00\) m is no place"):
        plan(GROUND, nowhere)
    with pytest.raises(LimitsError, match="start has a horizontal speed of nan"):
        plan(GROUND, dataclasses.replace(START, velocity_enu_mps=(float("nan"), 0.0, 0.0)))


def test_every_failure_is_a_planning_error():
    for error in (BlockedError, UnreachableError, LimitsError, CertificateError):
        assert issubclass(error, PlanningError)


def test_legs_are_as_fast_as_the_limits_allow_and_end_at_rest():
    leg = plan_leg((0, 0, 0), (3, 4, 2), 0.5, LIMITS, quadrotor())
    times = np.linspace(0, leg.duration_s, 2001)
    shares = (
        np.linalg.norm(leg.derivatives(times, 1)[:, :2], axis=1).max()
        / LIMITS.speed_horizontal_mps,
        np.abs(leg.derivatives(times, 1)[:, 2]).max() / LIMITS.speed_vertical_mps,
        np.linalg.norm(leg.derivatives(times, 2)[:, :2], axis=1).max() / LIMITS.acceleration_mps2,
        np.abs(leg.derivatives(times, 2)[:, 2]).max() / LIMITS.acceleration_vertical_mps2,
    )
    assert max(shares) == pytest.approx(1.0, abs=1e-3)
    assert leg.sample(0.3).yaw_rad == 0.5
    np.testing.assert_allclose(leg.sample(leg.duration_s).position_enu_m, (3, 4, 2), atol=1e-9)
