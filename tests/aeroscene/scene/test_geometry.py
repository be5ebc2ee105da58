from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from aeroscene.scene import OrientedBox
from aeroscene.scene.box import (
    box_corners,
    quat_from_yaw,
    quat_product,
    rotation_matrix,
)
from aeroscene.scene.geometry import layer, penetration_depth
from aeroscene.scene.overlap import iou
from tests.aeroscene.scene.points import signed_distance

places = st.floats(-3, 3)
lengths = st.floats(0.2, 4)
angles = st.floats(-math.pi, math.pi)


@st.composite
def upright_boxes(draw) -> OrientedBox:
    p = (draw(places), draw(places), draw(places))
    return OrientedBox(
        p, quat_from_yaw(draw(angles)), (draw(lengths), draw(lengths), draw(lengths))
    )


@st.composite
def quaternions(draw) -> np.ndarray:
    q = np.array([draw(st.floats(-1, 1)) for _ in range(4)])
    assume(np.linalg.norm(q) > 0.1)
    return q / np.linalg.norm(q)


def fields(box: OrientedBox):
    return box.p, box.q, box.s


def moved(box: OrientedBox, offset: np.ndarray) -> OrientedBox:
    x, y, z = (np.asarray(box.p) + offset).tolist()
    return OrientedBox((x, y, z), box.q, box.s)


@given(quaternions())
def test_rotation_matrix_is_a_rotation_and_ignores_the_sign_of_the_quaternion(q):
    rotation = rotation_matrix(q)
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.isclose(np.linalg.det(rotation), 1.0)
    assert np.allclose(rotation, rotation_matrix(-q))


