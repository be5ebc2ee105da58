"""The potential field: minus a gradient, limited in speed and acceleration, zero far away."""

import numpy as np
import pytest
from hypothesis import given, settings

from scenarios.baselines.potential_field import FieldCfg, acceleration, repulsion
from tests.autonomy.planning_worlds import random_boxes, seeds

CFG = FieldCfg()
RADIUS_M = 0.4
NOTHING = random_boxes(np.random.default_rng(0), 0).solids


def world(seed):
    """A few boxes, and points with some room around them."""
    rng = np.random.default_rng(seed)
    boxes = random_boxes(rng, 6, extent=3.0)
    points = rng.uniform(-5, 5, (200, 3))
    return boxes, points[boxes.signed_distance(points)[0] > RADIUS_M + 0.15]


def potential(boxes, points):
    """Khatib's FIRAS potential, summed over boxes one by one."""
    total = np.zeros(len(points))
    for n in range(len(boxes)):
        one = type(boxes).boxes(
            boxes.center_enu_m[n : n + 1], boxes.quat_wxyz[n : n + 1], boxes.size_m[n : n + 1]
        )
        rho = one.signed_distance(points)[0] - RADIUS_M
        near = np.maximum(1 / rho - 1 / CFG.influence_m, 0.0)
        total += CFG.repulsion_m4ps2 / 2 * near**2
    return total


def push(boxes, point):
    return repulsion(point, boxes.solids, RADIUS_M, CFG.influence_m, CFG.repulsion_m4ps2)


@given(seeds)
@settings(max_examples=20)
def test_repulsion_is_minus_the_gradient_of_the_potential(seed):
    boxes, points = world(seed)
    h = 1e-5
    for point in points[:10]:
        steps = h * np.eye(3)
        slope = potential(boxes, point + steps) - potential(boxes, point - steps)
        away = push(boxes, point)
        np.testing.assert_allclose(away, -slope / (2 * h), atol=1e-4 * (1 + np.abs(away).max()))


@given(seeds)
@settings(max_examples=20)
def test_nothing_repels_beyond_the_influence_distance(seed):
    boxes, points = world(seed)
    room_m = boxes.signed_distance(points)[0] - RADIUS_M
    for point, room in zip(points, room_m, strict=True):
        assert (np.linalg.norm(push(boxes, point)) > 0) == (room < CFG.influence_m)


def test_far_from_the_goal_the_speed_limit_is_kept_without_effort():
    goal = np.array([30.0, -40.0, 0.0])
    cruise = CFG.speed_mps * goal / np.linalg.norm(goal)
    args = (NOTHING, RADIUS_M, CFG)
    np.testing.assert_allclose(acceleration(np.zeros(3), cruise, goal, *args), 0.0, atol=1e-12)
    faster = acceleration(np.zeros(3), 1.1 * cruise, goal, *args)
    assert faster @ goal < 0


@given(seeds)
@settings(max_examples=20)
def test_no_more_acceleration_is_asked_for_than_allowed(seed):
    boxes, points = world(seed)
    rng = np.random.default_rng(seed)
    for point in points[:10]:
        a = acceleration(
            point, rng.normal(0, 3, 3), rng.normal(0, 9, 3), boxes.solids, RADIUS_M, CFG
        )
        assert np.linalg.norm(a) <= CFG.acceleration_mps2 * (1 + 1e-9)


def test_in_a_wall_the_repulsion_stays_finite():
    boxes, _ = world(3)
    assert np.all(np.isfinite(push(boxes, boxes.center_enu_m[0])))


def test_with_nothing_about_the_point_comes_to_rest_at_the_goal():
    position, velocity, goal = np.zeros(3), np.zeros(3), np.array([6.0, 2.0, -1.0])
    for _ in range(1000):
        velocity = velocity + 0.02 * acceleration(position, velocity, goal, NOTHING, RADIUS_M, CFG)
        position = position + 0.02 * velocity
        assert np.linalg.norm(velocity) <= CFG.speed_mps + 1e-9
    np.testing.assert_allclose(position, goal, atol=0.02)
    assert np.linalg.norm(velocity) == pytest.approx(0.0, abs=0.02)
