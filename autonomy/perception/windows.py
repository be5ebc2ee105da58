"""Properties of a window about every cell of a grid: planes, extremes, clearance.

A least-squares fit for each of ten thousand cells would be slow. Over a fully observed disc,
however, the plane separates into three sums: of heights, and of heights times offsets to the east
and to the north. Running sums then give it for all cells at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel


def disc(radius_m: float, resolution_m: float) -> Float[np.ndarray, "k k"]:
    """Window of cells, 1 if a cell is at least about half inside a circle, else 0."""
    reach = math.floor(radius_m / resolution_m + 0.5)
    offset = np.arange(-reach, reach + 1)
    return (np.hypot(*np.meshgrid(offset, offset)) <= radius_m / resolution_m + 0.5).astype(float)


@dataclass(frozen=True, kw_only=True, eq=False)
class WindowFit:
    """Plane and variance in a window about each cell; NaN unless the whole window is known."""

    plane: Float[np.ndarray, "3 n n"]
    """Least-squares plane: height over the cell, rise to east and north."""
    variance_m2: Float[np.ndarray, "n n"]
    """Mean of the cells' variances."""


def fit_planes(
    height: Float[np.ndarray, "n n"],
    variance: Float[np.ndarray, "n n"],
    known: Bool[np.ndarray, "n n"],
    window: Float[np.ndarray, "k k"],
    resolution_m: float,
) -> WindowFit:
    """Fit a plane in the window about each cell; beyond the border nothing is known."""
    half_widths = (window.sum(axis=1).astype(np.int64) - 1) // 2
    heights = np.where(known, height, np.float32(np.nan))
    height_sum, east_sum, north_sum, variance_sum = window_sums(heights, variance, half_widths)
    count = window.sum()
    moment = moment_m2(window, resolution_m) / resolution_m
    # A window of one cell has no slope.
    plane = np.stack([height_sum / count, east_sum / (moment or 1.0), north_sum / (moment or 1.0)])
    return WindowFit(plane=plane, variance_m2=np.maximum(variance_sum / count, 0.0))


@kernel
def window_sums(
    height: Float[np.ndarray, "n n"],
    variance: Float[np.ndarray, "n n"],
    half_widths: Int[np.ndarray, " k"],
) -> Float[np.ndarray, "4 n n"]:
    """Sums over a window about each cell; NaN if a height in it is, or if the border cuts it.

    The sums are those of heights, of heights times offsets in cells to the east and to the north,
    and of variances. Row by row the window has `half_widths` cells on either side of its middle.
    """
    n, reach = len(height), len(half_widths) // 2
    # Running sums along each row, one more than the number of columns.
    sums = np.zeros((4, n, n + 1))
    for i in range(n):
        for j in range(n):
            value = height[i, j]
            is_known = not np.isnan(value)
            known_value = value if is_known else np.float32(0.0)
            sums[0, i, j + 1] = sums[0, i, j] + known_value
            sums[1, i, j + 1] = sums[1, i, j] + j * known_value
            sums[2, i, j + 1] = sums[2, i, j] + variance[i, j]
            sums[3, i, j + 1] = sums[3, i, j] + (0.0 if is_known else 1.0)
    found = np.full((4, n, n), np.nan)
    n_inside = n - 2 * reach
    if n_inside <= 0:
        return found
    unknown = np.empty(n_inside)
    for i in range(reach, n - reach):
        total, east = found[0, i, reach : n - reach], found[1, i, reach : n - reach]
        north, spread = found[2, i, reach : n - reach], found[3, i, reach : n - reach]
        total[:], east[:], north[:], spread[:], unknown[:] = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(len(half_widths)):
            row, half = i + k - reach, half_widths[k]
            first, last = reach - half, reach + half + 1
            s, m, v, u = sums[0, row], sums[1, row], sums[2, row], sums[3, row]
            for j in range(n_inside):
                # The sum over a span of a row is the difference of two running sums.
                in_row = s[last + j] - s[first + j]
                total[j] += in_row
                east[j] += m[last + j] - m[first + j] - (reach + j) * in_row
                north[j] += (k - reach) * in_row
                spread[j] += v[last + j] - v[first + j]
                unknown[j] += u[last + j] - u[first + j]
        for j in range(n_inside):
            if unknown[j] > 0.0:
                total[j] = east[j] = north[j] = spread[j] = np.nan
    return found


