"""Position of the sun by place, date and time of day, from the library astral.

Times are local mean solar time: 12:00 is when the sun is highest, up to a quarter of an hour. A
scene has a place on the earth but no time zone, and light depends on the sun alone.
"""

from __future__ import annotations

import math
from datetime import UTC, date, datetime, time, timedelta

from flightsim.looks.weather.words import Season, Weather

_SEASON_DAYS: dict[Season, tuple[int, int]] = {
    "spring": (4, 15),
    "summer": (7, 1),
    "autumn": (10, 15),
    "winter": (1, 15),
}
"""Month and day in the middle of each season of the northern half of the earth."""
_YEAR = 2026
_TWILIGHT_DEG = -2.0
"""Elevation of the sun at dawn and dusk: the sky is bright, and no shadow has an edge."""
_NIGHT_DEG = -18.0
_MINUTES = 5
_CLOCKS = {"morning": time(9), "noon": time(12), "afternoon": time(15)}

Direction = tuple[float, float, float]
AFTERNOON_SUN: Direction = (0.602, 0.341, -0.722)
"""Direction of sunlight, ENU, of the afternoon without a date: 46 degrees high in the south-west.

It is a constant because pictures, renderings and figures of all scenes were made by it."""


def sunlight(
    weather: Weather, latitude_deg: float, longitude_deg: float
) -> tuple[Direction, float]:
    """Direction of sunlight, ENU and of unit length, and the sun's elevation in degrees.

    Dawn and dusk are when the sun stands 2 degrees below the horizon, or as near to that as it
    comes on the day: there are places and dates without a sunset. At night the sun counts as 18
    degrees below the horizon everywhere, since a user who asks for night wants it dark.
    """
    if weather.time == "afternoon" and weather.date is None and weather.season == "summer":
        return AFTERNOON_SUN, math.degrees(math.asin(-AFTERNOON_SUN[2]))
    day = weather.date or date(_YEAR, *_season_day(weather.season, latitude_deg))
    if weather.time in ("dawn", "dusk"):
        hours = range(12) if weather.time == "dawn" else range(12, 24)
        moments = [time(hour, minute) for hour in hours for minute in range(0, 60, _MINUTES)]
    else:
        moments = [_clock(weather.time)]
    places = [_sun(day, moment, latitude_deg, longitude_deg) for moment in moments]
    elevation_deg, azimuth_deg = min(places, key=lambda place: abs(place[0] - _TWILIGHT_DEG))
    if weather.time == "night":
        elevation_deg = min(elevation_deg, _NIGHT_DEG)
    up, turn = math.radians(elevation_deg), math.radians(azimuth_deg)
    east, north = math.sin(turn) * math.cos(up), math.cos(turn) * math.cos(up)
    return (-east, -north, -math.sin(up)), elevation_deg


def _season_day(season: Season, latitude_deg: float) -> tuple[int, int]:
    month, day = _SEASON_DAYS[season]
    return ((month + 5) % 12 + 1, day) if latitude_deg < 0 else (month, day)


def _clock(name: str) -> time:
    return time(0) if name == "night" else _CLOCKS.get(name) or time.fromisoformat(name)


def _sun(day: date, moment: time, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
    """Elevation and azimuth (clockwise from north) of the sun, degrees."""
    # astral takes 2 ms to import, which only pictures in another light should pay.
    from astral import Observer
    from astral.sun import azimuth, elevation

    observer = Observer(latitude=latitude_deg, longitude=longitude_deg)
    when = datetime.combine(day, moment, UTC) - timedelta(hours=longitude_deg / 15.0)
    return elevation(observer, when), azimuth(observer, when)
