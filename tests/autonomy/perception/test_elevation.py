import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.perception import ElevationMap
from autonomy.perception.elevation import MEMORY_FRAMES
from tests.autonomy.depth_scene import LEVEL, box, look_down, quat_of

POLE = box((0.62, 0.31, 0.5), (0.03, 0.03, 1.0))
TABLE = box((0.0, 0.0, 0.375), (1.2, 0.8, 0.75))


def mapped(*images, center=(0.0, 0.0, 0.0), **options):
    elevation = ElevationMap(center, **options)
    for image in images:
        elevation.add(image)
    return elevation


def truth(elevation, gradient=(0.0, 0.0), ground=0.0):
    east, north = np.meshgrid(*elevation.cell_centres())
    return ground + gradient[0] * east + gradient[1] * north


@given(
    st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(2.5, 5.0)),
    st.tuples(*[st.floats(-0.2, 0.2)] * 3),
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)),
)
@settings(max_examples=20)
def test_cells_hold_the_height_of_the_plane_whatever_the_pose(eye, tilt, gradient):
    elevation = mapped(look_down(eye, quat_of(tilt), ground=-0.7, gradient=gradient))
    error = (elevation.height_m - truth(elevation, gradient, -0.7))[elevation.is_observed]
    # A cell that is seen in part holds the mean of that part.
    assert np.abs(error).max() <= 0.025 * sum(map(abs, gradient)) + 1e-4
    assert np.count_nonzero(elevation.is_observed) > 500
    rim = (elevation.top_m - elevation.bottom_m)[elevation.is_observed]
    assert rim.max() <= 0.05 * sum(map(abs, gradient)) + 1e-4


def test_only_cells_in_view_are_observed():
    elevation = mapped(look_down((0.0, 0.0, 2.0)))
    east, north = np.meshgrid(*elevation.cell_centres())
    half = 2.0 * math.tan(math.radians(30.0))
    inside = (np.abs(north) < half - 0.05) & (np.abs(east) < half - 0.05)
    outside = (np.abs(north) > half * 4 / 3 + 0.05) | (np.abs(east) > half * 4 / 3 + 0.05)
    assert elevation.is_observed[inside].all()
    assert not elevation.is_observed[outside].any()
    assert np.isinf(elevation.ceiling_m[outside]).all()


def test_pixels_without_depth_leave_their_cells_unobserved():
    image = look_down()
    image.depth_m[100:140, 140:180] = math.nan
    elevation = mapped(image)
    assert not elevation.is_observed[elevation.cell(0.0, 0.0)]
    assert elevation.is_observed[elevation.cell(0.8, 0.8)]


@given(st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=8))
@settings(max_examples=20)
def test_map_is_flat_and_at_the_mean_when_the_estimate_of_height_wanders(offsets):
    frames = [
        look_down((0.0, 0.0, 4.0), believed=((0.0, 0.0, 4.0 + offset), LEVEL)) for offset in offsets
    ]
    elevation = mapped(*frames)
    seen = elevation.is_observed
    np.testing.assert_allclose(elevation.height_m[seen], np.mean(offsets), atol=1e-3)
    assert (elevation.top_m - elevation.bottom_m)[seen].max() < 1e-3


def test_map_follows_a_lasting_change_of_the_estimated_height():
    frames = [look_down(believed=((0.0, 0.0, 4.0 + z), LEVEL)) for z in [0.0] * 10 + [0.3] * 40]
    elevation = mapped(*frames)
    assert elevation.height_m[elevation.cell(0.0, 0.0)] == pytest.approx(0.3, abs=0.01)


def test_a_box_is_where_it_is_and_as_high_as_it_is():
    elevation = mapped(look_down((0.3, -0.2, 4.0), boxes=[TABLE]))
    assert elevation.height_m[elevation.cell(0.0, 0.0)] == pytest.approx(0.75, abs=1e-4)
    assert elevation.height_m[elevation.cell(0.5, 0.3)] == pytest.approx(0.75, abs=1e-4)
    assert elevation.height_m[elevation.cell(0.0, -1.0)] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("when", [0, 2, 4])
