"""Distances in a map computed for all cells at once, to compare with."""

from __future__ import annotations

import math

import numpy as np


def distance_to_marked(marked: np.ndarray, resolution_m: float, cap_m: float) -> np.ndarray:
    """Distance from the centre of each cell to the surface of the nearest marked one, capped."""
    far = 1e9
    squares = np.where(marked, 0.0, far)
    reach = min(math.ceil(cap_m / resolution_m + 0.5), max(marked.shape))
    for axis in range(3):
        least = squares.copy()
        for n in range(1, reach + 1):
            if n >= marked.shape[axis]:
                break
            near, away = np.moveaxis(least, axis, 0), np.moveaxis(squares, axis, 0)
            extra = (2 * n - 1) ** 2
            near[n:] = np.minimum(near[n:], away[:-n] + extra)
            near[:-n] = np.minimum(near[:-n], away[n:] + extra)
        squares = least
    return np.minimum(np.sqrt(squares) / 2 * resolution_m, cap_m)
