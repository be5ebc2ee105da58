"""Light as one number per point: 0 in the deepest shade, 1 in full sun.

Both renderers convert it to colour by `Light.rgb`. OpenGL takes no such number with a mesh point,
but it takes a normal, and computes the cosine of its angle to the sun. `Light.normals` therefore
returns normals, not those of the surface, whose cosine is the number. Shade, shadows and lamps thus
cost nothing when a picture is drawn.

A `Light` is derived from the weather and the place. It says how much the sun and the sky add to the
number, and which two colours the number lies between. In the dark the upper colour is that of
lamps, so that lit rooms and street lamps need no other mechanism than sunlight does. There is no
moon: at night only the open sky and lamps give light.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flightsim.looks.weather.sun import AFTERNOON_SUN, Direction, sunlight
from flightsim.looks.weather.words import FOG_BELOW_M, Falling, Season, Weather

Colour = tuple[float, float, float]
Normals = Float[np.ndarray, "*n 3"]
Shares = Float[np.ndarray, "*n"]

_LEAST_COSINE = 0.05
"""Cosine to the sun below which a face is in its own shade: its light would only show grain."""


@dataclass(frozen=True, slots=True)
class SkyColours:
    """Colours of the sky, which the renderers paint where a ray meets nothing."""

    to_sun: Direction
    """Direction to the sun, ENU, of unit length; below the horizon at night."""
    horizon_rgb: Colour = (0.80, 0.87, 0.93)
    zenith_rgb: Colour = (0.26, 0.47, 0.80)
    land: Colour = (1.0, 1.0, 1.0)
    """Factors of the colours of hills, woods and far land, and of clouds."""
    sun: float = 1.0
    """Share of the sun's disc and glow that is seen: 0 behind clouds and at night."""
    cover: float = 0.42
    """Level of noise above which there are clouds: lower is cloudier, above 3 there are none."""
    stars: float = 0.0
    """Brightness of stars, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Light:
    """Light of a world."""

    sun_direction: Direction = AFTERNOON_SUN
    """Direction of sunlight, ENU, of unit length and always downwards.

    While no sunlight reaches the ground (sun below the horizon, closed clouds, or fog with less
    than 1 km of visibility) it is the direction of the afternoon. It then only encodes the number.
    `sky.to_sun` always points to the sun itself."""
    ambient_rgb: Colour = (0.30, 0.33, 0.38)
    """Colour of light 0."""
    sun_rgb: Colour = (0.76, 0.71, 0.63)
    """Colour added at light 1: sunlight by day, lamplight at night."""
    sun_share: float = 0.90
    """Light that the sun adds to a face which looks at it; 0 without shadows."""
    sky_share: float = 0.30
    """Light that the open sky adds to a level face."""
    sky: SkyColours = SkyColours(tuple(-x for x in AFTERNOON_SUN))  # pyrefly: ignore[bad-argument-type]
    visibility_m: float | None = None
    """Distance at which contrast falls to 2%; None without haze."""
    falling: Falling = "dry"
    season: Season = "summer"
    is_dark: bool = False
    """True if lamps and windows shine."""

    def surface(self, normals_enu: Normals, sun: Shares, sky: Shares) -> Shares:
        """Return the light on surfaces, 0 to 1.

        Args:
            normals_enu: Outward unit normals.
            sun: Visible share of the sun, 0 to 1.
            sky: Share of the sky not hidden by roofs; under roofs there are lamps.
        """
        up = normals_enu[..., 2]
        from_sky = self.sky_share * (0.5 + 0.5 * up)
        # Walls differ in brightness, so that corners of a room are visible.
        from_lamps = 0.47 + 0.10 * up + 0.09 * (normals_enu @ np.array([0.8, -0.6, 0.0]))
        # Undersides indoors are ceilings, which are bright.
        from_lamps = from_lamps + 0.20 * np.clip(-up, 0.0, 1.0)
        from_sun = self.sun_share * np.maximum(0.0, normals_enu @ self.to_sun)
        # At night eaves must not pass for a lit room: only what sees no sky at all is in one.
        in_room = (sky <= 0.0) if self.is_dark else 1.0 - sky
        return np.clip(sky * from_sky + in_room * from_lamps + sun * from_sun, 0.0, 1.0)

    def rgb(self, light: Shares) -> Float[np.ndarray, "*n 3"]:
        """Return colour factors of surfaces, at most 1."""
        ambient, sun = np.array(self.ambient_rgb, light.dtype), np.array(self.sun_rgb, light.dtype)
        return np.minimum(1.0, ambient + light[..., None] * sun)

    def normals(self, light: Shares) -> Normals:
        """Return unit normals whose cosine to the sun is the light."""
        aside = np.sqrt(np.maximum(0.0, 1.0 - light**2))
        across = np.cross(self.to_sun, (0.0, 1.0, 0.0) if self._is_overhead else (0.0, 0.0, 1.0))
        across /= np.linalg.norm(across)
        return light[..., None] * self.to_sun + aside[..., None] * across

    def is_sunward(self, normals_enu: Normals) -> np.ndarray:
        """Return true for faces that the sun can reach at all, (...,) bool.

        Faces that the light only grazes count as turned away.
        """
        return (self.sun_share > 0.0) & (normals_enu @ self.to_sun > _LEAST_COSINE)

    @property
    def wall_rgb(self) -> Colour:
        """Light on a wall outdoors that looks away from the sun."""
        return _colour(self.rgb(np.array([0.5 * self.sky_share]))[0])

    @property
    def to_sun(self) -> Float[np.ndarray, " 3"]:
        """Unit vector against the sunlight, ENU."""
        return -np.array(self.sun_direction)

    @property
    def _is_overhead(self) -> bool:
        # Between the tropics the sun may stand in the zenith, where "up" is not across it.
        return abs(self.sun_direction[2]) > 0.999


AFTERNOON = Light()
"""Light without a choice: a fair afternoon in summer."""


@dataclass(frozen=True, slots=True)
class _Hour:
    """Light of a clear sky at an elevation of the sun."""

    elevation_deg: float
    ambient_rgb: Colour
    sun_rgb: Colour
    sun_share: float
    sky_share: float
    horizon_rgb: Colour
    zenith_rgb: Colour


_DAY = AFTERNOON
# The colours below the horizon are darker than a film would have them, yet lighter than the eye
# sees: a camera's exposure rises in the dark, and a black picture tests nothing.
_HOURS = (
    _Hour(
        -18, (0.09, 0.10, 0.15), (1.00, 0.84, 0.58), 0, 0.02, (0.07, 0.08, 0.13), (0.02, 0.03, 0.07)
    ),
    _Hour(
        -8, (0.11, 0.12, 0.19), (0.98, 0.82, 0.58), 0, 0.06, (0.30, 0.23, 0.26), (0.05, 0.07, 0.17)
    ),
    _Hour(
        -2, (0.20, 0.21, 0.30), (0.66, 0.56, 0.50), 0, 0.22, (0.86, 0.56, 0.40), (0.16, 0.23, 0.44)
    ),
    _Hour(
        0.5,
        (0.24, 0.25, 0.33),
        (0.74, 0.48, 0.30),
        0.55,
        0.26,
        (0.94, 0.68, 0.47),
        (0.20, 0.31, 0.56),
    ),
    _Hour(
        8,
        (0.28, 0.30, 0.36),
        (0.78, 0.62, 0.44),
        0.86,
        0.30,
        (0.90, 0.82, 0.74),
        (0.24, 0.42, 0.71),
    ),
    _Hour(
        20,
        (0.30, 0.33, 0.38),
        (0.77, 0.69, 0.58),
        0.90,
        0.30,
        (0.82, 0.86, 0.90),
        (0.26, 0.46, 0.79),
    ),
    _Hour(
        35, _DAY.ambient_rgb, _DAY.sun_rgb, 0.90, 0.30, _DAY.sky.horizon_rgb, _DAY.sky.zenith_rgb
    ),
)
_LAMPS_BELOW_DEG = -1.0
"""Elevation of the sun at which lamps are switched on."""
_COVERS = {"clear": 4.0, "fair": 0.42, "overcast": -0.75}
_GREY = np.array([0.96, 1.0, 1.05])
"""Colour of light through clouds, beside its brightness."""


@functools.lru_cache(maxsize=64)
def light_of(weather: Weather, latitude_deg: float, longitude_deg: float) -> Light:
    """Return the light of a place on the earth in some weather.

    Args:
        weather: Time of day, weather and season.
        latitude_deg: Latitude, WGS 84.
        longitude_deg: Longitude, WGS 84; it only turns local solar time into that of Greenwich.
    """
    if weather == Weather():
        return AFTERNOON
    direction, elevation_deg = sunlight(weather, latitude_deg, longitude_deg)
    hour = _at(elevation_deg)
    is_foggy = weather.visibility_m is not None and weather.visibility_m < FOG_BELOW_M
    # Fog scatters sunlight as clouds do, so that nothing in it has a shadow.
    is_up, is_overcast = elevation_deg > 0.0, is_foggy or weather.sky == "overcast"
    day = float(np.mean(hour.horizon_rgb) / np.mean(_DAY.sky.horizon_rgb))
    light = Light(
        sun_direction=direction if is_up and not is_overcast else AFTERNOON_SUN,
        ambient_rgb=hour.ambient_rgb,
        sun_rgb=hour.sun_rgb,
        sun_share=hour.sun_share if is_up else 0.0,
        sky_share=hour.sky_share,
        sky=SkyColours(
            to_sun=_negative(direction),
            horizon_rgb=hour.horizon_rgb,
            zenith_rgb=hour.zenith_rgb,
            land=_land(hour),
            sun=1.0 if elevation_deg > -3.0 else 0.0,
            cover=_COVERS["overcast" if is_overcast else weather.sky],
            stars=float(np.clip((-4.0 - elevation_deg) / 8.0, 0.0, 1.0)),
        ),
        visibility_m=weather.visibility_m,
        falling=weather.falling,
        season=weather.season,
        is_dark=elevation_deg < _LAMPS_BELOW_DEG,
    )
    return _under_clouds(light, day) if is_overcast else light


def _under_clouds(light: Light, day: float) -> Light:
    """Return the same hour under closed clouds: no shadows, grey, and a little darker."""
    level = 0.85 * float(np.mean(light.ambient_rgb))
    lit = light.sun_rgb if light.is_dark else _colour(0.62 * np.mean(light.sun_rgb) * _GREY)
    return replace(
        light,
        ambient_rgb=_colour(level * _GREY),
        sun_rgb=lit,
        sun_share=0.0,
        sky_share=light.sky_share if light.is_dark else 0.80,
        sky=replace(
            light.sky,
            horizon_rgb=_colour(0.76 * day * _GREY),
            zenith_rgb=_colour(0.60 * day * _GREY),
            land=_colour(0.80 * np.array(light.sky.land)),
            sun=0.0,
            stars=0.0,
        ),
    )


def _at(elevation_deg: float) -> _Hour:
    """Return the light at an elevation, between the rows of the table."""
    degrees = [hour.elevation_deg for hour in _HOURS]

    def between(name: str) -> np.ndarray:
        rows = np.array([np.atleast_1d(getattr(hour, name)) for hour in _HOURS])
        return np.array([np.interp(elevation_deg, degrees, column) for column in rows.T])

    return _Hour(
        elevation_deg,
        _colour(between("ambient_rgb")),
        _colour(between("sun_rgb")),
        float(between("sun_share")[0]),
        float(between("sky_share")[0]),
        _colour(between("horizon_rgb")),
        _colour(between("zenith_rgb")),
    )


def _land(hour: _Hour) -> Colour:
    """Return the brightness of land beside the day's: land is lit as a level face is."""
    lit = [np.array(each.ambient_rgb) + 0.7 * each.sky_share / 0.3 * np.array(each.sun_rgb)
           for each in (hour, _HOURS[-1])]  # fmt: skip
    return _colour(np.minimum(1.0, lit[0] / lit[1]))


def _negative(direction: Direction) -> Direction:
    x, y, z = direction
    return -x, -y, -z


def _colour(rgb: np.ndarray) -> Colour:
    red, green, blue = np.clip(np.asarray(rgb, dtype=float), 0.0, 1.0).tolist()
    return red, green, blue