def test_thin_pole_seen_in_one_frame_is_not_averaged_away(when):
    frames = [look_down()] * 5
    frames[when] = look_down(boxes=[POLE])
    elevation = mapped(*frames)
    rows, columns = np.nonzero(elevation.top_m > 0.5)
    east, north = elevation.cell_centres()
    assert len(rows) > 0
    assert math.hypot(east[columns[0]] - 0.62, north[rows[0]] - 0.31) < 0.3


def test_what_went_away_is_forgotten_in_the_end():
    elevation = mapped(look_down(boxes=[POLE]), *[look_down()] * (6 * MEMORY_FRAMES))
    assert elevation.top_m[elevation.is_observed].max() < 0.05


def test_noise_averages_out():
    rng = np.random.default_rng(3)
    frames = [look_down() for _ in range(MEMORY_FRAMES)]
    for image in frames:
        image.depth_m[:] += rng.normal(0.0, 0.01, image.depth_m.shape)
    one, many = mapped(frames[0]), mapped(*frames)
    seen = one.is_observed
    assert np.std(many.height_m[seen]) < 0.5 * np.std(one.height_m[seen])
    # A cell seen for the first time in a late frame counts in full: no trace of what it was.
    assert np.abs(many.height_m[many.is_observed]).max() < 0.03


def noisy(image, rng, inverse_sigma):
    disparity = 1.0 / image.depth_m + rng.normal(0.0, inverse_sigma, image.depth_m.shape)
    return dataclasses.replace(image, depth_m=(1.0 / disparity).astype(np.float32))


def test_variance_is_that_of_the_errors():
    rng = np.random.default_rng(8)
    frames = [noisy(look_down((0.0, 0.0, z)), rng, 0.003) for z in (4.0, 4.0, 3.5, 3.0, 2.5)]
    elevation = mapped(*frames)
    seen = elevation.n_frames == len(frames)
    squares = elevation.height_m[seen] ** 2 / elevation.variance_m2[seen]
    # Pixels of this camera err independently; the map takes four for one, so it claims less.
    assert 0.2 < np.mean(squares) < 1.0


def test_frames_that_disagree_leave_a_cell_uncertain():
    rng = np.random.default_rng(9)
    frames = [
        look_down(boxes=[box((0.0, 0.0, z / 2), (0.5, 0.5, z))]) for z in (0.1, 0.5, 0.2, 0.4)
    ]
    elevation = mapped(*[noisy(frame, rng, 0.0005) for frame in frames])
    here, beside = (elevation.variance_m2[elevation.cell(x, 0.0)] for x in (0.0, 1.0))
    assert np.sqrt(here) > 0.05 > 0.01 > np.sqrt(beside)


def test_a_frame_from_nearby_outweighs_many_from_above():
    rng = np.random.default_rng(10)
    above = [noisy(look_down((0.0, 0.0, 5.0)), rng, 0.005) for _ in range(6)]
    high, both = mapped(*above), mapped(*above, noisy(look_down((0.0, 0.0, 1.2)), rng, 0.005))
    row, column = both.cell(0.0, 0.0)
    near = slice(row - 5, row + 6), slice(column - 5, column + 6)
    assert np.std(both.height_m[near]) < 0.2 * np.std(high.height_m[near])
    assert np.max(both.variance_m2[near]) < 0.1 * np.min(high.variance_m2[near])


def test_one_pixel_that_was_matched_wrong_moves_nothing():
    image = look_down()
    image.depth_m[120, 160] = 2.0
    elevation = mapped(*[look_down()] * 2, image)
    assert np.abs(elevation.height_m[elevation.is_observed]).max() < 0.01
    assert elevation.top_m[elevation.is_observed].max() < 0.01
    image.depth_m[118:123, 160] = 2.0
    elevation = mapped(*[look_down()] * 2, image)
    assert elevation.top_m[elevation.is_observed].max() > 1.9


