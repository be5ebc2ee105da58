from flightsim.looks.light import AFTERNOON, light_of
from flightsim.looks.paint import Paint
from flightsim.looks.textures import PATTERNS, lit_tile, tile
from flightsim.looks.weather import parse_weather
from flightsim.looks.weathering import _FACADES, _FIELDS, _GROUND, _SNOW_COVER, weathered

LEAVES = Paint("leaves", (0.30, 0.45, 0.22))


def light(text, season="summer"):
    return light_of(parse_weather(text, season), 47.4, 8.5)


def test_a_fair_afternoon_in_summer_changes_no_paint():
    for texture in (*PATTERNS, None):
        paint = Paint(texture, (0.3, 0.5, 0.7))
        assert weathered(paint, AFTERNOON) == paint


def test_leaves_turn_in_autumn():
    red, green, _ = weathered(LEAVES, light("", "autumn")).rgb
    assert red / green > 1.2 * LEAVES.rgb[0] / LEAVES.rgb[1]


def test_rain_darkens_the_ground_and_snow_whitens_it():
    ground = Paint("paving", (0.6, 0.6, 0.6))
    assert max(weathered(ground, light("rain")).rgb) < 0.45
    assert min(weathered(ground, light("snow", "winter")).rgb) > 0.75
    wall = Paint("brick", (0.6, 0.3, 0.2))
    assert weathered(wall, light("rain")) == wall


def test_windows_shine_at_night_alone():
    facade = Paint("punched", (0.8, 0.8, 0.7))
    assert weathered(facade, light("night")).is_lit_within
    assert not weathered(facade, light("noon")).is_lit_within
    day = tile("punched", facade.rgb).astype(int)
    night = lit_tile("punched", facade.rgb, light("night").wall_rgb).astype(int)
    is_brighter = (night.sum(axis=2) > day.sum(axis=2) + 60).mean()
    is_darker = (night.sum(axis=2) < 0.4 * day.sum(axis=2)).mean()
    assert 0.02 < is_brighter < 0.3
    assert is_darker > 0.6


def test_tables_name_textures_that_there_are():
    assert (_GROUND | _FIELDS | _FACADES | set(_SNOW_COVER)) <= set(PATTERNS)
