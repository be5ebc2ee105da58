"""A stereo camera's depth: how wrong, where missing, and the same for the same seed."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightsim.cameras import DepthNoise, RgbdFrame, depth_noise
from flightsim.cameras.depth_noise import D435, D455, DepthNoiseError, measured_depth

FOCAL_PX = 208.0
SHAPE = (240, 320)
CLEAN = dataclasses.replace(D435, dropout_share=0.0, mismatch_share=0.0)


def wall(depth_m, shape=SHAPE):
    return np.full(shape, depth_m, dtype=np.float32)


def measured(true, cfg=CLEAN, seed=0):
    return measured_depth(true, FOCAL_PX, cfg, np.random.default_rng(seed))


@given(st.floats(0.7, 5.0), st.sampled_from([D435, D455]), st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_noise_grows_with_the_square_of_range(depth_m, camera, seed):
    cfg = dataclasses.replace(camera, dropout_share=0.0, mismatch_share=0.0)
    inverse = 1.0 / measured(wall(depth_m), cfg, seed)
    # Quantisation adds a twelfth of its step squared.
    sigma_px = math.hypot(cfg.disparity_sigma_px, cfg.disparity_step_px / math.sqrt(12))
    expected = sigma_px / (cfg.focal_px * cfg.baseline_m)
    assert np.std(inverse) == pytest.approx(expected, rel=0.08)
    assert np.mean(inverse) == pytest.approx(1.0 / depth_m, abs=0.1 * expected)
    assert cfg.sigma_m(2 * depth_m) == pytest.approx(4 * cfg.sigma_m(depth_m))


def test_a_d435_errs_by_six_centimetres_at_four_metres():
    assert D435.sigma_m(4.0) == pytest.approx(0.060, abs=0.001)
    assert D455.sigma_m(4.0) == pytest.approx(0.032, abs=0.001)


def test_disparity_comes_in_steps():
    disparity = D435.baseline_m * D435.focal_px / measured(wall(2.3)).astype(float)
    steps = disparity / D435.disparity_step_px
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-4)


def test_neighbours_err_alike_and_pixels_apart_do_not():
    error = 1.0 / measured(wall(3.0)).astype(float)
    error -= error.mean()
    near, far = (np.mean(error[:, :-n] * error[:, n:]) / error.var() for n in (1, 4))
    assert near > 0.5
    assert abs(far) < 0.05


def test_beyond_its_range_it_measures_nothing():
    assert np.isinf(measured(wall(math.inf))).all()
    assert np.isinf(measured(wall(0.2))).all()
    assert np.isinf(measured(wall(14.0))).all()


def test_what_only_one_imager_sees_has_no_depth():
    true = wall(4.0)
    true[:, 160:200] = 1.0
    cfg = dataclasses.replace(CLEAN, lateral_sigma_px=0.0, disparity_sigma_px=1e-6)
    missing = np.isinf(measured(true, cfg))
    # Shadow: f b (1 / near - 1 / far) pixels to the left of what is near, none to its right.
    width = FOCAL_PX * cfg.baseline_m * (1.0 - 0.25)
    assert missing[100].sum() == pytest.approx(width, abs=1.5)
    assert missing[100, 153:160].all()


def test_grazing_surfaces_have_no_depth():
    rows = np.arange(SHAPE[0])[:, None]
    steep = 0.5 * 1.04**rows * np.ones(SHAPE)  # tan of incidence is 208 times the growth a pixel
    flat = (3.0 + rows * 0.003) * np.ones(SHAPE)
    assert np.isinf(measured(steep.astype(np.float32))[4:50]).all()
    assert np.isinf(measured(flat.astype(np.float32))).mean() < 0.01


def test_dropouts_and_wrong_matches_are_as_many_as_told():
    cfg = dataclasses.replace(D435, dropout_share=0.02, mismatch_share=0.01)
    depth = measured(wall(2.0), cfg)
    assert np.isinf(depth).mean() == pytest.approx(0.02, abs=0.002)
    assert (np.abs(depth[np.isfinite(depth)] - 2.0) > 0.2).mean() == pytest.approx(0.01, abs=0.002)


def frame(camera="down", time_us=0):
    return RgbdFrame(
        time_us=time_us,
        camera=camera,
        rgb=np.zeros((24, 32, 3), dtype=np.uint8),
        depth_m=wall(3.0, (24, 32)),
        fx=20.0,
        fy=20.0,
        cx=15.5,
        cy=11.5,
        position_enu_m=(0.0, 0.0, 3.0),
        rotation_enu_from_optical=np.eye(3),
    )


def test_a_frame_errs_by_seed_scene_camera_and_time_alone():
    one, other = DepthNoise(D435, 3, "42"), DepthNoise(D435, 3, "42")
    other.frame(frame("forward"))
    first = one.frame(frame()).depth_m
    np.testing.assert_array_equal(first, other.frame(frame()).depth_m)
    for different in (
        one.frame(frame("forward")),
        one.frame(frame(time_us=20_000)),
        DepthNoise(D435, 4, "42").frame(frame()),
        DepthNoise(D435, 3, "43").frame(frame()),
    ):
        assert not np.array_equal(first, different.depth_m)


def test_an_exact_camera_has_no_errors_and_an_unknown_one_is_refused():
    assert depth_noise("exact", 0, "42") is None
    assert depth_noise("d455", 0, "42") is not None
    with pytest.raises(DepthNoiseError, match="'kinect' is unknown; valid: exact, d435, d455"):
        depth_noise("kinect", 0, "42")


@pytest.mark.parametrize(("field", "value"), [("baseline_m", 0.0), ("window_px", 2)])
def test_impossible_cameras_are_refused_by_name(field, value):
    with pytest.raises(DepthNoiseError, match=f"{field} {value} is not valid"):
        dataclasses.replace(D435, **{field: value})