def matched_wrong(image, rng, share):
    """The image with some pixels at any other depth, as a stereo camera has them."""
    depth_m = image.depth_m.copy()
    wrong = rng.random(depth_m.shape) < share
    depth_m[wrong] = rng.uniform(0.3, 10.0, np.count_nonzero(wrong))
    return dataclasses.replace(image, depth_m=depth_m)


def test_pixels_matched_wrong_near_the_ground_raise_and_sink_nothing_beside_the_view():
    rng = np.random.default_rng(11)
    # Along its line of sight a wrong point lies where the camera sees nothing else any more.
    above = [noisy(look_down((0.0, 0.0, 4.0)), rng, 0.0003) for _ in range(3)]
    below = [
        matched_wrong(noisy(look_down((0.0, 0.0, 0.8)), rng, 0.003), rng, 0.0005)
        for _ in range(MEMORY_FRAMES)
    ]
    elevation = mapped(*above, *below, half_extent_m=1.5)
    assert elevation.is_observed.all()
    assert np.abs(elevation.height_m).max() < 0.05
    assert elevation.top_m.max() < 0.05
    assert elevation.bottom_m.min() > -0.05


def test_a_second_frame_from_elsewhere_adds_its_own_cells():
    west, east = look_down((-1.5, 0.0, 3.0)), look_down((1.5, 0.0, 3.0))
    both = mapped(west, east, half_extent_m=4.0)
    assert both.n_frames[both.cell(-1.5, 0.0)] == 1
    assert both.n_frames[both.cell(1.5, 0.0)] == 1
    assert both.n_frames[both.cell(0.0, 0.0)] == 2


def test_hidden_ground_lies_below_the_edge_that_hides_it():
    image = look_down((0.0, 0.0, 3.0), boxes=[box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0))])
    assert np.isinf(mapped(image).hidden_m).all()  # one frame may err
    elevation = mapped(image, image)
    hidden = ~elevation.is_observed & np.isfinite(elevation.hidden_m)
    assert np.count_nonzero(hidden) > 100
    assert elevation.ceiling_m[hidden].max() < 2.05


def test_bound_of_hidden_cells_moves_with_the_map():
    boxes = [box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0))]
    frames = [
        look_down((0.0, 0.0, 3.0), boxes=boxes, believed=((0.0, 0.0, 3.0 + z), LEVEL))
        for z in (0.0, 0.0, 0.4)
    ]
    first, both = mapped(*frames[:2]), mapped(*frames)
    hidden = ~first.is_observed & np.isfinite(first.hidden_m)
    moved = both.ceiling_m[hidden] - first.ceiling_m[hidden]
    np.testing.assert_allclose(moved, 0.4 / 3, atol=1e-3)


def test_cell_and_cell_centres_agree():
    elevation = ElevationMap((12.3, -45.6, 7.0), half_extent_m=1.0)
    east, north = elevation.cell_centres()
    assert (east[20], north[20]) == pytest.approx((12.3, -45.6))
    for row, column in ((0, 0), (3, 38), (40, 40)):
        assert elevation.cell(east[column], north[row]) == (row, column)


def test_cells_within_a_polygon_are_those_whose_centres_are():
    elevation = ElevationMap((10.0, 20.0, 0.0), half_extent_m=1.0)
    polygon = [(9.49, 19.49, 0.0), (10.51, 19.49, 0.0), (10.51, 19.99, 0.0), (9.49, 19.99, 0.0)]
    inside = elevation.cells_within(polygon)
    assert np.count_nonzero(inside) == 21 * 10
    assert inside[elevation.cell(10.0, 19.7)]
    assert not inside[elevation.cell(10.0, 20.3)]
