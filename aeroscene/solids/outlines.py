"""Outlines of solids seen from above."""

from __future__ import annotations

from typing import cast

import numpy as np
import shapely
from jaxtyping import Float
from shapely.geometry.base import BaseGeometry


def outline_of(points_m: Float[np.ndarray, "n d"]) -> BaseGeometry:
    """Convex hull of points seen from above, whatever their heights; empty without points."""
    if not len(points_m):
        return shapely.Polygon()
    return cast("BaseGeometry", shapely.convex_hull(shapely.multipoints(points_m[:, :2])))
