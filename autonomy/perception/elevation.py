"""Elevation map: depth images, levelled by the estimated attitude, fused on a grid in ENU.

A cell keeps the mean height of the surface seen in it, averaged over frames with a bounded memory,
and its highest and lowest points, which new frames move outwards at once and inwards slowly: a
thin pole seen in one frame of several is not averaged away. Before it is fused, a frame is shifted
vertically by the median difference to the map: the estimate's height wanders more between frames
than the ground does. The map as a whole follows the mean of the frames.

A cell that no frame has seen still has a bound: whatever hides there does not break a line of
sight that passed over it. So the ground behind the edge of a table is known not to reach above
the table, while what stands behind a wall may be as high as the wall.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from autonomy.jit import kernel
from autonomy.model.quadrotor import Vector3
from autonomy.perception.depth_image import DepthImage, bound_hidden, steepest_sight

MEMORY_FRAMES = 8
"""A new frame weighs at least one in so many."""
_MIN_COMMON_CELLS = 50
_N_BEARINGS = 512
# Lines of sight that end farther away than this many map widths are as good as endless.
_SIGHT_WIDTHS = 2


class ElevationMap:
    """A square patch of ground.

    Attributes:
        height_m: Mean height of each cell, ENU; rows along north, columns along east, as OpenCV
            and images have it. Without meaning where nothing was seen.
        top_m: Highest point of each cell.
        bottom_m: Lowest point of each cell.
        hidden_m: Bound of the height of each cell by lines of sight over it; inf without one.
        n_frames: In how many frames each cell was seen, 0 for never.
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
        self.hidden_m = np.full((n, n), np.inf, dtype=np.float32)
        self.n_frames = np.zeros((n, n), dtype=np.int32)
        self._n_fused = 0

    @property
    def is_observed(self) -> Bool[np.ndarray, "n n"]:
        """Which cells were seen at least once."""
        return self.n_frames > 0

    @property
    def ceiling_m(self) -> Float[np.ndarray, "n n"]:
        """No part of a cell is higher than this: its top where it was seen, else its bound."""
        return np.where(self.is_observed, self.top_m, self.hidden_m)

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

    def cells_within(self, polygon_enu_m: Sequence[Vector3]) -> Bool[np.ndarray, "n n"]:
        """Cells whose centres lie inside a polygon, seen from above."""
        import shapely  # noqa: PLC0415 - loads only where something lands

        outline = shapely.Polygon([vertex[:2] for vertex in polygon_enu_m])
        return shapely.contains_xy(outline, *np.meshgrid(*self.cell_centres()))

    def add(self, image: DepthImage) -> None:
        """Fuse one depth image."""
        points = image.points_enu_m()
        frame = rasterise(points, np.array(self.center_enu_m), self.resolution_m, len(self.top_m))
        hidden = self._bound_hidden(points, np.array(image.position_enu_m), 1.0 / image.fx)
        seen = frame[3] > 0
        self._align(frame[:3], hidden, seen)
        self.n_frames[seen] += 1
        height, top, bottom = (layer[seen] for layer in frame[:3])
        self.height_m[seen] += (height - self.height_m[seen]) / self._frames_counted(seen)
        self._stretch(self.top_m, top, seen, np.maximum)
        self._stretch(self.bottom_m, bottom, seen, np.minimum)
        np.minimum(self.hidden_m, hidden, out=self.hidden_m)
        self._n_fused += 1

    def _bound_hidden(self, points: np.ndarray, eye: np.ndarray, pixel_rad: float) -> np.ndarray:
        n_steps = _SIGHT_WIDTHS * len(self.height_m)
        fall = steepest_sight(points, eye, pixel_rad, self.resolution_m, _N_BEARINGS, n_steps)
        return bound_hidden(fall, eye, self.resolution_m, *self.cell_centres())

    def _align(
        self, layers: Sequence[np.ndarray], hidden: np.ndarray, seen: Bool[np.ndarray, "n n"]
    ) -> None:
        """Bring a frame and the map to the mean of their heights, each by its weight."""
        common = seen & self.is_observed
        if np.count_nonzero(common) < _MIN_COMMON_CELLS:
            return
        shift = float(np.median(layers[0][common] - self.height_m[common]))
        follow = shift / min(self._n_fused + 1, MEMORY_FRAMES)
        for new in (*layers, hidden):
            np.subtract(new, shift - follow, out=new)
        for old in (self.height_m, self.top_m, self.bottom_m, self.hidden_m):
            np.add(old, follow, out=old)

    def _frames_counted(self, seen: np.ndarray) -> np.ndarray:
        return np.minimum(self.n_frames[seen], MEMORY_FRAMES).astype(np.float32)

    def _stretch(
        self, layer: np.ndarray, new: np.ndarray, seen: np.ndarray, outer: np.ufunc
    ) -> None:
        """Take a new extreme at once and let go of an old one slowly."""
        old = layer[seen]
        kept = np.where(self.n_frames[seen] > 1, old + (new - old) / MEMORY_FRAMES, new)
        layer[seen] = outer(new, kept)


@kernel
def rasterise(
    points: Float[np.ndarray, "k 3"], center: Float[np.ndarray, " 3"], resolution: float, n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Mean, maximum, minimum and number of the heights of the points in each cell."""
    mean = np.zeros((n, n))
    top = np.full((n, n), -np.inf)
    bottom = np.full((n, n), np.inf)
    count = np.zeros((n, n), dtype=np.int32)
    middle = n // 2 + 0.5
    for k in range(len(points)):
        column = int(np.floor((points[k, 0] - center[0]) / resolution + middle))
        row = int(np.floor((points[k, 1] - center[1]) / resolution + middle))
        if 0 <= row < n and 0 <= column < n:
            height = points[k, 2]
            mean[row, column] += height
            top[row, column] = max(top[row, column], height)
            bottom[row, column] = min(bottom[row, column], height)
            count[row, column] += 1
    for row in range(n):
        for column in range(n):
            mean[row, column] /= max(count[row, column], 1)
    return mean, top, bottom, count
