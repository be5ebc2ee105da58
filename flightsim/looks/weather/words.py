"""The words in which users choose light and weather, such as "dusk, fog 80 m" or "11:30, rain".

A text is a list of terms, each of which answers one question: which time of day, which date, which
sky, how far one sees, and what falls. A term that is left out has its default, so that the empty
text is a fair afternoon in summer: the light in which every picture of this project was taken
before there was a choice. Two terms that answer the same question are refused, because the order
would otherwise decide in silence.
"""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Literal, get_args

import numpy as np

Season = Literal["spring", "summer", "autumn", "winter"]
Sky = Literal["clear", "fair", "overcast"]
Falling = Literal["dry", "rain", "snow"]

TIMES = ("dawn", "morning", "noon", "afternoon", "dusk", "night")
"""Names of times of day; HH:MM is another one."""
RANDOM = "random"
"""Text that lets the seed of a flight draw light and weather."""
HAZE_M, FOG_M = 2000.0, 150.0
"""Visibility in haze and in fog whose distance is not given."""
FOG_BELOW_M = 1000.0
"""Visibility below which haze is fog, as weather reports have it."""
LEAST_VISIBILITY_M, MOST_VISIBILITY_M = 10.0, 50_000.0
_WORDS: Mapping[str, tuple[str, object]] = MappingProxyType(
    {
        **{sky: ("sky", sky) for sky in get_args(Sky)},
        "haze": ("visibility_m", HAZE_M),
        "fog": ("visibility_m", FOG_M),
        "rain": ("falling", "rain"),
        "snow": ("falling", "snow"),
    }
)
"""Field of `Weather` and value that each word sets."""
_DISTANCE = re.compile(r"(haze|fog) +([0-9]+(?:\.[0-9]+)?) *(m|km)")
_CLOCK = re.compile(r"([0-9]{1,2}):([0-9]{2})")
_MOST_TEXT = 200
_VALID = (
    f"terms with commas between them: {', '.join(TIMES)} or HH:MM; YYYY-MM-DD; clear, fair or "
    "overcast; haze or fog, with a visibility such as 80 m or 1.5 km; rain or snow; or random alone"
)


class WeatherError(ValueError):
    """A text names no light and weather."""


@dataclass(frozen=True, slots=True)
class Weather:
    """Time of day, weather and season, as words say them."""

    time: str = "afternoon"
    """A name of `TIMES`, or local mean solar time as HH:MM."""
    date: dt.date | None = None
    """Date; None for the middle of the season."""
    sky: Sky = "fair"
    visibility_m: float | None = None
    """Distance at which contrast falls to 2%; None for air without haze."""
    falling: Falling = "dry"
    season: Season = "summer"

    def __str__(self) -> str:
        """The text without the season: `parse_weather` reads it back."""
        terms = [self.time]
        if self.date is not None:
            terms.append(self.date.isoformat())
        if self.sky != ("fair" if self.falling == "dry" else "overcast"):
            terms.append(self.sky)
        if self.visibility_m is not None:
            kind = "fog" if self.visibility_m < FOG_BELOW_M else "haze"
            terms.append(f"{kind} {self.visibility_m:g} m")
        if self.falling != "dry":
            terms.append(self.falling)
        return ", ".join(terms)


def parse_weather(text: str, season: Season = "summer") -> Weather:
    """Light and weather of a text; see the module.

    Args:
        text: Terms in any order and case, such as "dusk, fog 80 m"; empty for a fair afternoon.
        season: Season, which also dates the text if it has no date of its own.

    Raises:
        WeatherError: If a term is unknown, or two terms answer the same question.
    """
    if season not in get_args(Season):
        raise WeatherError(f"season {season!r} is unknown; valid: {', '.join(get_args(Season))}")
    if len(text) > _MOST_TEXT:
        raise WeatherError(f"light has {len(text)} characters; valid: at most {_MOST_TEXT}")
    found: dict[str, Any] = {}
    for term in filter(None, (part.strip().lower() for part in text.split(","))):
        field, value = _read(term)
        if field in found:
            raise WeatherError(f"light {text!r} has two terms for its {field}; valid: one")
        found[field] = value
    if found.get("falling", "dry") != "dry":
        if found.get("sky", "overcast") != "overcast":
            raise WeatherError(
                f"light {text!r} has {found['falling']} from a sky that is {found['sky']}; "
                "valid: overcast, or no word for the sky"
            )
        found["sky"] = "overcast"
    return replace(Weather(season=season), **found)


def draw_weather(rng: np.random.Generator, season: Season = "summer") -> Weather:
    """Light and weather at random, as a year brings them: mostly days, seldom fog or snow.

    Snow falls in winter alone.
    """
    if rng.random() < 0.15:
        time = str(rng.choice(["dawn", "dusk", "night"]))
    else:
        minutes = int(rng.integers(8 * 60, 17 * 60))
        time = f"{minutes // 60:02d}:{minutes % 60:02d}"
    sky = str(rng.choice(get_args(Sky), p=(0.3, 0.4, 0.3)))
    kinds: tuple[Falling, ...] = ("dry", "snow" if season == "winter" else "rain")
    falling = kinds[int(rng.random() < 0.4)] if sky == "overcast" else "dry"
    visibility_m = None
    if rng.random() < 0.3:
        visibility_m = float(round(10 ** rng.uniform(1.9, 3.5), -1))
    return Weather(time, None, sky, visibility_m, falling, season)  # pyrefly: ignore[bad-argument-type]


def _read(term: str) -> tuple[str, object]:
    """Field of `Weather` that a term sets, and its value."""
    if term in TIMES:
        return "time", term
    if clock := _CLOCK.fullmatch(term):
        if int(clock[1]) < 24 and int(clock[2]) < 60:
            return "time", f"{int(clock[1]):02d}:{clock[2]}"
    elif distance := _DISTANCE.fullmatch(term):
        value = float(distance[2]) * (1000.0 if distance[3] == "km" else 1.0)
        if LEAST_VISIBILITY_M <= value <= MOST_VISIBILITY_M:
            return "visibility_m", value
        raise WeatherError(
            f"light: {term!r} is out of range; "
            f"valid: {LEAST_VISIBILITY_M:g} m to {MOST_VISIBILITY_M / 1000:g} km"
        )
    elif term in _WORDS:
        return _WORDS[term]
    else:
        try:
            return "date", dt.date.fromisoformat(term)
        except ValueError:
            pass
    raise WeatherError(f"light: {term!r} is unknown; valid: {_VALID}")
