"""The baseline of Mueller 2015: what is passed can be flown, and whole plans are certified."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.planning import CertificateError, Craft, FlightLimits, PlannerCfg, plan_trajectory
from autonomy.planning.feasibility import is_input_feasible
from autonomy.planning.primitives import fly_primitives
from autonomy.planning.trajectory import coefficients_from_nodes, squared_jerk
from autonomy.types import FlatReference
from tests.autonomy.planning_worlds import GROUND, field_of, quadrotor, seeds, town

LIMITS = FlightLimits()
CFG = PlannerCfg(vehicle_radius_m=0.4, method="primitives")


def keeping(distance_m):
    cfg = PlannerCfg(vehicle_radius_m=distance_m, min_margin_m=0.0)
    return Craft(LIMITS, quadrotor(), cfg)


def dense(c, order, t):
    powers = [math.perm(n, order) * t[:, None] ** (n - order) * c[n] for n in range(order, 6)]
    return np.sum(powers, axis=0)


@given(seeds)
def test_recursive_feasibility_agrees_with_dense_samples(seed):
    rng = np.random.default_rng(seed)
    nodes = rng.normal(0, [[3.0], [2.0], [1.5]], (2, 3, 3))
    duration = rng.uniform(0.6, 4.0)
    c = coefficients_from_nodes(nodes, np.array([duration]))[0]
    t = np.linspace(0, duration, 3000)
    force = dense(c, 2, t) + np.array([0.0, 0.0, GRAVITY_MPS2])
    thrust = np.linalg.norm(force, axis=1)
    rate = np.linalg.norm(dense(c, 3, t), axis=1) / thrust
    if is_input_feasible(c, 0.0, duration, 16.0, 3.0):
        assert thrust.max() <= 16.0 + 1e-6
        assert rate.max() <= 3.0 + 1e-6
    # It bounds each axis by itself, so it may refuse what is near a limit, and nothing else.
    elif thrust.max() < 11.0:
        assert rate.max() > 1.0


@given(seeds)
def test_the_cost_is_the_integral_of_squared_jerk(seed):
    rng = np.random.default_rng(seed)
    duration = np.array([rng.uniform(0.3, 4.0)])
    c = coefficients_from_nodes(rng.normal(0, 2, (2, 3, 3)), duration)
    t = np.linspace(0, duration[0], 4001)
    square = np.sum(dense(c[0], 3, t) ** 2, axis=1)
    assert squared_jerk(c, duration)[0] == pytest.approx(np.trapezoid(square, t), rel=1e-4)


def least_jerk(begin, end, duration, n=400):
    """Reference: jerk of least square, constant in each of n steps, that joins two states."""
    h = duration / n
    left = duration - h * np.arange(1, n + 1)
    # What a unit of jerk in one step adds to position, velocity and acceleration at the end.
    reach = np.array(
        [h**3 / 6 + h**2 / 2 * left + h * left**2 / 2, h**2 / 2 + h * left, 0 * left + h]
    )
    drift = np.array([[1, duration, duration**2 / 2], [0, 1, duration], [0, 0, 1]])
    return np.linalg.pinv(reach) @ (end - drift @ begin)


@given(seeds)
@settings(max_examples=30)
def test_a_primitive_is_the_motion_of_least_jerk(seed):
    rng = np.random.default_rng(seed)
    nodes, duration = rng.normal(0, 2, (2, 3, 3)), rng.uniform(0.5, 5.0)
    c = coefficients_from_nodes(nodes, np.array([duration]))[0]
    reference, n = least_jerk(*nodes, duration), 400
    middles = duration * (np.arange(n) + 0.5) / n
    largest = np.abs(reference).max()
    np.testing.assert_allclose(dense(c, 3, middles), reference, atol=1e-3 * largest)
    cost = squared_jerk(c[None], np.array([duration]))[0]
    # Steps can only cost more, and little more.
    stepped = np.sum(reference**2) * duration / n
    assert cost <= stepped * (1 + 1e-9) <= cost * 1.001


def fly(c, duration, n=800):
    """Reference: a quadrotor that is told thrust over mass and body rates, integrated (RK4).

    Returns:
        Position and velocity at the end, the largest thrust over mass and the largest body rate.
    """
    up = np.array([0.0, 0.0, 1.0])

    def inputs(rotation, t):
        """What the primitive asks for: |a + g|, and rates that turn the thrust with the jerk."""
        at = np.array([t])
        thrust = np.linalg.norm(dense(c, 2, at)[0] + GRAVITY_MPS2 * up)
        j = rotation.T @ dense(c, 3, at)[0] / thrust
        return thrust, np.array([-j[1], j[0], 0.0])

    def change(state, t):
        rotation, velocity = state[6:].reshape(3, 3), state[3:6]
        thrust, (p, q, r) = inputs(rotation, t)
        turn = np.array([[0, -r, q], [r, 0, -p], [-q, p, 0]])
        pull = thrust * rotation[:, 2] - GRAVITY_MPS2 * up
        return np.concatenate([velocity, pull, (rotation @ turn).ravel()])

    body_up = dense(c, 2, np.zeros(1))[0] + GRAVITY_MPS2 * up
    rotation = Rotation.align_vectors(body_up[None], up[None])[0].as_matrix()
    state = np.concatenate([c[0], c[1], rotation.ravel()])
    h, asked = duration / n, []
    for t in h * np.arange(n):
        asked.append(inputs(state[6:].reshape(3, 3), t))
        one = change(state, t)
        two = change(state + h / 2 * one, t + h / 2)
        three = change(state + h / 2 * two, t + h / 2)
        four = change(state + h * three, t + h)
        state = state + h / 6 * (one + 2 * two + 2 * three + four)
    thrusts, rates = zip(*asked, strict=True)
    return state[:3], state[3:6], max(thrusts), np.linalg.norm(rates, axis=1).max()


@given(seeds, st.floats(11.5, 20.0), st.floats(1.0, 4.0))
@settings(max_examples=8)
def test_thrust_and_body_rates_within_their_limits_fly_a_feasible_primitive(seed, thrust, rate):
    rng = np.random.default_rng(seed)
    nodes = rng.normal(0, [[4.0], [2.0], [0.5]], (2, 3, 3))
    for duration in np.geomspace(0.5, 12.0, 40).tolist():
        c = coefficients_from_nodes(nodes, np.array([duration]))[0]
        if is_input_feasible(c, 0.0, duration, thrust, rate):
            break
    else:
        pytest.fail("even the slowest primitive is refused")
    position, velocity, most_thrust, most_rate = fly(c, duration)
    np.testing.assert_allclose(position, nodes[1, 0], atol=1e-4)
    np.testing.assert_allclose(velocity, nodes[1, 1], atol=1e-4)
    assert most_thrust <= thrust * (1 + 1e-6)
    assert most_rate <= rate * (1 + 1e-6)


@given(seeds)
@settings(max_examples=3)
def test_whole_plans_of_the_baseline_are_certified_too(seed):
    obstacles = town(np.random.default_rng(seed))
    start = FlatReference(position_enu_m=(-12.0, -12.0, 2.0))
    try:
        plan = plan_trajectory(
            start,
            (12.0, 12.0, 3.0),
            field_of(obstacles),
            obstacles,
            Craft(LIMITS, quadrotor(), CFG),
        )
    except CertificateError as error:
        assert "primitives" in str(error) or "reaches" in str(error)  # noqa: PT017 - may give up
        return
    assert plan.min_clearance_m > 0
    assert plan.corridor is None
    np.testing.assert_allclose(plan.sample(plan.duration_s).position_enu_m, (12, 12, 3), atol=1e-6)


def test_a_way_without_room_is_given_up_with_a_reason():
    way = np.array([[-3.0, 0.0, 0.5], [3.0, 0.0, 0.5]])
    start = np.array([way[0], np.zeros(3), np.zeros(3)])
    bounds = LIMITS.motion_bounds(quadrotor())
    with pytest.raises(CertificateError, match=r"no string of motion primitives.*'optimise'"):
        fly_primitives(start, way, GROUND, bounds, keeping(0.6))
    slow = dataclasses.replace(bounds, speed_horizontal_mps=1.0)
    c, t = fly_primitives(start, way, GROUND, slow, keeping(0.4))
    assert t.sum() > 6.0
    np.testing.assert_allclose(dense(c[-1], 0, t[-1:])[0], way[-1], atol=1e-6)
