"""Elevation map: depth images, levelled by the estimated attitude, fused on a grid in ENU.

A cell keeps the mean height of the surface seen in it and the highest and lowest points, each
averaged over frames with a bounded memory. Before it is fused, a frame is shifted vertically by
the median difference to the map: the estimate's height wanders more between frames than the
ground does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from autonomy.jit import kernel
from autonomy.model.quadrotor import Vector3

MEMORY_FRAMES = 8
"""A new frame weighs at least one in so many."""
_MIN_COMMON_CELLS = 50


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthImage:
    """A depth image and where the vehicle believes it was taken.

    Pixel (column u, row v) looks along ((u - cx) / fx, (v - cy) / fy, 1), optical frame: x right,
    y down, z forward.
    """

    depth_m: Float[np.ndarray, "height width"]
    """Along the optical axis; inf or NaN where nothing was measured."""
    fx: float
    fy: float
    cx: float
    cy: float
    position_enu_m: Vector3
    rotation_enu_from_optical: Float[np.ndarray, "3 3"]


class ElevationMap:
    """A square patch of ground.

    Attributes:
        height_m: Mean height of each cell, ENU; rows along north, columns along east, as OpenCV
            and images have it. Zero where nothing was seen.
        top_m: Highest point of each cell.
        bottom_m: Lowest point of each cell.
        n_frames: In how many frames each cell was seen, 0 for never.
        is_in_view: Which cells lay within the field of view at the height of `center_enu_m`,
            even if what is there was hidden by something nearer.
    """

    def __init__(
        self, center_enu_m: Vector3, *, half_extent_m: float = 3.0, resolution_m: float = 0.05
    ) -> None:
        n = 2 * round(half_extent_m / resolution_m) + 1
        self.center_enu_m = center_enu_m
        self.resolution_m = resolution_m
        self.height_m = np.zeros((n, n), dtype=np.float32)
        self.top_m = np.zeros((n, n), dtype=np.float32)
        self.bottom_m = np.zeros((n, n), dtype=np.float32)
        self.n_frames = np.zeros((n, n), dtype=np.int32)
        self.is_in_view = np.zeros((n, n), dtype=bool)

    @property
    def is_observed(self) -> Bool[np.ndarray, "n n"]:
        """Which cells were seen at least once."""
        return self.n_frames > 0

    def cell_centres(self) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """East coordinates of the columns and north coordinates of the rows, ENU, m."""
        n = len(self.height_m)
        offset = (np.arange(n) - n // 2) * self.resolution_m
        return self.center_enu_m[0] + offset, self.center_enu_m[1] + offset

    def cell(self, east_m: float, north_m: float) -> tuple[int, int]:
        """Row and column of a place; outside the patch they lie outside its shape."""
        n = len(self.height_m)
        column = round((east_m - self.center_enu_m[0]) / self.resolution_m) + n // 2
        row = round((north_m - self.center_enu_m[1]) / self.resolution_m) + n // 2
        return row, column

    def add(self, image: DepthImage) -> None:
        """Fuse one depth image."""
        n = len(self.height_m)
        total, top, bottom, count = rasterise(
            np.ascontiguousarray(image.depth_m, dtype=np.float32),
            np.array([image.fx, image.fy, image.cx, image.cy]),
            np.array(image.position_enu_m),
            np.ascontiguousarray(image.rotation_enu_from_optical, dtype=float),
            np.array(self.center_enu_m),
            self.resolution_m,
            n,
        )
        seen = count > 0
        height = total / np.maximum(count, 1)
        common = seen & self.is_observed
        if np.count_nonzero(common) >= _MIN_COMMON_CELLS:
            shift = float(np.median(height[common] - self.height_m[common]))
        else:
            shift = 0.0
        self.n_frames[seen] += 1
        weight = 1.0 / np.minimum(self.n_frames[seen], MEMORY_FRAMES)
        for layer, new in ((self.height_m, height), (self.top_m, top), (self.bottom_m, bottom)):
            layer[seen] += weight * (new[seen] - shift - layer[seen])
        self._mark_view(image)

    def _mark_view(self, image: DepthImage) -> None:
        import cv2  # noqa: PLC0415 - loads only where something lands

        rows, columns = image.depth_m.shape
        corners = np.array([(0, 0), (columns - 1, 0), (columns - 1, rows - 1), (0, rows - 1)])
        rays = np.column_stack(
            [
                (corners[:, 0] - image.cx) / image.fx,
                (corners[:, 1] - image.cy) / image.fy,
                np.ones(4),
            ]
        )
        rays = rays @ image.rotation_enu_from_optical.T
        fall_m = image.position_enu_m[2] - self.center_enu_m[2]
        if fall_m <= 0 or np.any(rays[:, 2] > -1e-3):
            return
        points = np.array(image.position_enu_m) - rays * (fall_m / rays[:, 2:])
        n = len(self.height_m)
        pixels = (points[:, :2] - self.center_enu_m[:2]) / self.resolution_m + n // 2
        view = np.zeros((n, n), dtype=np.uint8)
        cv2.fillConvexPoly(view, np.rint(pixels).astype(np.int32), 1)
        self.is_in_view |= view.astype(bool)


@kernel
def rasterise(
    depth: Float[np.ndarray, "h w"],
    intrinsics: Float[np.ndarray, "4"],
    position: Float[np.ndarray, "3"],
    rotation: Float[np.ndarray, "3 3"],
    center: Float[np.ndarray, "3"],
    resolution: float,
    n: Int[np.ndarray, ""],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Sum, maximum, minimum and number of the heights of a depth image's points in each cell."""
    total = np.zeros((n, n), dtype=np.float32)
    top = np.full((n, n), -np.inf, dtype=np.float32)
    bottom = np.full((n, n), np.inf, dtype=np.float32)
    count = np.zeros((n, n), dtype=np.int32)
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    for v in range(depth.shape[0]):
        y = (v - cy) / fy
        for u in range(depth.shape[1]):
            d = depth[v, u]
            if not (0.0 < d < np.inf):
                continue
            x = (u - cx) / fx
            e = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2]
            w = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2]
            h = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2]
            column = int(np.floor((position[0] + d * e - center[0]) / resolution + n // 2 + 0.5))
            row = int(np.floor((position[1] + d * w - center[1]) / resolution + n // 2 + 0.5))
            if 0 <= row < n and 0 <= column < n:
                height = np.float32(position[2] + d * h)
                total[row, column] += height
                top[row, column] = max(top[row, column], height)
                bottom[row, column] = min(bottom[row, column], height)
                count[row, column] += 1
    return total, top, bottom, count
