"""Where an eye must be to see all of something from a given side."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from flightsim.sensors.cameras import look_at

Point = tuple[float, float, float]

MARGIN = 1.04
"""Room around the points, 1 for none."""
_LEAST_DISTANCE_M = 1.0
"""From the eye to what is nearest."""


def frame_points(
    points_enu_m: Float[np.ndarray, "n 3"],
    *,
    azimuth_rad: float,
    elevation_rad: float,
    vertical_fov_rad: float,
    aspect: float,
    margin: float = MARGIN,
) -> tuple[Point, Point]:
    """Eye and target of the nearest view that holds all points, in the middle of the picture.

    A point that lies x to the right of the target and a beyond it is in the picture of an eye at
    distance d if |x - c| <= t (d + a), t being the tangent of half the angle of view and c the
    middle. All points together bound c + t d from below and c - t d from above.

    Args:
        points_enu_m: What must be seen.
        azimuth_rad: Where the eye stands, counter-clockwise from east.
        elevation_rad: How high it stands over the horizon, below pi/2.
        vertical_fov_rad: Of the picture.
        aspect: Width over height of the picture.
        margin: Room around the points, 1 for none.
    """
    level = math.cos(elevation_rad)
    towards_eye = np.array(
        [level * math.cos(azimuth_rad), level * math.sin(azimuth_rad), math.sin(elevation_rad)]
    )
    axes = look_at(_point(towards_eye), (0.0, 0.0, 0.0), 1.0).rotation_enu_from_optical
    tangents = math.tan(vertical_fov_rad / 2) / margin * np.array([aspect, 1.0])
    origin = points_enu_m.mean(axis=0)
    local = (points_enu_m - origin) @ axes
    across, beyond = local[:, :2], local[:, 2:]
    highest = (across - tangents * beyond).max(axis=0)
    lowest = (across + tangents * beyond).min(axis=0)
    distance_m = max(
        float(((highest - lowest) / (2 * tangents)).max()), _LEAST_DISTANCE_M - float(beyond.min())
    )
    target = origin + axes[:, :2] @ ((highest + lowest) / 2)
    return _point(target + distance_m * towards_eye), _point(target)


def _point(values: np.ndarray) -> Point:
    x, y, z = values.tolist()
    return (x, y, z)
