"""Place of a scene on Earth, and the plane in which its coordinates are metres.

A scene that does not state its place lies where PX4's simulations do (Zurich), so that scripts with
PX4's default coordinates work unchanged.
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
    """Lengths in m of a degree of latitude and of longitude, in the plane tangent at an origin.

    They follow from the radii of curvature at the origin. Flights and maps both use this plane:
    within 1 km the error stays below 0.2 m.

    Args:
        latitude_deg: Geodetic latitude of the origin, WGS 84.
        altitude_m: Height of the origin.

    Returns:
        North and east length. The second goes to zero at the poles.
    """
    latitude = math.radians(latitude_deg)
    w = 1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2
    meridian_m = _SEMI_MAJOR_AXIS_M * (1.0 - _ECCENTRICITY_SQUARED) / w**1.5
    normal_m = _SEMI_MAJOR_AXIS_M / math.sqrt(w)
    north_m = math.radians(meridian_m + altitude_m)
    east_m = math.radians((normal_m + altitude_m) * math.cos(latitude))
    return north_m, east_m
