"""Depth images in whole millimetres, as recordings and ROS 2 have them.

A picture of 16-bit numbers is half as large as one of 32-bit metres.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Integer

DEPTH_UNITS_PER_M = 1000.0
"""Units of stored depth, millimetres, in a metre; the value 0 means nothing seen (REP 118)."""
_LIMIT = np.iinfo(np.uint16).max
MOST_DEPTH_M = _LIMIT / DEPTH_UNITS_PER_M
"""Greatest depth that 16 bits can store, 65.535 m."""


def depth_to_uint16(depth_m: Float[np.ndarray, "h w"]) -> Integer[np.ndarray, "h w"]:
    """Return depth in whole millimetres, as uint16.

    Args:
        depth_m: Depth in metres; NaN or infinite where nothing is seen.

    Returns:
        Millimetres; 0 where nothing is seen or it is too far to store.
    """
    millimetres = np.nan_to_num(depth_m, nan=0.0, posinf=0.0, neginf=0.0) * DEPTH_UNITS_PER_M
    is_storable = (millimetres >= 0) & (millimetres <= _LIMIT)
    return np.where(is_storable, np.rint(millimetres), 0).astype(np.uint16)
