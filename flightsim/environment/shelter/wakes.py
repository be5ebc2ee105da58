"""First guess of the wind among blocks: the cavity and the wake in the lee of each.

    symbol    name
    W, L, H   extents of a block across the wind, along it, and upwards
    x, y, z   behind its lee face, from its middle across the wind, above its foot
    u         velocity along the wind over that of the open wind

    length of the cavity      L_r = 1.8 W / ((L/H)^0.3 (1 + 0.24 W/H)),  0.3 <= L/H <= 3
    its end at y and z        d = L_r sqrt(1 - (2y/W)^2) sqrt(1 - (z/H)^2)
    cavity, x < d             u = -(1 - x/d)^2
    wake, d <= x < 3d         u = 1 - (d/x)^1.5

Sources: Roeckle 1990, as in Kaplan and Dinar 1996, "A Lagrangian dispersion model for calculating
concentration distribution within a built-up domain", eqs. (3) to (7).
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

BLOCK_COLUMNS = ("x", "y", "cos yaw", "sin yaw", "length", "width", "top", "foot")
"""Columns of a block; top and foot are heights, ENU, m."""
_WAKE_CAVITIES = 3.0


def add_wakes(
    along: Float[np.ndarray, "nx ny nz"],
    centres_m: tuple[np.ndarray, np.ndarray, np.ndarray],
    blocks: Float[np.ndarray, "n 8"],
    axis: tuple[float, float],
) -> None:
    """Lessen a velocity along the wind where blocks shelter it.

    Args:
        along: Velocity along the wind over the open wind's, changed.
        centres_m: East, north and up of the cells, each of a shape that broadcasts to `along`.
        blocks: Rows of `BLOCK_COLUMNS`.
        axis: Horizontal unit vector along which the wind blows.
    """
    east, north, up = centres_m
    for x, y, cosine, sine, length, width, top, foot in blocks:
        rise = top - foot
        # Extents of the turned block along and across the wind.
        turn = abs(cosine * axis[0] + sine * axis[1]), abs(cosine * axis[1] - sine * axis[0])
        deep = length * turn[0] + width * turn[1]
        wide = length * turn[1] + width * turn[0]
        behind = (east - x) * axis[0] + (north - y) * axis[1] - 0.5 * deep
        aside = (north - y) * axis[0] - (east - x) * axis[1]
        slender = np.clip(deep / rise, 0.3, 3.0) ** 0.3
        cavity = 1.8 * wide / (slender * (1.0 + 0.24 * wide / rise))
        end = cavity * np.sqrt(
            np.maximum(1.0 - (2.0 * aside / wide) ** 2, 0.0)
            * np.maximum(1.0 - ((up - foot) / rise) ** 2, 0.0)
        )
        is_lee = (behind > 0.0) & (end > 0.0) & (behind < _WAKE_CAVITIES * end)
        ratio = np.divide(behind, end, out=np.ones(is_lee.shape), where=is_lee)
        # Within the cavity far is 1, so that its power stays finite; `where` picks the cavity's
        # law.
        far = np.maximum(ratio, 1.0)
        wake = np.where(ratio < 1.0, -((1.0 - ratio) ** 2), 1.0 - far**-1.5)
        # Wakes of several blocks do not add up: the slowest air counts.
        np.minimum(along, wake, out=along, where=is_lee)
