from datetime import date

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.looks.weather import Weather, WeatherError, draw_weather, parse_weather


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", Weather()),
        (" Dusk , FOG 80 m", Weather(time="dusk", visibility_m=80.0)),
        ("haze", Weather(visibility_m=2000.0)),
        ("fog 1.5 km", Weather(visibility_m=1500.0)),
        ("7:05, rain", Weather(time="07:05", sky="overcast", falling="rain")),
        ("noon, 2026-12-21, clear", Weather(time="noon", date=date(2026, 12, 21), sky="clear")),
    ],
)
def test_terms_in_any_order_and_case(text, expected):
    assert parse_weather(text) == expected
    assert parse_weather(",".join(reversed(text.split(",")))) == expected


@given(st.integers(0, 2**32), st.sampled_from(["spring", "summer", "autumn", "winter"]))
def test_drawn_weather_says_itself_in_words(seed, season):
    drawn = draw_weather(np.random.default_rng(seed), season)
    assert parse_weather(str(drawn), season) == drawn
    assert drawn.falling != "snow" or season == "winter"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("dusk, dawn", "two terms for its time"),
        ("fog, haze", "two terms for its visibility_m"),
        ("24:00", "'24:00' is unknown; valid"),
        ("12:60", "'12:60' is unknown; valid"),
        ("2026-02-30", "'2026-02-30' is unknown; valid"),
        ("fog 3 m", "'fog 3 m' is out of range; valid: 10 m to 50 km"),
        ("clear, rain", "rain from a sky that is clear; valid: overcast"),
        ("drizzle\x1b[2J", r"'drizzle\x1b[2j' is unknown; valid"),
        ("dusk," * 60, "light has 300 characters; valid: at most 200"),
        ("random", "'random' is unknown"),
    ],
)
def test_what_says_nothing_or_two_things_is_refused(text, words):
    with pytest.raises(WeatherError) as caught:
        parse_weather(text)
    assert words in str(caught.value)
    assert "\x1b" not in str(caught.value)
