import numpy as np
import pytest

from flightsim.world import build_world
from scenarios.pictures.backdrop import open_stage, opened_above, surfaces_m
from tests.scenarios.landing_scenes import TOP_M, yard

WAY = np.array([(0.0, 0.0, 3.0), (5.0, 2.0, 5.0), (9.0, 0.0, 3.5), (9.0, 0.0, TOP_M + 0.2)])
INSIDE = np.array([(9.0, 0.0, 1.2)])
SIZE_PX = (320, 240)


@pytest.fixture(scope="module")
def world():
    return build_world(yard())


@pytest.fixture(scope="module")
def stage(world):
    with open_stage(world, *SIZE_PX) as stage:
        yield stage


@pytest.mark.parametrize("side", ["from_above", "from_aside"])
def test_all_of_the_way_is_in_the_picture(stage, side):
    pixels, _ = getattr(stage, side)(WAY, 1.05).pixels(WAY)
    assert np.all((pixels > 0) & (pixels < SIZE_PX))
    assert np.ptp(pixels, axis=0).max() > 0.3 * min(SIZE_PX), "the way is lost in the picture"


def test_from_above_north_is_up_and_the_scale_is_true(stage):
    backdrop = stage.from_above(WAY, 1.5)
    here, east, north = np.array([(4.0, 1.0, 3.0), (6.0, 1.0, 3.0), (4.0, 3.0, 3.0)])
    pixels, _ = backdrop.pixels(np.array([here, east, north]))
    two_m = 2 * backdrop.pixels_per_m((4.0, 1.0, 3.0))
    np.testing.assert_allclose(pixels[1] - pixels[0], (two_m, 0.0), atol=1e-6)
    np.testing.assert_allclose(pixels[2] - pixels[0], (0.0, -two_m), atol=1e-6)


def test_what_is_inside_a_container_is_hidden_and_what_flies_over_it_is_not(stage):
    for backdrop in (stage.from_above(WAY, 1.2), stage.from_aside(WAY, 1.2)):
        assert not backdrop.pixels(WAY)[1].any()
        assert backdrop.pixels(INSIDE)[1].all()


def test_container_is_opened_for_a_way_within_it(world):
    with open_stage(opened_above(world, INSIDE), *SIZE_PX) as stage:
        frame = stage.from_above(np.concatenate([INSIDE, INSIDE + 4.0]), 1.5).frame
    from_eye_m = np.linalg.norm(INSIDE[0] - frame.position_enu_m)
    assert frame.depth_m.max() > from_eye_m
    assert np.isfinite(frame.depth_m).all()


def test_points_behind_the_eye_are_nowhere(stage):
    backdrop = stage.from_above(WAY, 1.2)
    above_the_eye = np.array([backdrop.frame.position_enu_m]) + (0.0, 0.0, 5.0)
    pixels, is_hidden = backdrop.pixels(above_the_eye)
    assert np.isnan(pixels).all()
    assert not is_hidden.any()


def test_surfaces_are_the_lawn_and_the_top_of_the_container(world):
    below_m, above_m = surfaces_m(world, np.array([(-8.0, -8.0, 4.0), (9.0, 0.0, 4.0)]))
    np.testing.assert_allclose(below_m, [0.0, TOP_M], atol=0.02)
    assert np.isnan(above_m).all()
    _, above_m = surfaces_m(world, INSIDE * (1.0, 1.0, 0.0) - (0.0, 0.0, 0.5))
    assert np.isfinite(above_m).all()
