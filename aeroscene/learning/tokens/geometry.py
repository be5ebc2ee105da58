"""Geometry of a list of objects in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Geometry:
    """World geometry of a skeleton's tokens, the site first: its ground plan and air above."""

    center_enu_m: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    size_m: Float[np.ndarray, "n 3"]
    openings_m: Float[np.ndarray, "n 7"]
    """NaN where an object has no such opening."""
