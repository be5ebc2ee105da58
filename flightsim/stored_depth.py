"""Depth images in whole millimetres, as recordings and ROS 2 have them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Integer

DEPTH_UNITS_PER_M = 1000.0
"""Depth is stored in whole millimetres, up to `MOST_DEPTH_M`; 0 means nothing seen (REP 118)."""
_LIMIT = np.iinfo(np.uint16).max
MOST_DEPTH_M = _LIMIT / DEPTH_UNITS_PER_M


def depth_to_uint16(depth_m: Float[np.ndarray, "h w"]) -> Integer[np.ndarray, "h w"]:
    """Depth in whole millimetres; 0 where nothing is seen or it is too far to store."""
    millimetres = np.nan_to_num(depth_m, nan=0.0, posinf=0.0, neginf=0.0) * DEPTH_UNITS_PER_M
    is_storable = (millimetres >= 0) & (millimetres <= _LIMIT)
    return np.where(is_storable, np.rint(millimetres), 0).astype(np.uint16)