def test_corner_bits_are_the_signs_along_x_y_z():
    corners = OrientedBox((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (2.0, 4.0, 6.0)).corners()
    assert corners[0].tolist() == [0.0, 0.0, 0.0]
    assert corners[1].tolist() == [2.0, 0.0, 0.0]
    assert corners[2].tolist() == [0.0, 4.0, 0.0]
    assert corners[4].tolist() == [0.0, 0.0, 6.0]


@given(upright_boxes(), quaternions())
def test_corners_of_many_boxes_equal_those_of_each(box, q):
    p, s = np.array([box.p, box.s]), np.array([box.s, box.s])
    batch = box_corners(p, np.array([q, box.q]), s)
    assert np.allclose(batch[0], box_corners(p[0], q, s[0]))
    assert np.allclose(batch[1], box_corners(p[1], box.q, s[1]))
    centre_distance = np.linalg.norm(batch - p[:, None], axis=-1)
    assert np.allclose(centre_distance, np.linalg.norm(s, axis=-1)[:, None] / 2)


@pytest.mark.parametrize(
    ("offset", "yaw", "expected"),
    [
        ((0, 0, 0), 0.0, 1.0),
        ((1, 0, 0), 0.0, 1 / 3),
        ((0, 1, 1), 0.0, 1 / 7),
        ((2, 0, 0), 0.0, 0.0),
        ((0, 0, 5), 0.0, 0.0),
        # Two squares of side 2, one turned by 45 degrees: an octagon of area 8 (sqrt 2 - 1).
        ((0, 0, 0), math.pi / 4, 8 * (math.sqrt(2) - 1) / (8 - 8 * (math.sqrt(2) - 1))),
    ],
)
def test_iou_of_two_cubes_is_the_analytic_value(offset, yaw, expected):
    cube = OrientedBox((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
    other = OrientedBox(tuple(map(float, offset)), quat_from_yaw(yaw), (2.0, 2.0, 2.0))
    assert iou(cube, other) == pytest.approx(expected, abs=1e-7)


@given(upright_boxes(), upright_boxes())
def test_iou_is_symmetric_and_equals_counting_points(first, second):
    value = iou(first, second)
    assert value == pytest.approx(iou(second, first), abs=1e-9)
    corners = np.concatenate([first.corners(), second.corners()])
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (20_000, 3))
    in_first = signed_distance(points, *fields(first)) <= 0
    in_second = signed_distance(points, *fields(second)) <= 0
    n_points = (in_first | in_second).sum()
    assume(n_points >= 200)  # thin boxes far apart catch too few points to say anything
    counted = (in_first & in_second).sum() / n_points
    # Six standard deviations of the share that so many points give.
    assert value == pytest.approx(counted, abs=3.0 / np.sqrt(n_points))


NARROW = OrientedBox((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.5, 1.0, 1.0))


@given(upright_boxes(), upright_boxes(), quaternions())
@example(NARROW, NARROW, np.array([1.0, 0.0, 4.76837158e-07, 0.0]))
def test_iou_does_not_change_when_both_boxes_turn_together(first, second, q):
    rotation = rotation_matrix(q)

    def turned(box: OrientedBox) -> OrientedBox:
        x, y, z = (rotation @ box.p).tolist()
        return OrientedBox((x, y, z), quat_product(tuple(q.tolist()), box.q), box.s)

    # What tilts by a millionth counts as upright.
    assert iou(turned(first), turned(second)) == pytest.approx(iou(first, second), abs=1e-5)


def test_iou_of_a_cube_on_its_edge_in_a_slab_is_the_analytic_value():
    # The slab keeps the middle of height sqrt(2) / 2 of a square of side 1 on its corner.
    tilted = OrientedBox((0.0, 0.0, 0.0), quat_about_x(math.pi / 4), (1.0, 1.0, 1.0))
    slab = OrientedBox((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (4.0, 4.0, math.sqrt(0.5)))
    shared = 0.75
    assert iou(tilted, slab) == pytest.approx(shared / (1 + 16 * math.sqrt(0.5) - shared))
    apart = OrientedBox((0.0, 0.0, 3.0), (1.0, 0.0, 0.0, 0.0), (4.0, 4.0, 1.0))
    assert iou(tilted, apart) == 0.0


def quat_about_x(angle_rad: float):
    return (math.cos(angle_rad / 2), math.sin(angle_rad / 2), 0.0, 0.0)


@given(upright_boxes(), quaternions(), st.floats(-1.5, 1.5), st.floats(0.1, 2.0))
def test_the_points_of_a_layer_span_it(box, q, low, height):
    normal = rotation_matrix(q)[0]
    high = low + height
    kept = layer(box.corners(), normal, low, high)
    assert np.all((kept @ normal <= high + 1e-9) & (kept @ normal >= low - 1e-9))
    inside = np.random.default_rng(3).uniform(-0.5, 0.5, (200, 3)) * box.s
    inside = inside @ rotation_matrix(box.q).T + box.p
    heights = inside @ normal
    inside = inside[(heights > low) & (heights < high)]
    if len(inside):
        directions = np.random.default_rng(4).normal(size=(20, 3))
        outermost = (kept @ directions.T).max(axis=0)
        assert np.all((inside @ directions.T).max(axis=0) <= outermost + 1e-9)


@given(upright_boxes(), upright_boxes())
def test_boxes_penetrate_exactly_when_they_share_volume(first, second):
    depth = float(penetration_depth(*fields(first), *fields(second)))
    assume(abs(depth) > 1e-6)
    assert (depth > 0) == (iou(first, second) > 0)


@given(upright_boxes(), st.floats(0.01, 0.19))
def test_pushing_a_face_into_a_face_penetrates_by_the_push(box, push):
    reach = rotation_matrix(box.q)[:, 0] * (box.s[0] - push)
    depth = penetration_depth(*fields(box), *fields(moved(box, reach)))
    assert depth == pytest.approx(push, abs=1e-6)


@given(upright_boxes(), upright_boxes(), quaternions())
def test_penetration_of_many_equals_that_of_each_and_is_symmetric(first, second, q):
    batch = penetration_depth(
        np.array([first.p, first.p]),
        np.array([first.q, q]),
        np.array([first.s, first.s]),
        np.array([second.p, second.p]),
        np.array([second.q, second.q]),
        np.array([second.s, second.s]),
    )
    assert batch[0] == pytest.approx(penetration_depth(*fields(first), *fields(second)))
    assert batch[1] == pytest.approx(penetration_depth(first.p, q, first.s, *fields(second)))
    assert batch[1] == pytest.approx(penetration_depth(*fields(second), first.p, q, first.s))


@given(upright_boxes(), quaternions(), angles, places)
def test_signed_distance_is_the_distance_to_the_nearest_surface_point(box, q, angle, height):
    point = np.array([4 * math.cos(angle), 4 * math.sin(angle), height])
    distance = float(signed_distance(point, box.p, q, box.s))
    local = rotation_matrix(q).T @ (point - box.p)
    half = np.asarray(box.s) / 2
    nearest = np.clip(local, -half, half)
    if distance > 0:
        assert distance == pytest.approx(np.linalg.norm(local - nearest))
    else:
        assert -distance == pytest.approx((half - np.abs(local)).min())
