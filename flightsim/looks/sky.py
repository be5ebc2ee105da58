"""Sky of both camera renderers, painted where a picture shows nothing: haze, hills, clouds, sun.

Below the horizon there is land too far to be drawn. The colours, the sun and the cover of clouds
are those of a `SkyColours`.
"""

from __future__ import annotations

import functools

import numpy as np
from jaxtyping import Float, UInt8

from autonomy.jit import kernel
from flightsim.looks.light import AFTERNOON, SkyColours

FAR_LAND_RGB = (0.60, 0.70, 0.66)
"""Colour to which land fades in the distance."""

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
_LATTICE = 64
_STAR_CELLS = 60.0
"""Cells of the grid of stars from the zenith to the horizon."""
_STAR_RADIUS = 0.16
"""Radius of a star in cells: a third of a degree, as fine as the table."""


def fill_sky(
    rgb: UInt8[np.ndarray, "h w 3"],
    depth_m: Float[np.ndarray, "h w"],
    rotation_enu_from_optical: Float[np.ndarray, "3 3"],
    focal_px: float,
    colours: SkyColours = AFTERNOON.sky,
) -> None:
    """Write the sky into every pixel of a picture that shows nothing.

    The colours come from a table of a third of a degree.

    Args:
        rgb: Picture, changed.
        depth_m: Depth of its pixels, inf in the sky.
        rotation_enu_from_optical: Attitude of the camera.
        focal_px: Focal length in pixels.
        colours: Colours of the sky.
    """
    fill_from_table(
        rgb,
        np.ascontiguousarray(depth_m, dtype=np.float32),
        rotation_enu_from_optical.astype(np.float32),
        np.float32(focal_px),
        np.float32(_TABLE_PIXELS / 2 / _TABLE_REACH),
        _table(colours),
    )


@kernel
def fill_from_table(
    rgb: np.ndarray,
    depth_m: np.ndarray,
    turn: np.ndarray,
    focal_px: np.float32,
    reach_px: np.float32,
    table: np.ndarray,
) -> None:
    """Fill the pixels of infinite depth from a table of the sky.

    Args:
        rgb: Picture (h, w, 3) uint8, changed.
        depth_m: Depth (h, w) float32.
        turn: Attitude of the camera, ENU from optical (3, 3) float32.
        focal_px: Focal length.
        reach_px: Pixels of the table from the zenith to the horizon.
        table: Stereographic picture of the sky (n, n, 3) uint8.
    """
    height, width = depth_m.shape
    n = len(table)
    half_px, most_px = np.float32(n / 2), np.float32(n - 1)
    middle_row, middle_column = np.float32((height - 1) / 2), np.float32((width - 1) / 2)
    for row in range(height):
        down = (np.float32(row) - middle_row) / focal_px
        for column in range(width):
            if depth_m[row, column] != np.inf:
                continue
            right = (np.float32(column) - middle_column) / focal_px
            # In the order of `Viewpoint.rays_enu`, so that both round alike.
            x = right * turn[0, 0] + (down * turn[0, 1] + turn[0, 2])
            y = right * turn[1, 0] + (down * turn[1, 1] + turn[1, 2])
            z = right * turn[2, 0] + (down * turn[2, 1] + turn[2, 2])
            # Straight down there is no sky; any finite number works.
            scale = reach_px / max(np.sqrt(x * x + y * y + z * z) + z, np.float32(1e-6))
            i = int(min(max(y * scale + half_px, np.float32(0.0)), most_px))
            j = int(min(max(x * scale + half_px, np.float32(0.0)), most_px))
            for channel in range(3):
                rgb[row, column, channel] = table[i, j, channel]


def painted_sky(
    directions: Float[np.ndarray, "n 3"], colours: SkyColours = AFTERNOON.sky
) -> Float[np.ndarray, "n 3"]:
    """Colour of the sky along unit directions, 0 to 1, exact: for pictures and for the table."""
    x, y, z = np.asarray(directions, dtype=np.float32).T
    up = np.clip(z, 0.0, 1.0)
    horizon, zenith = (
        np.array(each, dtype=np.float32) for each in (colours.horizon_rgb, colours.zenith_rgb)
    )
    towards = np.array(colours.to_sun, dtype=np.float32)
    rgb = horizon + np.sqrt(up)[:, None] * (zenith - horizon)
    to_sun = np.arccos(np.clip(directions @ towards, -1.0, 1.0)).astype(np.float32)
    glow = colours.sun * (0.30 * np.exp(-to_sun / 0.16) + 0.25 * np.exp(-to_sun / 0.04))
    rgb += glow[:, None] * np.array([1.0, 0.93, 0.75], np.float32)
    if colours.stars > 0.0:
        rgb += colours.stars * _stars(x, y, up)[:, None]
    has_clouds = up > 0.02
    parts = [part[has_clouds] for part in (rgb, x, y, up, to_sun)]
    rgb[has_clouds] = _with_clouds(colours, *parts)
    is_sun = colours.sun * np.clip((_SUN_RADIUS_RAD - to_sun) / 0.004, 0.0, 1.0)[:, None]
    rgb += is_sun * (np.array([1.0, 0.98, 0.90], np.float32) - rgb)
    is_low = z < _HIGHEST_LAND
    rgb[is_low] = _with_land(colours, *(part[is_low] for part in (rgb, x, y, z)))
    return np.clip(rgb, 0.0, 1.0)


