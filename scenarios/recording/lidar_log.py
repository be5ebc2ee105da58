"""Scans of a lidar in a recording: points on the vehicle, coloured by their distance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
from jaxtyping import Float, UInt8

from scenarios.recording import layout
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    # Reading a recording should not load the simulator.
    from flightsim.lidars import LidarScan

_FAR_M = 40.0
"""Distance from which on all points have the last colour."""


def log_scan(stream: EntityStream, scan: LidarScan) -> None:
    """Write a scan at the stream's present time.

    Args:
        stream: Stream of the vehicle.
        scan: Scan, whose points are body FLU. The viewer places them by the vehicle's pose.
    """
    points = rr.Points3D(
        scan.points_flu_m.astype(np.float32),
        # Rays that met nothing have an infinite range, and no point.
        colors=_colours(scan.range_m[np.isfinite(scan.range_m)]),
        radii=rr.Radius.ui_points(1.2),
    )
    stream.log(layout.LIDAR, points)


def _colours(range_m: Float[np.ndarray, " n"]) -> UInt8[np.ndarray, "n 3"]:
    """Return colours from blue (near) to red (far)."""
    import cv2

    levels = (255.0 * np.minimum(range_m / _FAR_M, 1.0)).astype(np.uint8)
    if not len(levels):
        return np.zeros((0, 3), dtype=np.uint8)
    # OpenCV's colours are blue, green, red.
    return cv2.applyColorMap(levels[:, None], cv2.COLORMAP_TURBO)[:, 0, ::-1]
