"""Hover points above an area or aslant of it, and the air between them and the area.

A pilot looks at an area from a hover point and goes down from there, so the whole line in between
must be free. These are the candidates; the caller tests them against its map.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3

HOVER_HEIGHTS_M = (4.0, 3.5, 3.0, 2.5, 2.0, 1.6, 1.2)
"""Heights of hover points above an area; the first free one is used."""
_STEP_M = 0.1
# Horizontal distances of slanting hover points, and their directions all around.
_ASIDE_M = (0.3, 0.6, 0.9, 1.2, 1.5)
_N_DIRECTIONS = 12


def hover_columns(foot_enu_m: Vector3, lowest_m: float) -> Iterator[Float[np.ndarray, "n 3"]]:
    """Yield columns of points from just above a place up to a hover point, the highest first.

    Args:
        foot_enu_m: Point on the surface.
        lowest_m: Height of the lowest point above the surface.
    """
    x, y, z = foot_enu_m
    for height_m in HOVER_HEIGHTS_M:
        heights = np.append(np.arange(lowest_m, height_m, _STEP_M), height_m)
        yield np.column_stack([np.full_like(heights, x), np.full_like(heights, y), z + heights])


def slanting_lines(foot_enu_m: Vector3, lowest_m: float) -> Iterator[Float[np.ndarray, "n 3"]]:
    """Yield lines of points from just above a place up to hover points beside it, nearest first.

    No line is flatter than 45 degrees, so that the place stays in view on the way down.

    Args:
        foot_enu_m: Point on the surface.
        lowest_m: Height of the lowest point above the surface.
    """
    low = np.add(foot_enu_m, (0.0, 0.0, lowest_m))
    for aside_m in _ASIDE_M:
        for height_m in HOVER_HEIGHTS_M:
            # Flatter than 45 degrees.
            if height_m - lowest_m < aside_m:
                continue
            for turn in range(_N_DIRECTIONS):
                angle_rad = 2.0 * math.pi * turn / _N_DIRECTIONS
                east_m, north_m = aside_m * math.cos(angle_rad), aside_m * math.sin(angle_rad)
                hover = np.add(foot_enu_m, (east_m, north_m, height_m))
                n_points = 2 + math.ceil(float(np.linalg.norm(hover - low)) / _STEP_M)
                yield np.linspace(low, hover, n_points)
