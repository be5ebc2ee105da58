"""Obstacles that move: predicted distances, and proofs and replans that respect them."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning import (
    CertificateError,
    Craft,
    EvasionError,
    FlightLimits,
    MovingObstacles,
    PlannerCfg,
    PlanningError,
    certify,
    plan_leg,
    plan_trajectory,
    prepare,
    replan,
)
from autonomy.planning.moving_obstacles import distance_to_movers
from autonomy.planning.program import build
from autonomy.types import FlatReference
from tests.autonomy.planning_worlds import (
    GROUND,
    ball,
    field_of,
    quadrotor,
    random_boxes,
    seeds,
    town,
)

LIMITS = FlightLimits()
CFG = PlannerCfg(vehicle_radius_m=0.4, max_piece_m=4.0)
NOTHING = random_boxes(np.random.default_rng(0), 0)


def random_movers(rng, n):
    return MovingObstacles(
        position_enu_m=rng.uniform(-5, 5, (n, 3)),
        velocity_enu_mps=rng.uniform(-3, 3, (n, 3)),
        radius_m=rng.uniform(0.1, 1.0, n),
        half_extent_m=rng.uniform(0.0, 2.0, (n, 3)),
        yaw_rad=rng.uniform(-3, 3, n),
        growth_mps=0.3,
        horizon_s=2.5,
    )


@pytest.fixture(scope="module")
def way():
    """Twenty-two metres eastwards over open ground."""
    start = FlatReference(position_enu_m=(-11.0, 0.0, 4.0))
    field = field_of(GROUND)
    return plan_trajectory(start, (11.0, 0.0, 4.0), field, GROUND, Craft(LIMITS, quadrotor(), CFG))


def again(way, at_s=0.5, moving=None, **options):
    moving = {} if moving is None else {"moving": moving}
    return replan(way, at_s, GROUND, Craft(LIMITS, quadrotor(), CFG), **moving, **options)


@given(seeds)
def test_kernel_and_batch_tell_the_same_distances(seed):
    rng = np.random.default_rng(seed)
    movers = random_movers(rng, 4)
    points, times = rng.uniform(-8, 8, (20, 3)), rng.uniform(0, 2.4, 20)
    batch, away = movers.distances(points, times)
    np.testing.assert_allclose(np.linalg.norm(away, axis=-1), 1.0)
    for k, (point, t) in enumerate(zip(points, times, strict=True)):
        distance, nearest = distance_to_movers(*point, t, movers.movers)
        assert distance == pytest.approx(batch[:, k].min(), abs=1e-9)
        assert batch[nearest, k] == pytest.approx(batch[:, k].min(), abs=1e-9)
    assert distance_to_movers(0.0, 0.0, 0.0, 2.6, movers.movers) == (np.inf, -1)


@given(seeds)
def test_nothing_of_an_obstacle_is_beyond_its_reach(seed):
    rng = np.random.default_rng(seed)
    movers = random_movers(rng, 1)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    points = movers.position_enu_m[0] + rng.uniform(-3, 3, (200, 3))
    inside = movers.distances(points, np.zeros(200))[0][0] <= 0
    beyond = (points[inside] - movers.position_enu_m[0]) @ normal
    assert np.all(beyond <= movers.reach_m(0, normal) + 1e-9)


@given(st.floats(0.5, 3.5), st.floats(-3.0, 3.0), st.floats(-1.5, 1.5))
def test_a_plan_that_meets_what_moves_is_never_passed(meet_s, speed, miss_m):
    leg = plan_leg((0, 0, 5), (12, 0, 5), 0.0, LIMITS, quadrotor())
    x, y, z = leg.sample(meet_s).position_enu_m
    crossing = ball((x, y + miss_m - speed * meet_s, z), (0.0, speed, 0.0), growth_mps=0.0)
    t = np.arange(0.0, min(4.0, leg.duration_s), 0.002)
    true_m = crossing.distances(leg.positions(t), t)[0].min() - 0.4
    try:
        proof = certify(leg, NOTHING, 0.4, LIMITS, quadrotor(), moving=crossing)
    except CertificateError as error:
        assert "moving obstacle 0" in str(error)  # noqa: PT017 - either outcome is right
        assert true_m < 0.05
    else:
        assert 0 < proof.min_clearance_m <= true_m + 1e-3


def test_the_rest_of_a_plan_is_kept_when_nothing_moves(way):
    rest = again(way, 1.0)
    assert rest.duration_s == pytest.approx(way.duration_s - 1.0, rel=0.02)
    first, there = rest.sample(0.0), way.sample(1.0)
    np.testing.assert_allclose(first.position_enu_m, there.position_enu_m, atol=1e-6)
    np.testing.assert_allclose(first.velocity_enu_mps, there.velocity_enu_mps, atol=1e-6)
    np.testing.assert_allclose(first.acceleration_enu_mps2, there.acceleration_enu_mps2, atol=1e-6)
    assert first.yaw_rad == pytest.approx(there.yaw_rad, abs=1e-6)
    np.testing.assert_allclose(
        rest.sample(rest.duration_s).position_enu_m, (11.0, 0.0, 4.0), atol=1e-6
    )
    assert again(way, 1.0).durations_s.tobytes() == rest.durations_s.tobytes()


@pytest.mark.parametrize("heading", [0.5, 1.6, 3.1, -2.0])
def test_what_crosses_is_evaded_with_little_delay(way, heading):
    meet = way.positions(np.array([3.0]))[0]
    velocity = 2.0 * np.array([np.cos(heading), np.sin(heading), 0.0])
    crossing = ball(meet - 2.5 * velocity, velocity)
    t = np.arange(0.0, 4.0, 0.01)
    keeps_on = way.positions(0.5 + t)
    assert crossing.distances(keeps_on, t)[0].min() < 0
    rest = again(way, moving=crossing)
    assert crossing.distances(rest.positions(t), t)[0].min() > 0.4
    assert rest.duration_s < way.duration_s + 3.0


def test_a_plan_is_replanned_all_the_way_to_its_end(way):
    rest, flown_s = way, 0.0
    while rest.duration_s > 0.7:
        rest, flown_s = again(rest, 0.65), flown_s + 0.65
    assert flown_s + rest.duration_s == pytest.approx(way.duration_s, rel=0.05)
    end = rest.sample(rest.duration_s)
    np.testing.assert_allclose(end.position_enu_m, (11.0, 0.0, 4.0), atol=1e-6)


@pytest.mark.parametrize("seed", range(2))
def test_a_plan_through_a_town_is_replanned_five_times_a_second_without_a_failure(seed):
    obstacles = town(np.random.default_rng(seed))
    start, goal = FlatReference(position_enu_m=(-12.0, -12.0, 2.0)), (12.0, 12.0, 3.0)
    cfg = dataclasses.replace(CFG, min_pieces=6)
    plan = plan_trajectory(
        start, goal, field_of(obstacles), obstacles, Craft(LIMITS, quadrotor(), cfg)
    )
    rest, flown_s = plan, 0.0
    while rest.duration_s > 0.3:
        there = rest.sample(0.2)
        rest, flown_s = replan(rest, 0.2, obstacles, Craft(LIMITS, quadrotor(), cfg)), flown_s + 0.2
        np.testing.assert_allclose(rest.sample(0.0).position_enu_m, there.position_enu_m, atol=1e-6)
        assert rest.min_clearance_m > cfg.min_margin_m
    assert flown_s + rest.duration_s == pytest.approx(plan.duration_s, rel=0.05)


def test_programs_built_ahead_are_the_ones_that_replans_use():
    prepare([3])
    misses = build.cache_info().misses
    build(3, 12)
    assert build.cache_info().misses == misses


def test_a_vehicle_off_its_plan_goes_on_from_where_it_is(way):
    there = way.sample(1.0)
    x, y, z = there.position_enu_m
    start = dataclasses.replace(there, position_enu_m=(x, y + 0.3, z))
    rest = again(way, 1.0, start=start)
    np.testing.assert_allclose(rest.sample(0.0).position_enu_m, (x, y + 0.3, z), atol=1e-6)


def test_a_vehicle_that_has_left_the_corridor_is_told_so(way):
    start = FlatReference(position_enu_m=(-11.0, 12.5, 4.0))
    with pytest.raises(PlanningError, match=r"start \(-11\.00, 12\.50, 4\.00\) m is outside"):
        again(way, 1.0, start=start)


def test_what_cannot_be_passed_is_named(way):
    x, y, z = way.sample(0.5).position_enu_m
    with pytest.raises(EvasionError, match=r"no way past what moves.*valid: hold"):
        again(way, moving=ball((x + 0.5, y, z), (0.0, 0.0, 0.0), radius=0.6))


def test_plans_that_are_over_or_have_no_corridor_are_refused(way):
    with pytest.raises(PlanningError, match="valid: a plan of"):
        again(way, way.duration_s + 1.0)
    with pytest.raises(PlanningError, match="valid: a plan of"):
        again(plan_leg((0, 0, 5), (5, 0, 5), 0.0, LIMITS, quadrotor()), 0.2)


def test_predictions_that_are_none_are_refused():
    with pytest.raises(ValueError, match=r"velocity_enu_mps has shape \(1, 2\)"):
        MovingObstacles(
            position_enu_m=np.zeros((1, 3)),
            velocity_enu_mps=np.zeros((1, 2)),
            radius_m=np.ones(1),
            half_extent_m=np.zeros((1, 3)),
            yaw_rad=np.zeros(1),
        )
    with pytest.raises(ValueError, match="horizon_s 0"):
        ball((0, 0, 0), (0, 0, 0), horizon_s=0.0)
