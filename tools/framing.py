"""Where to put the eye so that everything is in the picture."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from flightsim.sensors.camera import look_at

Point = tuple[float, float, float]


def fit_view(
    points_enu_m: Float[np.ndarray, "n 3"],
    *,
    azimuth_deg: float,
    elevation_deg: float,
    vertical_fov_deg: float,
    aspect: float,
    margin: float = 1.06,
) -> tuple[Point, Point]:
    """Eye and target of the nearest view from a direction that shows all points.

    Args:
        points_enu_m: What must be seen.
        azimuth_deg: Where the eye stands, counter-clockwise from east of the points.
        elevation_deg: How high the eye stands, up to 90.
        vertical_fov_deg: Of the camera.
        aspect: Width by height of the picture.
        margin: Room around the points, 1 for none.
    """
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    outward = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
    tan_v = math.tan(math.radians(vertical_fov_deg) / 2) / margin
    tan_h = tan_v * aspect
    target = (points_enu_m.min(axis=0) + points_enu_m.max(axis=0)) / 2
    distance_m = 1.0
    # The middle of the picture settles within a few rounds.
    for _ in range(6):
        view = look_at(as_point(target + outward), as_point(target), 1.0)
        right, down, forward = view.rotation_enu_from_optical.T
        local = (points_enu_m - target) @ np.stack([right, down, forward], axis=1)
        distance_m = max(
            float(np.max(np.abs(local[:, 0]) / tan_h - local[:, 2])),
            float(np.max(np.abs(local[:, 1]) / tan_v - local[:, 2])),
        )
        depth = distance_m + local[:, 2]
        x, y = local[:, 0] / depth, local[:, 1] / depth
        target = target + distance_m * (
            right * (x.min() + x.max()) / 2 + down * (y.min() + y.max()) / 2
        )
    return as_point(target + distance_m * outward), as_point(target)


def as_point(values: np.ndarray) -> Point:
    """Three plain numbers."""
    x, y, z = values.tolist()
    return (x, y, z)
