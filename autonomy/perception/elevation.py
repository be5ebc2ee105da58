"""Elevation map: depth images, levelled by the estimated attitude, fused on a grid in ENU.

A landing needs heights to a centimetre, and one image from 4 m is not that good. A cell keeps the
mean height of the surface seen in it, each frame weighted by the accuracy at its range, with a
bounded memory. It also keeps the variance of that mean: by the noise of depth, estimated from each
image, or by the disagreement of the frames, whichever is worse. So frames from nearby, on the way
down, soon outweigh those from above.

The highest and lowest points of a cell count as far as noise cannot have made them, and only if
three points of a frame agree. Then they move outwards at once and inwards slowly. A thin pole seen
in one frame of several is therefore not averaged away, and a pixel matched with something else
altogether moves nothing.

Before it is fused, a frame is shifted vertically by the median difference to the map, because the
estimate's height wanders more between frames than the ground does. The map as a whole follows the
mean of the frames.

A cell that no frame has seen still has a bound once two frames agree: anything hidden there does
not break a line of sight that passed over it. So the ground behind the edge of a table is known not
to reach above the table, while an object behind a wall may be as high as the wall.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage, bound_hidden, steepest_sight
from autonomy.perception.rasterise import OUTLYING_SIGMAS, rasterise
from autonomy.types import Vector3

MEMORY_FRAMES = 12
"""Length of the memory: a new frame of the same quality has a weight of at least one in this
number."""
_MIN_COMMON_CELLS = 50  # fewer give no trustworthy median
_N_BEARINGS = 512
# Lines of sight that end farther away than this many map widths count as endless.
_SIGHT_WIDTHS = 2


class ElevationMap:
    """A square patch of ground.

    Args:
        center_enu_m: Middle of the patch; heights near it lose least to rounding.
        half_extent_m: Half the width of the patch.
        resolution_m: Width of a cell.

    Attributes:
        height_m: Mean height of each cell, ENU; rows along north, columns along east, as OpenCV and
            images have it. Meaningless if nothing was seen.
        top_m: Highest point of each cell.
        bottom_m: Lowest point of each cell.
        hidden_m: Upper bound of the height of each cell by lines of sight over it in two frames;
            inf without.
        n_frames: Number of frames in which each cell was seen.
        variance_m2: Variance of the mean height of each cell; inf if nothing was seen.
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
        self.variance_m2 = np.full((n, n), np.inf, dtype=np.float32)
        self._hidden_in_one_m = self.hidden_m.copy()
        self._weight = np.zeros((n, n), dtype=np.float32)
        self._scatter = np.zeros((n, n), dtype=np.float32)
        self._n_fused = 0

    @property
    def is_observed(self) -> Bool[np.ndarray, "n n"]:
        """True for each cell that was seen at least once."""
        return self.n_frames > 0

    @property
    def ceiling_m(self) -> Float[np.ndarray, "n n"]:
        """Upper bound of the height of each cell: its top if it was seen, else `hidden_m`."""
        return np.where(self.is_observed, self.top_m, self.hidden_m)

    def cell_centres(self) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """East coordinates of the columns and north coordinates of the rows, ENU, m."""
        n = len(self.height_m)
        offset = (np.arange(n) - n // 2) * self.resolution_m
        return self.center_enu_m[0] + offset, self.center_enu_m[1] + offset

    def cell(self, east_m: float, north_m: float) -> tuple[int, int]:
        """Row and column of a position; outside the patch they lie outside its shape."""
        n = len(self.height_m)
        column = round((east_m - self.center_enu_m[0]) / self.resolution_m) + n // 2
        row = round((north_m - self.center_enu_m[1]) / self.resolution_m) + n // 2
        return row, column

    def cells_within(self, polygon_enu_m: Sequence[Vector3]) -> Bool[np.ndarray, "n n"]:
        """Return True for each cell whose centre lies inside a polygon, seen from above."""
        import shapely

        outline = shapely.Polygon([vertex[:2] for vertex in polygon_enu_m])
        return shapely.contains_xy(outline, *np.meshgrid(*self.cell_centres()))

    def add(self, image: DepthImage) -> None:
        """Fuse one depth image, posed by the estimate.

        Lone pixels are dropped first; the image itself stays as it is.
        """
        image = image.without_lone_pixels()
        points, eye = image.points_enu_m(), image.pixels.eye
        inverse_sigma = image.inverse_depth_sigma_pm
        n = len(self.height_m)
        frame = rasterise(
            points, np.array(self.center_enu_m), self.resolution_m, n, float(eye[2]), inverse_sigma
        )
        hidden = self._bound_hidden(image.halved(), eye, inverse_sigma)
        self._align(frame, hidden)
        fuse(
            *(self.height_m, self.top_m, self.bottom_m, self.n_frames),
            *(self._weight, self._scatter, self.variance_m2),
            frame,
        )
        # The second lowest bound of all frames: two of them must agree on it.
        second = np.maximum(self._hidden_in_one_m, hidden)
        np.minimum(self.hidden_m, second, out=self.hidden_m)
        np.minimum(self._hidden_in_one_m, hidden, out=self._hidden_in_one_m)
        self._n_fused += 1

    def _bound_hidden(
        self, image: DepthImage, eye: Float[np.ndarray, " 3"], inverse_sigma: float
    ) -> Float[np.ndarray, "n n"]:
        n_steps, step = _SIGHT_WIDTHS * len(self.height_m), self.resolution_m
        points, pixel_rad = image.points_enu_m(), 1.0 / image.fx
        fall = steepest_sight(points, eye, pixel_rad, step, _N_BEARINGS, n_steps, inverse_sigma)
        return bound_hidden(fall, eye, step, *self.cell_centres())

    def _align(self, frame: Float[np.ndarray, "4 n n"], hidden: np.ndarray) -> None:
        """Shift a frame and the map to the weighted mean of their heights."""
        common = (frame[3] > 0) & self.is_observed
        if np.count_nonzero(common) < _MIN_COMMON_CELLS:
            return
        shift = float(np.median(frame[0][common] - self.height_m[common]))
        follow = shift / min(self._n_fused + 1, MEMORY_FRAMES)
        for new in (*frame[:3], hidden):
            np.subtract(new, shift - follow, out=new)
        old_layers = (self.height_m, self.top_m, self.bottom_m)
        for old in (*old_layers, self.hidden_m, self._hidden_in_one_m):
            np.add(old, follow, out=old)


@kernel
def fuse(
    height: Float[np.ndarray, "n n"],
    top: Float[np.ndarray, "n n"],
    bottom: Float[np.ndarray, "n n"],
    n_frames: np.ndarray,
    weight: Float[np.ndarray, "n n"],
    scatter: Float[np.ndarray, "n n"],
    variance: Float[np.ndarray, "n n"],
    frame: Float[np.ndarray, "4 n n"],
) -> None:
    """Add a frame made by `rasterise` to the layers of a map.

    Top and bottom take a new extreme at once and forget an old one slowly. `weight` is the sum of
    the frames' inverse variances. `scatter` is the sum of their squared differences from the mean
    over their variances. Both fade.
    """
    n = len(height)
    keep = 1.0 - 1.0 / MEMORY_FRAMES
    for row in range(n):
        for column in range(n):
            spread = frame[3, row, column]
            if spread == 0.0:
                continue
            mean, high, low = frame[0, row, column], frame[1, row, column], frame[2, row, column]
            n_frames[row, column] += 1
            if n_frames[row, column] == 1:
                weight[row, column] = 1.0 / spread
                height[row, column], top[row, column], bottom[row, column] = mean, high, low
                variance[row, column] = spread
                continue
            before = mean - height[row, column]
            total = keep * weight[row, column] + 1.0 / spread
            after = height[row, column] + before / (spread * total)
            # Welford's update of the sum of squares: the difference before times the one after.
            scattered = keep * scatter[row, column] + before * (mean - after) / spread
            # Extremes follow the surface only as far as noise explains its movement.
            noise = OUTLYING_SIGMAS * math.sqrt(spread)
            doubt = OUTLYING_SIGMAS / math.sqrt(weight[row, column])
            moved = after - height[row, column]
            rise = top[row, column] - height[row, column] - min(moved + doubt, 0.0)
            sink = height[row, column] - bottom[row, column] + max(moved - doubt, 0.0)
            top[row, column] = after + max(high - noise - after, keep * rise)
            bottom[row, column] = after - max(after - low - noise, keep * sink)
            height[row, column], weight[row, column] = after, total
            scatter[row, column] = scattered
            excess = scattered / (min(n_frames[row, column], MEMORY_FRAMES) - 1)
            variance[row, column] = max(excess, 1.0) / total
