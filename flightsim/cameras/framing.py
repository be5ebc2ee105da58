"""Camera framing: the eye position from which all points are visible on a given side."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.types import Vector3, vector3
from flightsim.cameras import look_at

MARGIN = 1.04
"""Scale of the room around the points, 1 for none."""
_LEAST_DISTANCE_M = 1.0
"""Least distance from the eye to the nearest point."""


def frame_points(
    points_enu_m: Float[np.ndarray, "n 3"],
    *,
    azimuth_rad: float,
    elevation_rad: float,
    vertical_fov_rad: float,
    aspect: float,
    margin: float = MARGIN,
) -> tuple[Vector3, Vector3]:
    """Return eye and target of the nearest view that shows all points, centred in the picture.

    A point that lies x to the right of the target and a beyond it is visible from an eye at
    distance d if |x - c| <= t (d + a), where t is the tangent of half the angle of view and c the
    centre. All points together bound c + t d from below and c - t d from above.

    Args:
        points_enu_m: Points to show.
        azimuth_rad: Direction of the eye, counter-clockwise from east.
        elevation_rad: Elevation of the eye above the horizon, below pi/2.
        vertical_fov_rad: Vertical angle of view.
        aspect: Width over height of the picture.
        margin: Room around the points, 1 for none.
    """
    level = math.cos(elevation_rad)
    towards_eye = np.array(
        [level * math.cos(azimuth_rad), level * math.sin(azimuth_rad), math.sin(elevation_rad)]
    )
    # Only the axes of this view count: its distance is found below.
    axes = look_at(vector3(towards_eye), (0.0, 0.0, 0.0), 1.0).rotation_enu_from_optical
    tangents = math.tan(vertical_fov_rad / 2) / margin * np.array([aspect, 1.0])
    origin = points_enu_m.mean(axis=0)
    local = (points_enu_m - origin) @ axes
    across, beyond = local[:, :2], local[:, 2:]
    highest = (across - tangents * beyond).max(axis=0)
    lowest = (across + tangents * beyond).min(axis=0)
    # The wider of both axes decides, but no point may come too near.
    distance_m = max(
        float(((highest - lowest) / (2 * tangents)).max()), _LEAST_DISTANCE_M - float(beyond.min())
    )
    target = origin + axes[:, :2] @ ((highest + lowest) / 2)
    return vector3(target + distance_m * towards_eye), vector3(target)
