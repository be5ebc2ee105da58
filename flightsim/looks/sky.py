"""Sky of both camera renderers, painted where a picture shows nothing: haze, hills, clouds, sun.

The sun is at its direction in `light`; below the horizon there is land too far to be drawn.
"""

from __future__ import annotations

import functools

import numpy as np
from jaxtyping import Float, UInt8

from flightsim.looks.light import SUN_DIRECTION

HORIZON_RGB = (0.80, 0.87, 0.93)
ZENITH_RGB = (0.26, 0.47, 0.80)
FAR_LAND_RGB = (0.60, 0.70, 0.66)
"""Colour to which land fades in the distance."""

_HORIZON = np.array(HORIZON_RGB, dtype=np.float32)
_ZENITH = np.array(ZENITH_RGB, dtype=np.float32)
_TO_SUN = -np.array(SUN_DIRECTION, dtype=np.float32)
_SUN_RADIUS_RAD = 0.022
"""Radius of the sun, larger than the real one, so that a small picture shows it."""
_FAR_LAND = np.array(FAR_LAND_RGB, dtype=np.float32)
_NEAR_LAND = np.array([0.58, 0.66, 0.55], dtype=np.float32)
_HILL_RGB = np.array([0.60, 0.70, 0.79], dtype=np.float32)
_WOOD_RGB = np.array([0.47, 0.58, 0.54], dtype=np.float32)
_CLOUD_RGB = np.array([0.98, 0.98, 0.99], dtype=np.float32)
_CLOUD_SHADE_RGB = np.array([0.74, 0.79, 0.86], dtype=np.float32)

_HIGHEST_LAND = 0.08
"""Sine of the elevation below which there may be hills."""

# The table is a stereographic picture of the sky about the zenith; the horizon has radius 1.
_TABLE_PIXELS = 540
_TABLE_REACH = 1.12
_LATTICE = 64  # cells of the noise, after which it repeats


def sky_rgb(rays_enu: Float[np.ndarray, "n 3"]) -> UInt8[np.ndarray, "n 3"]:
    """Return the colour of the sky along rays of any length, from a table of a third of a degree.

    The table costs one look-up a pixel; `painted_sky` computes noise for each.
    """
    x, y, z = np.asarray(rays_enu, dtype=np.float32).T
    scale = np.sqrt(x * x + y * y + z * z) + z
    # Straight down there is no sky; any finite number works.
    scale = (_TABLE_PIXELS / 2 / _TABLE_REACH) / np.maximum(scale, 1e-6)
    column = np.clip(x * scale + _TABLE_PIXELS / 2, 0, _TABLE_PIXELS - 1).astype(np.int32)
    row = np.clip(y * scale + _TABLE_PIXELS / 2, 0, _TABLE_PIXELS - 1).astype(np.int32)
    return _table()[row, column]


