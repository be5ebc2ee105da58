"""Raising of the land of a site that was laid out on flat ground.

    symbol   name
    d        distance from level ground, less the margin of the grid, m
    s        gradient of banks
    h        height of the ground, m

Land rises from level ground as a bank of gradient s, and levels out at a height that varies from
place to place: h = t tanh(b / t), where b = s (sqrt(d^2 + c^2) - c) and t is that height. The root
makes the foot of a bank round, and tanh its top, so that no crease remains. No land lies below 0,
so that slabs of lawns stay under the grass that covers them.
"""

from __future__ import annotations

import math

import numpy as np
import shapely
from jaxtyping import Float
from scipy.ndimage import distance_transform_edt, gaussian_filter

from aeroscene.landform.land_style import LAND_STYLES, LandStyle
from aeroscene.landform.level_areas import level_ground
from aeroscene.landform.objects import on_relief
from aeroscene.scene import Relief, Scene

SPACING_M = 2.0
"""Distance between nodes in a site of usual size."""
MOST_GRADIENT = 0.2
"""Gradient of the steepest bank."""
_AROUND_M = 24.0
"""Width of the land around the flight volume."""
_MOST_CELLS = 120
"""Number of cells along one axis from which they are wider."""
_FOOT_M = 1.0
"""Distance over which a bank begins: c above."""
_BLUR_M = 1.5
"""Width of the Gaussian that rounds off creases."""
_GRADIENT = 0.14
"""Steepest rise between neighbouring nodes before rounding."""
_HEM_M = 2.0
"""Distance from level ground over which a smoothed height returns to 0."""
_BORDER_M = 10.0
"""Distance from the border of the grid over which the land falls to 0."""
_WAVES_M = ((34.0, 0.65), (15.0, 0.35))
"""Lengths of the swells, and their shares."""
_LOWEST = 0.3
"""Least height of open land, relative to the greatest."""
_NOTHING_NEAR_M = 1e3
_LEAST_RISE_M = 0.12
"""Rise up to which land stays flat."""


def raise_relief(scene: Scene, rng: np.random.Generator) -> Scene:
    """Give a scene gentle land in its green and around it; everything on grass stands on it.

    Roads, paths, water, buildings, fences, terraces and pads keep their level ground, and so their
    heights. Landing areas are dropped, because they depend on the ground.

    Args:
        scene: A scene on flat ground. A scene that has a relief, lies indoors, or has a theme
            without land is returned as it is.
        rng: Draws the land.
    """
    style = LAND_STYLES.get(scene.theme)
    if scene.relief is not None or scene.domain == "indoor" or style is None:
        return scene
    relief = _relief(scene, style, rng)
    return scene if relief is None else on_relief(scene, relief)


def _relief(scene: Scene, style: LandStyle, rng: np.random.Generator) -> Relief | None:
    """The land; None if hardly any of it rises."""
    origin, spacing_m, shape = _grid(scene)
    x, y = (origin[i] + spacing_m * np.arange(shape[1 - i]) for i in range(2))
    swell = _swell(shape, spacing_m, rng)
    bank = rng.uniform(*style.bank)
    scale = rng.uniform(0.6, 1.0)
    away_m = _away_m(scene, x, y, spacing_m)
    most_m = _most_m(scene, style, x, y)
    # Some land of every site lies low, as a share of what the style allows.
    top_m = scale * most_m * (_LOWEST + (1.0 - _LOWEST) * swell)
    heights = top_m * np.tanh(bank * (np.hypot(away_m, _FOOT_M) - _FOOT_M) / top_m)
    inward_m = _inward_m(away_m, spacing_m)
    # Sides without streets keep their height, which goes on beyond the grid.
    heights *= _smooth(inward_m / _BORDER_M)
    heights = gaussian_filter(_gentle(heights, spacing_m), _BLUR_M / spacing_m)
    heights *= _smooth(np.minimum(away_m, inward_m) / _HEM_M)
    # Scaled as a whole, so that the shape stays and the limit holds.
    steepest = Relief(origin, spacing_m, heights).steepest
    heights *= min(1.0, MOST_GRADIENT / max(steepest, 1e-9))
    if heights.max() < _LEAST_RISE_M:
        return None
    return Relief(origin, spacing_m, np.round(heights, 2))


