"""Trajectories meet their nodes, are smooth, and sample the same in plain floats and batches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.trajectory import (
    Trajectory,
    YawProfile,
    coefficients_from_nodes,
    rest_of,
)
from autonomy.planning.yaw import STEP_S, yaw_along_path
from tests.autonomy.planning_worlds import seeds


def random_trajectory(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    nodes, durations = rng.normal(0, 2, (n + 1, 3, 3)), rng.uniform(0.3, 4.0, n)
    yaw = YawProfile(step_s=0.1, yaw_rad=rng.normal(0, 1, 30))
    return nodes, Trajectory(
        durations_s=durations, coefficients=coefficients_from_nodes(nodes, durations), yaw=yaw
    )


@given(seeds)
def test_pieces_meet_every_node_in_position_velocity_and_acceleration(seed):
    nodes, trajectory = random_trajectory(seed)
    times = np.concatenate([[0.0], trajectory.ends_s])
    for order in range(3):
        for nudge in (-1e-9, 0.0):
            there = trajectory.derivatives(times + nudge, order)
            # Short pieces have large jerks: within the nudge the state changes by that much.
            slope = np.abs(trajectory.derivatives(times + nudge, order + 1)).max()
            np.testing.assert_allclose(there, nodes[:, order], atol=1e-6 + 2e-9 * slope)


@given(seeds)
def test_derivatives_are_what_finite_differences_say(seed):
    _, trajectory = random_trajectory(seed)
    rng = np.random.default_rng(seed)
    start = np.array(trajectory.ends_s) - trajectory.durations_s
    times = start + trajectory.durations_s * rng.uniform(0.1, 0.9, len(start))
    h = 1e-4
    for order in range(3):
        slope = (
            trajectory.derivatives(times + h, order) - trajectory.derivatives(times - h, order)
        ) / (2 * h)
        exact = trajectory.derivatives(times, order + 1)
        np.testing.assert_allclose(slope, exact, atol=1e-3 * (1 + np.abs(exact).max()))


@given(seeds, st.floats(0.0, 0.99))
def test_the_rest_of_a_trajectory_is_the_same_motion(seed, share):
    _, trajectory = random_trajectory(seed)
    at_s = share * trajectory.duration_s
    coefficients, durations, first = rest_of(trajectory, at_s)
    rest = Trajectory(durations_s=durations, coefficients=coefficients, yaw=trajectory.yaw)
    assert rest.duration_s == pytest.approx(trajectory.duration_s - at_s)
    assert len(durations) == len(trajectory.durations_s) - first
    t = np.linspace(0.0, rest.duration_s - 1e-9, 30)
    for order in range(3):
        there = trajectory.derivatives(at_s + t, order)
        scale = 1e-6 * (1 + np.abs(there).max())
        # At a node the jerk jumps, and rounding decides on which side a sample is.
        np.testing.assert_allclose(rest.derivatives(t, order), there, atol=scale)


@given(seeds)
def test_one_sample_equals_a_row_of_many(seed):
    _, trajectory = random_trajectory(seed)
    for t in np.random.default_rng(seed).uniform(0, trajectory.duration_s, 5):
        sample = trajectory.sample(float(t))
        for order, vector in enumerate(
            (
                sample.position_enu_m,
                sample.velocity_enu_mps,
                sample.acceleration_enu_mps2,
                sample.jerk_enu_mps3,
            )
        ):
            batch = trajectory.derivatives(np.array([t]), order)[0]
            np.testing.assert_allclose(vector, batch, rtol=1e-9, atol=1e-9)


def test_before_and_after_it_stands_still():
    nodes, trajectory = random_trajectory(4)
    for t, node in ((-1.0, nodes[0]), (trajectory.duration_s + 5.0, nodes[-1])):
        sample = trajectory.sample(t)
        np.testing.assert_allclose(sample.position_enu_m, node[0], atol=1e-9)
        assert sample.velocity_enu_mps == (0.0, 0.0, 0.0)


def test_yaw_profile_interpolates_and_then_holds():
    yaw = YawProfile(step_s=0.5, yaw_rad=np.array([0.0, 1.0, 0.5]))
    assert yaw.sample(0.25) == (0.5, 2.0)
    assert yaw.sample(0.75) == (0.75, -1.0)
    assert yaw.sample(9.0) == (0.5, 0.0)


def circle(speed, radius=10.0, seconds=12.0):
    angle = np.arange(0, seconds, STEP_S) * speed / radius
    return radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])


def test_yaw_follows_the_direction_of_flight_round_a_circle():
    positions = circle(speed=3.0)
    yaw = yaw_along_path(positions, 0.0, max_rate_radps=1.5, max_acceleration_radps2=3.0)
    travel = np.diff(positions, axis=0)
    direction = np.arctan2(travel[:, 1], travel[:, 0])
    error = np.angle(np.exp(1j * (yaw.yaw_rad[:-1] - direction)))
    assert np.abs(error[100:-20]).max() < 0.2


@given(seeds)
def test_yaw_keeps_its_limits_and_begins_where_it_is(seed):
    rng = np.random.default_rng(seed)
    positions = np.cumsum(rng.normal(0, 0.2, (200, 3)), axis=0)
    start = rng.uniform(-3, 3)
    yaw = yaw_along_path(positions, start, max_rate_radps=1.0, max_acceleration_radps2=2.0)
    rate = np.diff(yaw.yaw_rad) / STEP_S
    assert yaw.yaw_rad[0] == start
    assert np.abs(rate).max() <= 1.0 + 1e-9
    assert np.abs(np.diff(rate, prepend=0.0)).max() <= 2.0 * STEP_S + 1e-9


def test_yaw_turns_to_the_way_before_the_vehicle_departs():
    along_m = np.concatenate([np.zeros(60), 2.0 * STEP_S * np.arange(100)])
    positions = np.column_stack([along_m, np.zeros(160), np.full(160, 5.0)])
    yaw = yaw_along_path(positions, 2.0, max_rate_radps=1.5, max_acceleration_radps2=3.0)
    assert yaw.yaw_rad[0] == pytest.approx(2.0)
    assert np.abs(yaw.yaw_rad[60:]).max() < 0.1


def test_yaw_stays_while_climbing_straight_up():
    positions = np.column_stack([np.zeros(100), np.zeros(100), np.linspace(0, 10, 100)])
    yaw = yaw_along_path(positions, 0.7, max_rate_radps=1.0, max_acceleration_radps2=2.0)
    assert yaw.yaw_rad == pytest.approx(0.7)