def _with_clouds(
    colours: SkyColours,
    rgb: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    up: np.ndarray,
    to_sun: np.ndarray,
) -> np.ndarray:
    """Clouds on a plane overhead, thinner towards the horizon."""
    reach = 1.0 / (up + 0.11)
    u, v = 1.6 * x * reach, 1.6 * y * reach
    shape = sum(_noise(u * f + 7.0 * f, v * f, k) / f for k, f in enumerate((1.0, 2.1, 4.3, 8.9)))
    over = shape - np.float32(colours.cover)
    cover = np.clip(1.5 * over, 0.0, 1.0) * np.clip(up / 0.12, 0.0, 1.0)
    lit = np.clip(0.9 - 0.55 * over + 0.2 * np.exp(-to_sun / 0.5), 0.0, 1.0)[:, None]
    cloud = _CLOUD_SHADE_RGB + lit * (_CLOUD_RGB - _CLOUD_SHADE_RGB)
    cloud = cloud * np.array(colours.land, dtype=np.float32)
    return rgb + 0.92 * cover[:, None] * (cloud - rgb)


def _with_land(
    colours: SkyColours, rgb: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """Hills and woods along the horizon, far land below it."""
    # Sample around the circle, so that the silhouette closes.
    level = 1.0 / np.maximum(np.hypot(x, y), 1e-6)
    factors = np.array(colours.land, dtype=np.float32)
    u, v = x * level, y * level
    hills = 0.030 + 0.020 * _noise(2.2 * u + 9.0, 2.2 * v, 5) + 0.006 * _noise(7 * u, 7 * v + 5, 6)
    woods = 0.007 + 0.005 * _noise(9 * u, 9 * v + 3, 7) + 0.003 * _noise(60 * u, 60 * v, 8)
    for height, colour in ((hills, _HILL_RGB), (woods, _WOOD_RGB)):
        is_below = np.clip((height - z) / 0.002, 0.0, 1.0)[:, None]
        rgb = rgb + is_below * (colour * factors - rgb)
    is_land = np.clip(0.5 - z / 0.003, 0.0, 1.0)[:, None]
    land = _FAR_LAND + np.clip(-z / 0.10, 0.0, 1.0)[:, None] * (_NEAR_LAND - _FAR_LAND)
    return rgb + is_land * (land * factors - rgb)


def _stars(x: np.ndarray, y: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Brightness of stars: one point at a random place in some cells of a grid over the sky."""
    # The stereographic grid has cells of about the same size everywhere above the horizon.
    u, v = (_STAR_CELLS * part / (1.0 + up) + _LATTICE for part in (x, y))
    column, row = np.floor(u).astype(np.int32), np.floor(v).astype(np.int32)
    cell = (row * 31 + column) % _LATTICE**2
    across, along, brightness = (_lattice(octave).take(cell) for octave in (11, 12, 13))
    away = np.hypot(u - column - 0.5 - 0.3 * across, v - row - 0.5 - 0.3 * along)
    # A third of the cells have a star, and few stars are bright.
    power = np.clip((brightness - 0.35) / 0.65, 0.0, 1.0) ** 3
    return power * np.clip(1.0 - away / _STAR_RADIUS, 0.0, 1.0) * np.clip(up / 0.15, 0.0, 1.0)


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


@functools.lru_cache(maxsize=4)
def _table(colours: SkyColours) -> np.ndarray:
    """Table (rows, columns, 3) uint8; y and x of the stereographic picture."""
    axis = (np.arange(_TABLE_PIXELS) + 0.5 - _TABLE_PIXELS / 2) * 2 * _TABLE_REACH / _TABLE_PIXELS
    x, y = np.meshgrid(axis.astype(np.float32), axis.astype(np.float32))
    squared = x * x + y * y
    directions = np.stack([2 * x, 2 * y, 1 - squared], axis=2) / (1 + squared)[..., None]
    rgb = painted_sky(directions.reshape(-1, 3), colours)
    return (255.0 * rgb + 0.5).astype(np.uint8).reshape(_TABLE_PIXELS, _TABLE_PIXELS, 3)
