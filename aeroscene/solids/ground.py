"""The ground of a relief as cells of a grid, and as plane patches.

Cells are for the distance field. Patches are for what asks about planes, such as landing areas and
the planner's obstacles: gentle ground then takes dozens of solids instead of thousands of
triangles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.scene import Relief
from aeroscene.solids.voxels import Grid

_TOUCH_M = 1e-6
"""Depth up to which ground may reach into a cell without occupying it."""
_LARGEST = 16
"""Cells along the side of the largest patch; a power of two."""

Bounds = tuple[float, float, float, float]
"""Least east and north, greatest east and north, m."""


def ground_cells(relief: Relief, grid: Grid) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells that the ground may reach into.

    The result is a superset of the truth: over a column the ground rises above its middle by at
    most its local slope times half of the column's width.

    Args:
        relief: Heights of the ground.
        grid: Cells.
    """
    x, y, z = grid.centres(tuple(slice(0, n) for n in grid.shape))  # pyrefly: ignore[bad-argument-type]
    half_m = grid.resolution_m / 2
    top_m = relief.height_m(x[:, None], y[None, :]) + half_m * _steepness(relief, x, y, half_m)
    return top_m[:, :, None] > z - half_m + _TOUCH_M


def _steepness(
    relief: Relief, x: np.ndarray, y: np.ndarray, half_m: float
) -> Float[np.ndarray, "nx ny"]:
    """Greatest |rise to the east| + |rise to the north| in the columns about places."""
    # Start-up time: SciPy takes a seventh of that of a flight, and few scenes have a relief.
    from scipy import ndimage

    east, north = (np.abs(gradient).max(axis=0) for gradient in relief.gradients())
    # A column may straddle several cells of the relief: the steepest of all of them counts.
    reach = 2 * math.ceil(half_m / relief.spacing_m) + 1
    steepest = ndimage.maximum_filter(east + north, size=reach, mode="nearest")
    column, row = (
        np.clip((places - start) / relief.spacing_m, 0, n - 1).astype(int)
        for places, start, n in zip(
            (x, y), relief.origin_enu_m, reversed(steepest.shape), strict=True
        )
    )
    return steepest[row[None, :], column[:, None]]


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Nearly plane pieces of the ground that together cover it: squares, and halves of cells."""

    corners_enu_m: tuple[Float[np.ndarray, "k 2"], ...]
    """Corners of each patch seen from above, counter-clockwise."""
    gradient: Float[np.ndarray, "n 2"]
    """Rise of each patch's plane towards east and north."""
    height_at_origin_m: Float[np.ndarray, " n"]
    """Height of each plane over the origin."""
    above_m: Float[np.ndarray, " n"]
    """Greatest height of the ground above the plane."""

    def __len__(self) -> int:
        return len(self.gradient)


def ground_patches(relief: Relief, bounds: Bounds, tolerance_m: float) -> Patches:
    """Divide the ground about a rectangle into patches as large as the tolerance allows.

    Squares of cells are halved until each lies near a plane. A single cell that does not becomes
    two triangles, which are plane.

    Args:
        relief: Heights of the ground.
        bounds: Rectangle that the patches cover.
        tolerance_m: Greatest vertical distance of the ground from a patch's plane.
    """
    x, y, heights = _nodes_about(relief, bounds)
    n_rows, n_columns = heights.shape[0] - 1, heights.shape[1] - 1
    is_left = np.ones((n_rows, n_columns), dtype=bool)
    corners: list[np.ndarray] = []
    planes: list[np.ndarray] = []
    side = _LARGEST
    while side:
        row, column, plane, off_m = _fitted(x, y, heights, side)
        is_whole = is_left[row, column] & (off_m.max(axis=1) <= tolerance_m)
        for r, c in zip(row[is_whole].tolist(), column[is_whole].tolist(), strict=True):
            is_left[r : r + side, c : c + side] = False
            corners.append(_square(x, y, r, c, side))
        planes.append(np.column_stack([plane, off_m[:, 1]])[is_whole])
        # 16, 8, 4, 2, 1, then 0 ends the loop; cells that are left over become triangles.
        side //= 2
    for r, c in np.argwhere(is_left).tolist():
        square = _square(x, y, r, c, 1)
        corners += [square[[0, 1, 2]], square[[0, 2, 3]]]
    planes.append(_halves(relief, x, y, heights, np.argwhere(is_left)))
    joined = np.concatenate(planes)
    return Patches(tuple(corners), joined[:, :2], joined[:, 2], joined[:, 3])