def painted_sky(directions: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """Return the exact colour of the sky along unit directions, 0 to 1."""
    x, y, z = np.asarray(directions, dtype=np.float32).T
    up = np.clip(z, 0.0, 1.0)
    rgb = _HORIZON + np.sqrt(up)[:, None] * (_ZENITH - _HORIZON)
    # Angle to the sun: its glow fades over degrees, its disc has an edge.
    to_sun = np.arccos(np.clip(directions @ _TO_SUN, -1.0, 1.0)).astype(np.float32)
    glow = 0.30 * np.exp(-to_sun / 0.16) + 0.25 * np.exp(-to_sun / 0.04)
    rgb += glow[:, None] * np.array([1.0, 0.93, 0.75], np.float32)
    # Near the horizon clouds would be endless and flicker.
    has_clouds = up > 0.02
    rgb[has_clouds] = _with_clouds(*(part[has_clouds] for part in (rgb, x, y, up, to_sun)))
    is_sun = np.clip((_SUN_RADIUS_RAD - to_sun) / 0.004, 0.0, 1.0)[:, None]
    rgb += is_sun * (np.array([1.0, 0.98, 0.90], np.float32) - rgb)
    is_low = z < _HIGHEST_LAND
    rgb[is_low] = _with_land(*(part[is_low] for part in (rgb, x, y, z)))
    return np.clip(rgb, 0.0, 1.0)


def _with_clouds(
    rgb: np.ndarray, x: np.ndarray, y: np.ndarray, up: np.ndarray, to_sun: np.ndarray
) -> np.ndarray:
    """Add fair-weather clouds on a plane overhead, thinner towards the horizon."""
    # A ray meets a plane overhead at 1 / up; the addition keeps the horizon finite.
    reach = 1.0 / (up + 0.11)
    u, v = 1.6 * x * reach, 1.6 * y * reach
    shape = sum(_noise(u * f + 7.0 * f, v * f, k) / f for k, f in enumerate((1.0, 2.1, 4.3, 8.9)))
    cover = np.clip(1.5 * (shape - 0.42), 0.0, 1.0) * np.clip(up / 0.12, 0.0, 1.0)
    lit = np.clip(0.9 - 0.55 * (shape - 0.42) + 0.2 * np.exp(-to_sun / 0.5), 0.0, 1.0)[:, None]
    cloud = _CLOUD_SHADE_RGB + lit * (_CLOUD_RGB - _CLOUD_SHADE_RGB)
    return rgb + 0.92 * cover[:, None] * (cloud - rgb)


def _with_land(rgb: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Add hills and woods along the horizon, and far land below it."""
    # Sample around the circle, so that the silhouette closes.
    level = 1.0 / np.maximum(np.hypot(x, y), 1e-6)
    u, v = x * level, y * level
    hills = 0.030 + 0.020 * _noise(2.2 * u + 9.0, 2.2 * v, 5) + 0.006 * _noise(7 * u, 7 * v + 5, 6)
    woods = 0.007 + 0.005 * _noise(9 * u, 9 * v + 3, 7) + 0.003 * _noise(60 * u, 60 * v, 8)
    for height, colour in ((hills, _HILL_RGB), (woods, _WOOD_RGB)):
        is_below = np.clip((height - z) / 0.002, 0.0, 1.0)[:, None]
        rgb = rgb + is_below * (colour - rgb)
    is_land = np.clip(0.5 - z / 0.003, 0.0, 1.0)[:, None]
    land = _FAR_LAND + np.clip(-z / 0.10, 0.0, 1.0)[:, None] * (_NEAR_LAND - _FAR_LAND)
    return rgb + is_land * (land - rgb)


def _noise(u: np.ndarray, v: np.ndarray, octave: int) -> np.ndarray:
    """Smooth noise in the plane, about -1 to 1; each octave has its own lattice."""
    lattice = _lattice(octave)
    column, row = np.floor(u).astype(np.int32), np.floor(v).astype(np.int32)
    s, t = u - column, v - row
    # Smooth step, so that the slope vanishes at the lattice points and no grid shows.
    s, t = s * s * (3 - 2 * s), t * t * (3 - 2 * t)
    i, j = row % _LATTICE * _LATTICE, column % _LATTICE
    k, m = (row + 1) % _LATTICE * _LATTICE, (column + 1) % _LATTICE
    a, b, c, d = (lattice.take(index) for index in (i + j, i + m, k + j, k + m))
    low, high = a + s * (b - a), c + s * (d - c)
    return low + t * (high - low)


@functools.cache
def _lattice(octave: int) -> np.ndarray:
    rng = np.random.default_rng([0x5C1, octave])
    return rng.uniform(-1.0, 1.0, (_LATTICE, _LATTICE)).astype(np.float32)


@functools.cache
def _table() -> np.ndarray:
    """Table (rows, columns, 3) uint8; y and x of the stereographic picture."""
    axis = (np.arange(_TABLE_PIXELS) + 0.5 - _TABLE_PIXELS / 2) * 2 * _TABLE_REACH / _TABLE_PIXELS
    x, y = np.meshgrid(axis.astype(np.float32), axis.astype(np.float32))
    squared = x * x + y * y
    directions = np.stack([2 * x, 2 * y, 1 - squared], axis=2) / (1 + squared)[..., None]
    rgb = painted_sky(directions.reshape(-1, 3))
    return (255.0 * rgb + 0.5).astype(np.uint8).reshape(_TABLE_PIXELS, _TABLE_PIXELS, 3)
