import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.perception.depth_image import bearing, bound_hidden, steepest_sight
from tests.autonomy.depth_scene import box, look_down, quat_of

STEP_M = 0.05
BESIDE_M = 0.06

coordinates = st.floats(-1.5, 1.5)
sizes = st.floats(0.2, 1.2)
tilts = st.tuples(*[st.floats(-0.3, 0.3)] * 3)


@given(st.tuples(coordinates, coordinates, st.floats(2.0, 6.0)), tilts, st.integers(0, 2**32 - 1))
def test_points_project_back_to_their_pixels(eye, tilt, seed):
    image = look_down(eye, quat_of(tilt), shape=(12, 16))
    depth = np.random.default_rng(seed).uniform(0.1, 20.0, (12, 16)).astype(np.float32)
    image = dataclasses.replace(image, depth_m=depth)
    optical = (image.points_enu_m() - image.position_enu_m) @ image.rotation_enu_from_optical
    v, u = np.mgrid[:12, :16]
    np.testing.assert_allclose(optical[:, 2], depth.ravel(), rtol=1e-6)
    across, down, _ = (optical / optical[:, 2:]).T
    np.testing.assert_allclose(across * image.fx + image.cx, u.ravel(), atol=1e-6)
    np.testing.assert_allclose(down * image.fy + image.cy, v.ravel(), atol=1e-6)


@pytest.mark.parametrize("nothing", [math.inf, math.nan, 0.0, -1.0])
def test_pixels_without_a_measurement_give_no_point(nothing):
    image = look_down(shape=(12, 16))
    image.depth_m[3:5, :] = nothing
    points = image.points_enu_m()
    assert len(points) == 10 * 16
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-6)


@given(tilts, st.floats(2e-4, 0.02), st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_an_image_shows_how_noisy_it_is_whatever_it_looks_at(tilt, sigma, seed):
    rng = np.random.default_rng(seed)
    image = look_down((0.0, 0.0, 3.0), quat_of(tilt), boxes=[box((0.3, 0.2, 0.4), (0.6, 0.5, 0.8))])
    assert image.inverse_depth_sigma_pm < 2e-4
    disparity = 1.0 / image.depth_m + rng.normal(0.0, sigma, image.depth_m.shape)
    noisy = dataclasses.replace(image, depth_m=(1.0 / disparity).astype(np.float32))
    assert noisy.inverse_depth_sigma_pm == pytest.approx(sigma, rel=0.15)


def test_an_image_without_depth_shows_no_noise():
    image = look_down()
    image.depth_m[:] = math.inf
    assert image.inverse_depth_sigma_pm == 0.0


def test_half_of_an_image_shows_points_of_the_whole():
    image = look_down((0.3, 0.1, 3.0), quat_of((0.1, -0.05, 0.4)))
    whole = image.points_enu_m().reshape(240, 320, 3)
    np.testing.assert_allclose(
        image.halved().points_enu_m(), whole[::2, ::2].reshape(-1, 3), atol=1e-9
    )


def test_a_pixel_alone_is_dropped_only_where_it_is_too_small_to_be_a_thing():
    near, far = look_down((0.0, 0.0, 1.0)), look_down((0.0, 0.0, 5.0))
    for image in (near, far):
        image.depth_m[100, 90] = 7.0
        image.depth_m[50, 60:62] = 0.7
    assert np.isinf(near.without_lone_pixels().depth_m[100, 90])
    assert np.isfinite(near.without_lone_pixels().depth_m).sum() == near.depth_m.size - 1
    assert far.without_lone_pixels() is far


def test_lines_of_sight_end_where_their_depth_is_sure():
    ends = np.array([[3.0, 0.0, 0.0]])
    eye = np.array([0.0, 0.0, 3.0])
    sure, unsure = (
        np.isfinite(steepest_sight(ends, eye, 1e-3, STEP_M, 8, 100, sigma)).any(axis=0).sum()
        for sigma in (0.0, 0.02)
    )
    assert (sure, unsure) == (61, 46)


@given(st.lists(st.floats(1e-6, 6.283), min_size=2, max_size=30), st.floats(0.01, 100.0))
def test_bearing_sorts_directions_like_the_angle(angles, length):
    turns = [bearing(length * math.cos(a), length * math.sin(a)) for a in sorted(angles)]
    assert turns == sorted(turns)
    assert all(0.0 <= turn <= 4.0 for turn in turns)


@settings(max_examples=20)
@given(
    st.tuples(coordinates, coordinates),
    st.tuples(sizes, sizes, sizes),
    st.tuples(coordinates, coordinates),
    st.tuples(sizes, sizes, sizes),
    tilts,
)
def test_nothing_hidden_is_higher_than_its_bound(place, size, other_place, other_size, tilt):
    boxes = [
        box((*place, size[2] / 2), size),
        box((*other_place, other_size[2] / 2), other_size),
    ]
    image = look_down((0.2, -0.1, 4.0), quat_of(np.array(tilt) * 0.3), boxes=boxes)
    eye = np.array(image.position_enu_m)
    axis = np.arange(-40, 41) * STEP_M
    fall = steepest_sight(image.points_enu_m(), eye, 1.0 / image.fx, STEP_M, 512, 160, 0.0)
    bound = bound_hidden(fall, eye, STEP_M, axis, axis)
    east, north = np.meshgrid(axis, axis)
    top = np.zeros_like(east)
    for low, high in boxes:
        # A line that passes beside a box is taken for the whole of its cell and bearing.
        (west, south, _), (far_east, far_north, height) = low + BESIDE_M, high - BESIDE_M
        inside = (east > west) & (east < far_east) & (north > south) & (north < far_north)
        top[inside] = np.maximum(top[inside], height + BESIDE_M)
    # The bound holds for a cell's far side: from its middle to there a line falls half a step.
    away = np.hypot(east - eye[0], north - eye[1])
    with np.errstate(invalid="ignore"):
        slack = STEP_M * (eye[2] - bound) / np.maximum(away, STEP_M)
    known = np.isfinite(bound)
    assert np.count_nonzero(known) > 0.5 * known.size
    assert np.all(top[known] <= bound[known] + 1.5 * slack[known] + 0.02)


def test_ground_behind_a_roof_edge_is_known_to_be_below_the_roof():
    roof = box((-2.0, 0.0, 1.0), (6.0, 20.0, 2.0))  # ends at x = 1, the ground shows from x = 2
    image = look_down((0.0, 0.0, 4.0), boxes=[roof])
    axis = np.arange(-60, 61) * STEP_M
    eye = np.array(image.position_enu_m)
    fall = steepest_sight(image.points_enu_m(), eye, 1.0 / image.fx, STEP_M, 512, 240, 0.0)
    bound = bound_hidden(fall, eye, STEP_M, axis, axis)
    hidden = (axis > 1.05) & (axis < 1.95)
    assert np.all(bound[60, hidden] < 2.03)
    # It is no lower than the line from the eye over the edge, less the half cell.
    edge = 4.0 - (axis[hidden] + 0.05) * 2.0
    assert np.all(bound[60, hidden] > edge - 0.1)


def test_what_no_line_of_sight_passed_over_is_unbounded():
    image = look_down((0.0, 0.0, 2.0))
    axis = np.arange(-60, 61) * STEP_M
    eye = np.array(image.position_enu_m)
    fall = steepest_sight(image.points_enu_m(), eye, 1.0 / image.fx, STEP_M, 512, 240, 0.0)
    bound = bound_hidden(fall, eye, STEP_M, axis, axis)
    assert np.isinf(bound[60, 0])
    assert np.isinf(bound[0, 60])
    assert np.isfinite(bound[60, 60])