def _nodes_about(relief: Relief, bounds: Bounds) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """East, north and heights of the nodes of whole largest squares that cover a rectangle."""
    step_m, lines = relief.spacing_m, []
    for low, high, start in zip(bounds[:2], bounds[2:], relief.origin_enu_m, strict=True):
        # The small terms keep a border that lies on a node from adding a row of squares.
        first = math.floor((low - start) / step_m + 1e-9)
        n = math.ceil((high - start) / step_m - 1e-9) - first
        n = _LARGEST * max(1, math.ceil(n / _LARGEST))
        lines.append(start + step_m * np.arange(first, first + n + 1))
    x, y = lines
    return x, y, relief.height_m(x[None, :], y[:, None])


def _fitted(
    x: np.ndarray, y: np.ndarray, heights: np.ndarray, side: int
) -> tuple[Int[np.ndarray, " b"], Int[np.ndarray, " b"], np.ndarray, np.ndarray]:
    """Least squares planes of all squares of a side: first row and column, plane, deviations.

    Returns:
        Row and column of each square's first cell; gradient and height at the origin (b, 3);
        greatest height of the plane above the ground and of the ground above the plane (b, 2).
    """
    windows = np.lib.stride_tricks.sliding_window_view(heights, (side + 1, side + 1))
    blocks = windows[::side, ::side]
    row, column = (side * index.ravel() for index in np.indices(blocks.shape[:2]))
    blocks = blocks.reshape(-1, side + 1, side + 1)
    step_m = float(x[1] - x[0])
    # Coordinates about the square's middle sum to zero, so that east, north and mean are
    # independent.
    along = step_m * (np.arange(side + 1) - side / 2)
    square_sum = (side + 1) * float((along**2).sum())
    east = np.einsum("bij,j->b", blocks, along) / square_sum
    north = np.einsum("bij,i->b", blocks, along) / square_sum
    mean = blocks.mean(axis=(1, 2))
    plane = (
        mean[:, None, None] + east[:, None, None] * along + north[:, None, None] * along[:, None]
    )
    off = blocks - plane
    middle_x, middle_y = x[column] + step_m * side / 2, y[row] + step_m * side / 2
    at_origin = mean - east * middle_x - north * middle_y
    deviation = np.stack([-off.min(axis=(1, 2)), off.max(axis=(1, 2))], axis=1)
    return row, column, np.stack([east, north, at_origin], axis=1), deviation


def _square(x: np.ndarray, y: np.ndarray, row: int, column: int, side: int) -> np.ndarray:
    west, east, south, north = x[column], x[column + side], y[row], y[row + side]
    return np.array([(west, south), (east, south), (east, north), (west, north)])


def _halves(
    relief: Relief, x: np.ndarray, y: np.ndarray, heights: np.ndarray, cells: np.ndarray
) -> Float[np.ndarray, "n 4"]:
    """Planes of the triangles of each cell: first the south-eastern, then the north-western."""
    row, column = cells.T
    south_west = heights[row, column]
    south_east, north_west = heights[row, column + 1], heights[row + 1, column]
    north_east = heights[row + 1, column + 1]
    # Along the two legs of each triangle: rise towards east, rise towards north.
    lower = south_east - south_west, north_east - south_east
    upper = north_east - north_west, north_west - south_west
    planes = np.zeros((len(cells), 2, 4))
    for half, (east, north) in enumerate((lower, upper)):
        planes[:, half, 0], planes[:, half, 1] = east / relief.spacing_m, north / relief.spacing_m
        rise = planes[:, half, 0] * x[column] + planes[:, half, 1] * y[row]
        planes[:, half, 2] = south_west - rise
    return planes.reshape(-1, 4)
