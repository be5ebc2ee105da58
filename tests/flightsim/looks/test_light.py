import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flightsim.looks.light import AFTERNOON, light_of
from flightsim.looks.weather import Weather, parse_weather

TO_SUN = AFTERNOON.to_sun
TEXTS = ("", "dawn", "noon", "dusk", "night", "overcast, rain", "fog 50 m", "06:10, haze")
UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])
SHARES = arrays(float, 20, elements=st.floats(0.0, 1.0))


def test_sun_direction_is_a_unit_vector_that_goes_down():
    assert abs(np.linalg.norm(TO_SUN) - 1) < 1e-3
    assert TO_SUN[2] > 0.5


@given(SHARES)
def test_renderers_compute_the_light_from_its_normals(light):
    normals = AFTERNOON.normals(light)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-3)
    np.testing.assert_allclose(normals @ TO_SUN, light, atol=2e-3)


def of(normal, sun, sky):
    return float(AFTERNOON.surface(np.array([normal]), np.array([sun]), np.array([sky]))[0])


def test_sun_is_brighter_than_lamps_and_lamps_than_open_shade():
    assert of(UP, 1.0, 1.0) > of(UP, 0.0, 0.0) + 0.2 > of(UP, 0.0, 1.0) + 0.3
    assert of(UP, 1.0, 1.0) > 0.85


def test_walls_of_a_room_differ_so_that_its_corners_show():
    walls = [of(np.array(n, dtype=float), 0.0, 0.0) for n in ((1, 0, 0), (0, 1, 0))]
    assert abs(walls[0] - walls[1]) > 0.08


@given(SHARES)
def test_more_light_is_brighter_in_every_channel(light):
    rgb = AFTERNOON.rgb(np.sort(light))
    assert (np.diff(rgb, axis=0) >= 0).all()
    assert rgb.min() > 0.2
    assert rgb.max() <= 1.0


def test_faces_away_from_the_sun_are_not_sunward():
    assert AFTERNOON.is_sunward(np.array([UP, TO_SUN])).all()
    assert not AFTERNOON.is_sunward(np.array([DOWN, -TO_SUN])).any()


def light(text, latitude_deg=47.4):
    return light_of(parse_weather(text), latitude_deg, 8.5)


def on_ground(text):
    """Colour of level ground under the open sky, and in the sun where there is sun."""
    here = light(text)
    return here.rgb(here.surface(np.array([UP]), np.ones(1), np.ones(1)))[0]


def test_no_words_are_the_light_that_all_earlier_pictures_have():
    assert light_of(Weather(), 47.4, 8.5) is AFTERNOON
    assert AFTERNOON.sun_direction == (0.602, 0.341, -0.722)
    assert (AFTERNOON.ambient_rgb, AFTERNOON.sun_rgb) == ((0.30, 0.33, 0.38), (0.76, 0.71, 0.63))


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("latitude_deg", [-70.0, 0.0, 47.4, 85.0])
def test_every_light_encodes_its_numbers_in_unit_normals(text, latitude_deg):
    here, numbers = light(text, latitude_deg), np.linspace(0.0, 1.0, 9)
    assert here.sun_direction[2] < 0
    normals = here.normals(numbers)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=2e-3)
    np.testing.assert_allclose(normals @ here.to_sun, numbers, atol=2e-3)


def test_days_darken_from_noon_to_night():
    levels = [on_ground(text).mean() for text in ("noon", "17:00", "dusk", "night")]
    assert (np.diff(levels) < -0.03).all()
    assert levels[-1] < 0.2


def test_low_sun_is_redder_and_clouds_take_the_shadows():
    red, _, blue = on_ground("19:20, clear")
    assert red > 1.05 * blue
    red, _, blue = on_ground("15:00, clear")
    assert red == pytest.approx(blue, rel=0.02)
    for text in ("overcast", "fog 80 m", "night", "dusk"):
        assert not light(text).is_sunward(np.array([UP]))[0]
    # Haze leaves a sun that throws shadows.
    assert light("noon, haze 3 km").is_sunward(np.array([UP]))[0]


def test_lamps_shine_only_in_the_dark():
    assert [light(text).is_dark for text in ("noon", "overcast", "dusk", "night")] == [
        *(False, False, True, True)
    ]


def test_at_night_only_rooms_have_the_light_of_rooms():
    here, wall = light("night"), np.array([[1.0, 0.0, 0.0]])
    under_eaves, in_room = (
        here.surface(wall, np.zeros(1), np.array([sky]))[0] for sky in (0.3, 0.0)
    )
    assert under_eaves < 0.1 < 0.4 < in_room
