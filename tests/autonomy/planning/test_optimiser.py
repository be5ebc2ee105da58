"""The optimiser's gradient is right, and what it returns lies in the corridor and the limits."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.planning import LimitsError
from autonomy.planning.corridor import build_corridor
from autonomy.planning.errors import PlanningError
from autonomy.planning.limits import MotionBounds
from autonomy.planning.optimiser import EVADING, first_times, optimise
from autonomy.planning.program import PIECES, pieces_to_fill
from autonomy.planning.solver import Solver
from autonomy.planning.trajectory import coefficients_from_nodes
from tests.autonomy.planning_worlds import random_boxes, seeds

BOUNDS = MotionBounds(
    speed_horizontal_mps=4.0,
    speed_vertical_mps=2.0,
    acceleration_horizontal_mps2=3.0,
    acceleration_vertical_mps2=2.0,
)
NOTHING = random_boxes(np.random.default_rng(0), 0)


def corridor_of(points, max_leg_m=6.0):
    limits = (np.full(3, -30.0), np.full(3, 30.0))
    return build_corridor(
        np.asarray(points, float), NOTHING, limits, wanted_m=0.5, least_m=0.1, max_leg_m=max_leg_m
    )


def at_rest(point):
    return np.array([point, np.zeros(3), np.zeros(3)])


def solve(points, start=None, bounds=BOUNDS):
    start = at_rest(points[0]) if start is None else start
    solution = optimise(start, at_rest(points[-1]), corridor_of(points), bounds)
    nodes, durations = solution.nodes, solution.durations_s
    coefficients = coefficients_from_nodes(nodes, durations)
    share = np.linspace(0, 1, 40)
    t = (durations[:, None] * share)[..., None]
    samples = []
    for order in range(3):
        total = 0.0
        for power in range(order, 6):
            factor = np.prod(np.arange(power, power - order, -1))
            total = total + factor * coefficients[:, None, power] * t ** (power - order)
        samples.append(total.reshape(-1, 3))
    return nodes, durations, samples


def test_gradient_of_the_times_equals_finite_differences():
    points = np.array([[0, 0, 5], [8, 0, 5], [8, 9, 8]], dtype=float)
    corridor = corridor_of(points)
    solver = Solver(at_rest(points[0]), at_rest(points[-1]), corridor, BOUNDS)
    log_times = np.log(first_times(corridor, BOUNDS)) - 0.3
    _, gradient = solver.cost_and_gradient(log_times)
    h = 1e-4
    for k, exact in enumerate(gradient):
        step = h * np.eye(len(log_times))[k]
        higher, _ = solver.cost_and_gradient(log_times + step)
        lower, _ = solver.cost_and_gradient(log_times - step)
        assert exact == pytest.approx((higher - lower) / (2 * h), rel=2e-2, abs=2e-3)


@given(seeds)
@settings(max_examples=8)
def test_limits_hold_and_both_ends_are_met(seed):
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.uniform(-6, 6, (3, 3)), axis=0)
    nodes, durations, (_, velocity, acceleration) = solve(points)
    np.testing.assert_allclose(nodes[0], at_rest(points[0]), atol=1e-9)
    np.testing.assert_allclose(nodes[-1], at_rest(points[-1]), atol=1e-9)
    assert np.all(durations > 0)
    assert np.hypot(velocity[:, 0], velocity[:, 1]).max() <= 1.001 * BOUNDS.speed_horizontal_mps
    assert np.abs(velocity[:, 2]).max() <= 1.001 * BOUNDS.speed_vertical_mps
    across = np.hypot(acceleration[:, 0], acceleration[:, 1])
    assert across.max() <= 1.001 * BOUNDS.acceleration_horizontal_mps2
    assert np.abs(acceleration[:, 2]).max() <= 1.001 * BOUNDS.acceleration_vertical_mps2


def test_a_long_straight_way_is_flown_near_the_limits():
    points = np.array([[-25, 0, 5], [25, 0, 5]], dtype=float)
    _, durations, (_, velocity, _) = solve(points)
    assert velocity[:, 0].max() > 0.85 * BOUNDS.speed_horizontal_mps
    fastest = 50 / BOUNDS.speed_horizontal_mps + (
        BOUNDS.speed_horizontal_mps / BOUNDS.acceleration_horizontal_mps2
    )
    assert durations.sum() < 1.35 * fastest


def test_a_flying_start_is_continued_and_not_stopped_first():
    points = np.array([[-20, 0, 5], [20, 0, 5]], dtype=float)
    start = np.array([points[0], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    nodes, durations, (_, velocity, _) = solve(points, start)
    np.testing.assert_allclose(nodes[0], start, atol=1e-9)
    assert velocity[: len(velocity) // 2, 0].min() > 2.5
    assert durations.sum() < solve(points)[1].sum()


def test_a_start_that_cannot_stop_in_its_corridor_is_refused():
    points = np.array([[29.5, 0, 5], [0, 0, 5]], dtype=float)
    start = np.array([points[0], [3.9, 0.0, 0.0], [0.0, 0.0, 0.0]])
    with pytest.raises(PlanningError, match="can stop in the free space") as caught:
        solve(points, start)
    assert caught.type in {LimitsError, PlanningError}


def test_no_time_is_lost_below_a_speed_limit():
    points = np.array([[-25, 0, 5], [25, 0, 5]], dtype=float)
    _, _, (_, velocity, _) = solve(points)
    # Sides of the octagon are perpendicular to east: the limit itself is within reach but for cos.
    assert velocity[:, 0].max() > 0.995 * np.cos(np.pi / 8) * BOUNDS.speed_horizontal_mps


def test_a_plane_that_moves_is_never_crossed():
    points = np.array([[-10, 0, 5], [10, 0, 5]], dtype=float)
    free = corridor_of(points, max_leg_m=4.0)
    planes, rates = free.planes.copy(), np.zeros(free.planes.shape[:2])
    # A wall that withdraws eastwards at 1 m/s from x = -7.
    planes[:, 6], rates[:, 6] = (1.0, 0.0, 0.0, -7.0), 1.0
    moving = dataclasses.replace(free, planes=planes, moving_mps=rates)
    first = optimise(at_rest(points[0]), at_rest(points[-1]), free, BOUNDS)
    solution = optimise(
        at_rest(points[0]),
        at_rest(points[-1]),
        moving,
        BOUNDS,
        first_s=3 * first.durations_s,
        search=EVADING,
    )
    coefficients = coefficients_from_nodes(solution.nodes, solution.durations_s)
    begun = 0.0
    for c, duration in zip(coefficients, solution.durations_s, strict=True):
        t = np.linspace(0, duration, 50)
        x = np.polynomial.polynomial.polyval(t, c[:, 0])
        assert np.all(x <= -7.0 + begun + t + 1e-5)
        begun += duration
    assert begun > 16.9


def test_what_the_vehicle_cannot_do_is_tightened():
    points = np.array([[-10, 0, 5], [10, 0, 5]], dtype=float)
    quick = optimise(at_rest(points[0]), at_rest(points[-1]), corridor_of(points), BOUNDS)

    def weak(nodes, durations):
        most = np.maximum(np.abs(nodes[:-1, 2, 0]), np.abs(nodes[1:, 2, 0]))
        return np.clip(most / 0.4 - 1, 0, 0.5), np.zeros(len(durations))

    slow = optimise(
        at_rest(points[0]), at_rest(points[-1]), corridor_of(points), BOUNDS, excess=weak
    )
    assert np.abs(quick.nodes[:, 2, 0]).max() > 0.55
    assert np.abs(slow.nodes[:, 2, 0]).max() < 0.41
    assert slow.durations_s.sum() > quick.durations_s.sum()


def test_what_the_vehicle_can_never_do_is_named():
    points = np.array([[-10, 0, 5], [10, 0, 5]], dtype=float)

    def never(nodes, durations):
        return np.zeros(len(durations)), np.full(len(durations), 0.1)

    with pytest.raises(LimitsError, match=r"body rate stays 10% beyond"):
        optimise(at_rest(points[0]), at_rest(points[-1]), corridor_of(points), BOUNDS, excess=never)


def test_the_limit_that_stays_broken_is_named():
    points = np.array([[-10, 0, 5], [10, 0, 5]], dtype=float)
    corridor = corridor_of(points)
    solver = Solver(at_rest(points[0]), at_rest(points[-1]), corridor, BOUNDS)
    hasty = np.full(len(corridor), np.log(0.4))
    assert "horizontal acceleration needs" in solver.name_worst(hasty)
    assert solver.slack(hasty).max() > 1


@given(st.lists(st.floats(0.1, 20.0), min_size=1, max_size=25), st.integers(1, 12))
def test_pieces_are_cut_to_a_number_that_programs_are_built_for(lengths, least):
    counts = pieces_to_fill(np.array(lengths), least)
    assert np.all(counts >= 1)
    assert counts.sum() >= max(least, len(lengths))
    assert counts.sum() in PIECES or counts.sum() == len(lengths) > max(PIECES)