def _grid(scene: Scene) -> tuple[tuple[float, float], float, tuple[int, int]]:
    """South-west node, spacing and shape of a grid over a flight volume and the land around it."""
    low, high = (np.array(c[:2]) for c in (scene.extent_min_enu_m, scene.extent_max_enu_m))
    sides_m = high - low + 2 * _AROUND_M
    # Whole halves of a metre; large sites get wider cells rather than more of them.
    spacing_m = max(SPACING_M, math.ceil(2 * sides_m.max() / _MOST_CELLS) / 2)
    columns, rows = (np.ceil(sides_m / spacing_m).astype(int) + 1).tolist()
    east, north = np.round((low + high - spacing_m * np.array([columns - 1, rows - 1])) / 2, 2)
    return (float(east), float(north)), spacing_m, (rows, columns)


def _away_m(
    scene: Scene, x: np.ndarray, y: np.ndarray, spacing_m: float
) -> Float[np.ndarray, "rows columns"]:
    """Distance of nodes from cells that extend into level ground, m; 0 at the cells' corners."""
    outlines = level_ground(scene, np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    is_level = np.zeros((len(y), len(x)), dtype=bool)
    east, north = (0.5 * (line[:-1] + line[1:]) for line in (x, y))
    middles = np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2)
    # A centimetre more, so that outlines on a cell's border touch both cells.
    half_m = spacing_m / 2 + 0.01
    cells = shapely.box(*(middles - half_m).T, *(middles + half_m).T)
    tree, geometries = shapely.STRtree(cells), np.array(outlines, dtype=object)
    touched = np.unique(tree.query(geometries, predicate="intersects")[1])
    if not len(touched):
        return np.full(is_level.shape, _NOTHING_NEAR_M)
    row, column = np.divmod(touched, len(east))
    for i in (0, 1):
        for j in (0, 1):
            is_level[row + i, column + j] = True
    return spacing_m * np.asarray(distance_transform_edt(~is_level))


def _gentle(
    heights: Float[np.ndarray, "rows columns"], spacing_m: float
) -> Float[np.ndarray, "rows columns"]:
    """The highest land below the given one that rises no faster than `_GRADIENT`."""
    # A limit moves on by one node in each pass.
    for _ in range(math.ceil(_AROUND_M / spacing_m)):
        padded = np.pad(heights, 1, mode="edge")
        for axis in (0, 1):
            for step in (-1, 1):
                near = np.roll(padded, step, axis)[1:-1, 1:-1]
                heights = np.minimum(heights, near + _GRADIENT * spacing_m)
    return heights


def _most_m(
    scene: Scene, style: LandStyle, x: np.ndarray, y: np.ndarray
) -> Float[np.ndarray, "rows columns"]:
    """Greatest height of the land at nodes, in the site and around it, m."""
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    east_m, north_m = (
        np.maximum(np.maximum(low[i] - line, line - high[i]), 0.0) for i, line in enumerate((x, y))
    )
    out_m = np.maximum(east_m[None, :], north_m[:, None])
    share = _smooth(out_m / (0.5 * _AROUND_M))
    return style.rise_m + share * (style.around_m - style.rise_m)


def _swell(
    shape: tuple[int, int], spacing_m: float, rng: np.random.Generator
) -> Float[np.ndarray, "rows columns"]:
    """Rolling land from 0 to 1."""
    total = np.zeros(shape)
    for wave_m, share in _WAVES_M:
        # The spectrum of a Gaussian of width s falls to 1/e^2 at a wave of pi s.
        noise = gaussian_filter(rng.standard_normal(shape), wave_m / math.pi / spacing_m)
        total += share * noise / max(float(noise.std()), 1e-9)
    # Quantiles instead of extremes, which single peaks would decide.
    low, high = np.quantile(total, (0.02, 0.98)).tolist()
    return np.clip((total - low) / max(high - low, 1e-9), 0.0, 1.0)


def _inward_m(
    away_m: Float[np.ndarray, "rows columns"], spacing_m: float
) -> Float[np.ndarray, "rows columns"]:
    """Distance of nodes from the sides of the grid through which streets leave it, m.

    Beyond a side the ground keeps the height of the side. It is therefore flat around streets, and
    rises elsewhere.
    """
    inward_m = np.full(away_m.shape, np.inf)
    for axis in (0, 1):
        rank = np.arange(away_m.shape[axis])
        for side, steps in ((0, rank), (-1, rank[::-1])):
            if away_m.take(side, axis).min() == 0.0:
                inward_m = np.minimum(inward_m, spacing_m * np.expand_dims(steps, 1 - axis))
    return inward_m


def _smooth(share: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """A smooth step from 0 to 1, without a kink at either end."""
    share = np.clip(share, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)
