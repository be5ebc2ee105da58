"""Hover points above an area, and the air below them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3

HOVER_HEIGHTS_M = (4.0, 3.5, 3.0, 2.5, 2.0, 1.6, 1.2)
"""Heights of hover points above an area; the first free one is used."""
_STEP_M = 0.1


def hover_columns(foot_enu_m: Vector3, lowest_m: float) -> Iterator[Float[np.ndarray, "n 3"]]:
    """Columns of points from just above a place up to a hover point, the highest column first.

    Args:
        foot_enu_m: Point on the surface.
        lowest_m: Height of the lowest point above the surface.
    """
    x, y, z = foot_enu_m
    for height_m in HOVER_HEIGHTS_M:
        heights = np.append(np.arange(lowest_m, height_m, _STEP_M), height_m)
        yield np.column_stack([np.full_like(heights, x), np.full_like(heights, y), z + heights])