@kernel
def smoothed(
    height: Float[np.ndarray, "n n"],
    sigma: Float[np.ndarray, "n n"],
    known: Bool[np.ndarray, "n n"],
    apart: float,
) -> Float[np.ndarray, "n n"]:
    """Mean over each known cell and those of its eight neighbours that are on the same surface.

    A neighbour whose height differs by more than `apart` times sigma is beyond an edge.
    """
    n = len(height)
    mean = height.copy()
    for row in range(n):
        for column in range(n):
            if not known[row, column]:
                continue
            middle, reach = height[row, column], apart * sigma[row, column]
            total, count = np.float32(0.0), 0
            for i in range(max(row - 1, 0), min(row + 2, n)):
                for j in range(max(column - 1, 0), min(column + 2, n)):
                    if known[i, j] and abs(height[i, j] - middle) <= reach:
                        total += height[i, j]
                        count += 1
            mean[row, column] = total / count
    return mean


def moment_m2(window: Float[np.ndarray, "k k"], resolution_m: float) -> float:
    """Sum of the squares of the cells' offsets from the middle along one axis, m^2."""
    offset = (np.arange(len(window)) - len(window) // 2) * resolution_m
    return float(np.sum(window * offset**2))


def highest(
    surface: Float[np.ndarray, "n n"],
    plane: Float[np.ndarray, "3 n n"],
    window: Float[np.ndarray, "k k"],
    resolution_m: float,
) -> Float[np.ndarray, "n n"]:
    """Rise of a surface above each cell's plane within the window; inf beyond the border."""
    return extremes(surface, np.zeros((0, 0)), plane, window, resolution_m)[0]


def extremes(
    top: Float[np.ndarray, "n n"],
    bottom: Float[np.ndarray, "n n"] | Float[np.ndarray, "0 0"],
    plane: Float[np.ndarray, "3 n n"],
    window: Float[np.ndarray, "k k"],
    resolution_m: float,
) -> Float[np.ndarray, "2 n n"]:
    """Rise of one surface above each cell's plane within the window, and sinking of another below.

    Beyond the border both are infinite. An empty bottom is skipped.
    """
    reach = len(window) // 2
    above = np.pad(top.astype(np.float32), reach, constant_values=np.inf)
    below = bottom.astype(np.float32)
    if bottom.size:
        below = np.pad(below, reach, constant_values=-np.inf)
    height, east, north = plane.astype(np.float32)
    offsets = np.argwhere(window > 0) - reach
    return extremes_about_planes(above, below, height, east, north, offsets, reach, resolution_m)


@kernel
def extremes_about_planes(
    top: Float[np.ndarray, "m m"],
    bottom: Float[np.ndarray, "l l"],
    height: Float[np.ndarray, "n n"],
    east: Float[np.ndarray, "n n"],
    north: Float[np.ndarray, "n n"],
    offsets: Int[np.ndarray, "k 2"],
    reach: int,
    resolution: float,
) -> Float[np.ndarray, "2 n n"]:
    """Largest top minus plane, and plane minus bottom, over a window about each cell.

    Top and bottom are `reach` cells wider than the grid on every side; bottom may be empty. A
    cell's plane has a height over the cell and rises by `east` and `north` per metre; `offsets` are
    rows and columns of the window's cells from its middle.
    """
    n = len(height)
    extremes = np.full((2, n, n), np.float32(-np.inf))
    for i in range(n):
        # Rows as arrays of their own: so the inner loops compile to vector instructions.
        high, low = extremes[0, i], extremes[1, i]
        level, east_row, north_row = height[i], east[i], north[i]
        for k in range(len(offsets)):
            x, y = np.float32(offsets[k, 1] * resolution), np.float32(offsets[k, 0] * resolution)
            right, across = offsets[k, 1] + reach, i + offsets[k, 0] + reach
            above = top[across, right : right + n]
            if len(bottom) == 0:
                for j in range(n):
                    plane = level[j] + x * east_row[j] + y * north_row[j]
                    high[j] = max(above[j] - plane, high[j])
                continue
            below = bottom[across, right : right + n]
            for j in range(n):
                plane = level[j] + x * east_row[j] + y * north_row[j]
                high[j] = max(above[j] - plane, high[j])
                low[j] = max(plane - below[j], low[j])
    return extremes


def clearance(is_usable: Bool[np.ndarray, "n n"], resolution_m: float) -> np.ndarray:
    """Distance to the nearest cell that is not usable, m; the map's border counts as such."""
    import cv2

    padded = np.pad(is_usable.astype(np.uint8), 1)
    return cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] * resolution_m
