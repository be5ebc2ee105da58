import math

import numpy as np
import pytest

from flightsim.looks.weather import parse_weather
from flightsim.looks.weather.sun import sunlight


def test_noon_at_the_equinox_is_as_high_as_the_latitude_says():
    for latitude_deg in (0.0, 30.0, 47.4, -35.0):
        direction, elevation_deg = sunlight(parse_weather("12:00, 2026-03-20"), latitude_deg, 8.5)
        assert elevation_deg == pytest.approx(90 - abs(latitude_deg), abs=2.0)
        # Sunlight comes from the south in the north and from the north in the south.
        if latitude_deg:
            assert math.copysign(1, direction[1]) == math.copysign(1, latitude_deg)


@pytest.mark.parametrize(("text", "from_the_east"), [("dawn", True), ("dusk", False)])
def test_dawn_is_in_the_east_and_dusk_in_the_west(text, from_the_east):
    direction, elevation_deg = sunlight(parse_weather(text), 47.4, 8.5)
    assert elevation_deg == pytest.approx(-2.0, abs=0.6)
    assert (direction[0] < 0) == from_the_east
    assert np.linalg.norm(direction) == pytest.approx(1.0)


def test_polar_days_have_the_nearest_to_dusk_and_nights_are_dark():
    _, dusk_deg = sunlight(parse_weather("dusk, 2026-06-21"), 80.0, 0.0)
    assert 5.0 < dusk_deg < 20.0
    _, night_deg = sunlight(parse_weather("night, 2026-06-21"), 80.0, 0.0)
    assert night_deg == -18.0


def test_seasons_of_the_south_are_half_a_year_later():
    north, south = (
        sunlight(parse_weather("noon", "winter"), latitude_deg, 8.5)[1]
        for latitude_deg in (40.0, -40.0)
    )
    assert north == pytest.approx(south, abs=1.5)


def test_longitude_shifts_no_solar_time():
    here, there = (
        sunlight(parse_weather("09:00, 2026-06-01"), 40.0, longitude_deg)[1]
        for longitude_deg in (-120.0, 140.0)
    )
    assert here == pytest.approx(there, abs=0.5)
