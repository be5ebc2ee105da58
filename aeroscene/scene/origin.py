"""Where on Earth scenes lie, and the plane in which their coordinates are metres.

Scenes that do not say where they are lie where PX4's simulations do (Zurich), so that scripts
written for those fit.
"""

from __future__ import annotations

import math

LATITUDE_DEG = 47.397742
LONGITUDE_DEG = 8.545594
ALTITUDE_M = 488.0

# WGS 84, NGA.STND.0036.
_SEMI_MAJOR_AXIS_M = 6378137.0
_ECCENTRICITY_SQUARED = 6.69437999014e-3


def metres_per_degree(latitude_deg: float, altitude_m: float) -> tuple[float, float]:
    """Lengths of a degree of latitude and of longitude in the plane tangent at an origin, m.

    They follow from the radii of curvature at the origin, which is what flights and maps both go
    by: within 1 km the error stays below 0.2 m.
    """
    latitude = math.radians(latitude_deg)
    w = 1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2
    meridian_m = _SEMI_MAJOR_AXIS_M * (1.0 - _ECCENTRICITY_SQUARED) / w**1.5
    normal_m = _SEMI_MAJOR_AXIS_M / math.sqrt(w)
    north_m = math.radians(meridian_m + altitude_m)
    east_m = math.radians((normal_m + altitude_m) * math.cos(latitude))
    return north_m, east_m
