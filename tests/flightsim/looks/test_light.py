import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flightsim.looks.light import (
    SUN_DIRECTION,
    is_sunward,
    light_rgb,
    normals_for_light,
    surface_light,
)

TO_SUN = -np.array(SUN_DIRECTION)
UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])
SHARES = arrays(float, 20, elements=st.floats(0.0, 1.0))


def test_sun_direction_is_a_unit_vector_that_goes_down():
    assert abs(np.linalg.norm(TO_SUN) - 1) < 1e-3
    assert TO_SUN[2] > 0.5


@given(SHARES)
def test_renderers_compute_the_light_from_its_normals(light):
    normals = normals_for_light(light)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-3)
    np.testing.assert_allclose(normals @ TO_SUN, light, atol=2e-3)


def of(normal, sun, sky):
    return float(surface_light(np.array([normal]), np.array([sun]), np.array([sky]))[0])


def test_sun_is_brighter_than_lamps_and_lamps_than_open_shade():
    assert of(UP, 1.0, 1.0) > of(UP, 0.0, 0.0) + 0.2 > of(UP, 0.0, 1.0) + 0.3
    assert of(UP, 1.0, 1.0) > 0.85


def test_walls_of_a_room_differ_so_that_its_corners_show():
    walls = [of(np.array(n, dtype=float), 0.0, 0.0) for n in ((1, 0, 0), (0, 1, 0))]
    assert abs(walls[0] - walls[1]) > 0.08


@given(SHARES)
def test_more_light_is_brighter_in_every_channel(light):
    rgb = light_rgb(np.sort(light))
    assert (np.diff(rgb, axis=0) >= 0).all()
    assert rgb.min() > 0.2
    assert rgb.max() <= 1.0


def test_faces_away_from_the_sun_are_not_sunward():
    assert is_sunward(np.array([UP, TO_SUN])).all()
    assert not is_sunward(np.array([DOWN, -TO_SUN])).any()
