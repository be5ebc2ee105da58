"""Time of day, weather and season of pictures: the words of users, and where the sun stands."""

from flightsim.looks.weather.words import (
    RANDOM,
    Season,
    Weather,
    WeatherError,
    draw_weather,
    parse_weather,
)

__all__ = ["RANDOM", "Season", "Weather", "WeatherError", "draw_weather", "parse_weather"]
