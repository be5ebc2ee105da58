"""Depth image on the cells of a grid: mean height, its variance, and extremes.

A few wrong pixels, matched with something else altogether, may be metres off. They must move
neither mean nor extremes, so trimmed means, medians and agreement of three points are used.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

OUTLYING_SIGMAS = 3.0
"""Standard deviations by which noise may move a point off the surface."""
_FLOOR_M = 0.001
"""Least deviation of a cell's height by one frame."""
_ALIKE_PIXELS = 4.0
"""Neighbouring pixels that count as one, because the errors of stereo cameras are alike in them."""
_FEW_POINTS = 40
"""Number of points above which a wrong one hardly moves the mean of a cell."""


@kernel
def rasterise(
    points: Float[np.ndarray, "k 3"],
    center: Float[np.ndarray, " 3"],
    resolution: float,
    n: int,
    eye_height: float,
    inverse_sigma: float,
) -> Float[np.ndarray, "4 n n"]:
    """Mean, top and bottom of the heights in each cell, and variance of the mean, 0 for unseen.

    If there are four points or more, the mean leaves out the highest and the lowest one. Top and
    bottom are heights that three points agree on (all points, if there are fewer), less the noise.

    Args:
        points: Points, ENU, m.
        center: Middle of the grid, ENU, m.
        resolution: Width of a cell, m.
        n: Number of rows and columns.
        eye_height: Height of the camera, ENU, m.
        inverse_sigma: Standard deviation of inverse depth, 1/m.
    """
    # Number of points, and sum, lowest and highest of their heights, for each cell.
    cells = np.zeros((n, n, 4), dtype=np.float32)
    cells[:, :, 2] = np.inf
    cells[:, :, 3] = -np.inf
    place = np.full(len(points), -1, dtype=np.int32)
    # Half a cell more, so that rounding down finds the nearest cell.
    middle = n // 2 + 0.5
    for k in range(len(points)):
        column = math.floor((points[k, 0] - center[0]) / resolution + middle)
        row = math.floor((points[k, 1] - center[1]) / resolution + middle)
        if 0 <= row < n and 0 <= column < n:
            height = np.float32(points[k, 2] - center[2])
            place[k] = row * n + column
            cell = cells[row, column]
            cell[0] += np.float32(1.0)
            cell[1] += height
            cell[2] = min(cell[2], height)
            cell[3] = max(cell[3], height)
    frame, noise = _means(cells, eye_height - center[2], inverse_sigma)
    _medians(points, center[2], place, cells, noise, frame)
    _agree(points, center[2], place, cells, noise, frame)
    for layer in range(3):
        frame[layer] += center[2]
    return frame


@kernel
def _means(
    cells: Float[np.ndarray, "n n 4"], eye_height: float, inverse_sigma: float
) -> tuple[Float[np.ndarray, "4 n n"], Float[np.ndarray, "n n"]]:
    """Means as heights, tops and bottoms of the cells, and the noise of one point in each."""
    n = len(cells)
    frame, noise = np.zeros((4, n, n)), np.zeros((n, n))
    for row in range(n):
        for column in range(n):
            some, total, low, high = cells[row, column]
            if some == 0:
                continue
            mean = (total - low - high) / (some - 2) if some >= 4 else total / some
            sigma = inverse_sigma * (eye_height - mean) ** 2
            noise[row, column] = OUTLYING_SIGMAS * sigma
            frame[:3, row, column] = mean
            share = min(1.0, _ALIKE_PIXELS / some)
            frame[3, row, column] = _FLOOR_M * _FLOOR_M + sigma * sigma * share
    return frame, noise


@kernel
def _medians(
    points: Float[np.ndarray, "k 3"],
    level: float,
    place: Int[np.ndarray, " k"],
    cells: Float[np.ndarray, "n n 4"],
    noise: Float[np.ndarray, "n n"],
    frame: Float[np.ndarray, "4 n n"],
) -> None:
    """Replace means by medians in cells whose few points spread more than noise allows."""
    n = len(noise)
    slot = np.full((n, n), -1, dtype=np.int32)
    n_slots = 0
    for row in range(n):
        for column in range(n):
            some, _, low, high = cells[row, column]
            if 3 <= some <= _FEW_POINTS and high - low > 2.0 * noise[row, column] + _FLOOR_M:
                slot[row, column] = n_slots
                n_slots += 1
    heights, filled = np.empty((n_slots, _FEW_POINTS)), np.zeros(n_slots, dtype=np.int32)
    for k in range(len(points)):
        if place[k] >= 0:
            i = slot[place[k] // n, place[k] % n]
            if i >= 0:
                heights[i, filled[i]] = points[k, 2] - level
                filled[i] += 1
    for row in range(n):
        for column in range(n):
            i = slot[row, column]
            if i >= 0:
                frame[:3, row, column] = np.median(heights[i, : filled[i]])


@kernel
def _agree(
    points: Float[np.ndarray, "k 3"],
    level: float,
    place: Int[np.ndarray, " k"],
    cells: Float[np.ndarray, "n n 4"],
    noise: Float[np.ndarray, "n n"],
    frame: Float[np.ndarray, "4 n n"],
) -> None:
    """Move tops and bottoms out as far as enough points lie beyond the noise."""
    n = len(noise)
    # Three farthest points of each cell beyond the noise, farthest first, above and below.
    beyond = np.zeros((n, n, 6), dtype=np.float32)
    for k in range(len(points)):
        if place[k] < 0:
            continue
        row, column = place[k] // n, place[k] % n
        above = points[k, 2] - level - frame[0, row, column]
        if abs(above) > noise[row, column]:
            side = 0 if above > 0 else 3
            excess = np.float32(abs(above) - noise[row, column])
            best = beyond[row, column, side : side + 3]
            for i in range(3):
                if excess > best[i]:
                    excess, best[i] = best[i], excess
    for row in range(n):
        for column in range(n):
            # The third farthest of three: all three reach as far. Fewer points: the farthest that
            # all reach.
            agreed = max(min(int(cells[row, column, 0]), 3) - 1, 0)
            frame[1, row, column] += beyond[row, column, agreed]
            frame[2, row, column] -= beyond[row, column, 3 + agreed]
