"""Lens and sensor of a camera, beside what geometry and statistics say."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flightsim.cameras import RgbdFrame
from flightsim.cameras.optics import (
    CameraMotion,
    Optics,
    OpticsCfg,
    OpticsError,
    image_velocity,
    parse_distortion,
    undistorted,
    warped,
)
from flightsim.testbench import TestbenchCfg, TestbenchError

WIDTH, HEIGHT, FOCAL_PX, DEPTH_M = 160, 120, 110.0, 4.0
STILL = CameraMotion(velocity_mps=np.zeros(3), angular_rate_radps=np.zeros(3))
ASIDE = CameraMotion(velocity_mps=np.array([2.0, 0.0, 0.0]), angular_rate_radps=np.zeros(3))


def frame(rgb, time_us=0, camera="forward"):
    return RgbdFrame(
        time_us=time_us,
        camera=camera,
        depth_m=np.full((HEIGHT, WIDTH), DEPTH_M, dtype=np.float32),
        fx=FOCAL_PX,
        fy=FOCAL_PX,
        cx=(WIDTH - 1) / 2,
        cy=(HEIGHT - 1) / 2,
        position_enu_m=(0.0, 0.0, 0.0),
        rotation_enu_from_optical=np.eye(3),
        rgb=rgb,
    )


def grey(level=128):
    return np.full((HEIGHT, WIDTH, 3), level, dtype=np.uint8)


def stripe(width_px=4):
    """A white upright stripe in the middle."""
    rgb = grey(0)
    rgb[:, WIDTH // 2 : WIDTH // 2 + width_px] = 255
    return rgb


def middles_px(rgb):
    """Mean column of the light in each row."""
    light = rgb[..., 0].astype(float)
    return light @ np.arange(WIDTH) / light.sum(axis=1)


def seen(cfg, rgb, motion=STILL, seed=1, **rest):
    return Optics(OpticsCfg(**cfg), seed, "field").frame(frame(rgb, **rest), motion)


def test_nothing_is_done_without_an_option_and_depth_is_never_touched():
    assert OpticsCfg().is_plain
    assert TestbenchCfg().optics.is_plain
    rgb = stripe()
    assert seen({}, rgb).rgb is rgb
    everything = {
        "exposure_ev": 1.0,
        "gamma": 1.2,
        "motion_blur_ms": 5.0,
        "rolling_shutter_ms": 20.0,
        "distortion": (-0.2, 0.0, 0.0, 0.0),
        "noise_levels": 3.0,
    }
    other = seen(everything, rgb, ASIDE)
    assert (other.rgb != rgb).any()
    assert (other.depth_m == DEPTH_M).all()
    assert (other.fx, other.cx) == (FOCAL_PX, (WIDTH - 1) / 2)


def test_an_exposure_of_one_doubles_the_light():
    light = (grey(100)[0, 0, 0] / 255) ** 2.2
    brighter = (seen({"exposure_ev": 1.0}, grey(100)).rgb[0, 0, 0] / 255) ** 2.2
    assert brighter == pytest.approx(2 * light, rel=0.02)
    assert seen({"exposure_ev": 3.0}, grey(200)).rgb.max() == 255
    assert seen({"gamma": 2.0}, grey(64)).rgb[0, 0, 0] == pytest.approx(255 * 0.251**0.5, abs=1)


def test_noise_has_its_deviation_and_depends_on_seed_camera_and_time():
    first = seen({"noise_levels": 6.0}, grey()).rgb
    assert first.astype(float).std() == pytest.approx(6.0, rel=0.05)
    assert first.astype(float).mean() == pytest.approx(128.0, abs=0.2)
    dark = seen({"noise_levels": 6.0}, grey(20)).rgb
    assert dark.astype(float).std() < 4.0
    np.testing.assert_array_equal(first, seen({"noise_levels": 6.0}, grey()).rgb)
    for other in ({"seed": 2}, {"time_us": 20_000}, {"camera": "down"}):
        assert (seen({"noise_levels": 6.0}, grey(), **other).rgb != first).any()


def test_a_rolling_shutter_shears_by_the_velocity_of_the_image():
    sheared = seen({"rolling_shutter_ms": 40.0}, stripe(), ASIDE).rgb
    middles = middles_px(sheared)
    # To the left as the camera moves to the right: 2 m/s at 4 m for 40 ms.
    expected_px = -FOCAL_PX * 2.0 / DEPTH_M * 0.040
    assert middles[-1] - middles[0] == pytest.approx(expected_px, abs=0.1)
    assert middles[HEIGHT // 2] == pytest.approx(middles_px(stripe())[0], abs=0.1)
    np.testing.assert_array_equal(seen({"rolling_shutter_ms": 40.0}, stripe()).rgb, stripe())


def test_motion_blur_is_as_long_as_the_motion_and_keeps_the_light():
    blurred = seen({"motion_blur_ms": 40.0}, stripe(1), ASIDE).rgb
    row = blurred[HEIGHT // 2, :, 0].astype(float)
    assert row.sum() == pytest.approx(255.0, rel=0.1)
    # 2.2 px of motion and a pixel of stripe.
    assert 2 <= np.count_nonzero(row > 10) <= 4
    assert middles_px(blurred)[HEIGHT // 2] == pytest.approx(WIDTH // 2, abs=0.1)


def test_velocities_of_the_image_are_those_of_moved_points():
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-0.6, 0.6, (2, 50))
    depth_m = rng.uniform(1.0, 20.0, 50)
    motion = CameraMotion(
        velocity_mps=np.array([0.7, -1.1, 1.9]), angular_rate_radps=np.array([0.5, -0.8, 0.3])
    )
    step_s = 1e-5
    points = np.stack([x * depth_m, y * depth_m, depth_m], axis=1) - step_s * motion.velocity_mps
    moved = points @ Rotation.from_rotvec(step_s * motion.angular_rate_radps).as_matrix()
    du, dv = image_velocity(x, y, 1.0 / depth_m, motion)
    np.testing.assert_allclose((moved[:, 0] / moved[:, 2] - x) / step_s, du, atol=2e-3)
    np.testing.assert_allclose((moved[:, 1] / moved[:, 2] - y) / step_s, dv, atol=2e-3)


@pytest.mark.parametrize("distortion", [(-0.2, 0.05, 0.0, 0.0), (0.15, 0.0, 0.01, -0.005)])
def test_a_lens_bends_as_opencv_says_and_leaves_no_empty_border(distortion):
    import cv2

    x, y = (part.ravel() for part in np.meshgrid(*(np.linspace(-0.5, 0.5, 9),) * 2))
    at_x, at_y = undistorted(x, y, distortion)
    points = np.stack([at_x, at_y, np.ones_like(at_x)], axis=1)
    back, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), np.array(distortion))
    np.testing.assert_allclose(back[:, 0], np.stack([x, y], axis=1), atol=1e-4)
    rgb = np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
    rgb[..., 0] = np.arange(WIDTH)
    bent = warped(frame(rgb), STILL, OpticsCfg(distortion=distortion))[..., 0].astype(int)
    # No column is repeated at the borders, as pixels beyond the drawn image would.
    assert (np.diff(bent[HEIGHT // 2]) >= 0).all()
    assert (np.diff(bent[HEIGHT // 2])[:3] > 0).any()


@pytest.mark.parametrize("text", ["wide", "0.1,", "2", "nan", "0,0,0,0,0", "0,0,0.5"])
def test_a_distortion_that_is_none_is_refused(text):
    with pytest.raises(OpticsError, match=r"camera-distortion .* is not valid; valid: none, or K1"):
        parse_distortion(text)


def test_numbers_out_of_range_are_refused():
    with pytest.raises(TestbenchError, match="camera-noise 100"):
        TestbenchCfg(camera_noise=100.0)
    assert parse_distortion("-0.2,0.05") == (-0.2, 0.05, 0.0, 0.0)
