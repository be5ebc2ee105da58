"""Local wind over the open wind, on a grid over a scene.

Each cell holds the velocity for an open wind of 1 m/s. Speed and gusts then only scale the field,
and it is solved once for each direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.scene.catalogue import BLOCKS
from aeroscene.scene.relief import ground_m
from aeroscene.solids.rectangles import rectangles_of
from autonomy.jit import kernel
from flightsim.environment.shelter.mass_consistent import mass_consistent
from flightsim.environment.shelter.wakes import BLOCK_COLUMNS, add_wakes

_CELL_M = 2.0
_MARGIN_M = 12.0
"""Margin of the grid around the scene's extent and above its blocks."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells over a scene; the first begins at the origin, on the lowest ground."""

    origin_enu_m: tuple[float, float, float]
    shape: tuple[int, int, int]
    cell_m: float = _CELL_M

    @property
    def centres_m(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """East, north and up of the cells' middles, of shapes that broadcast to the grid's."""
        x, y, z = (
            start + self.cell_m * (np.arange(n) + 0.5)
            for start, n in zip(self.origin_enu_m, self.shape, strict=True)
        )
        return x[:, None, None], y[None, :, None], z[None, None, :]


def blocks_of(scene: Scene) -> Float[np.ndarray, "n 8"]:
    """Return buildings and the like as upright blocks, a row of `BLOCK_COLUMNS` each.

    A block reaches down to the ground, also from a podium or over an arch. A building with an
    outline is several blocks, one about each of its convex pieces.
    """
    rows = [
        (
            *middle,
            math.cos(yaw),
            math.sin(yaw),
            *sides,
            thing.bbox.p[2] + 0.5 * thing.bbox.s[2],
            float(ground_m(scene.relief, *middle)),
        )
        for thing in scene.objects
        if thing.category in BLOCKS
        for middle, yaw, sides in rectangles_of(thing)
    ]
    return np.array(rows, dtype=float).reshape(-1, len(BLOCK_COLUMNS))


def grid_for(scene: Scene, blocks: Float[np.ndarray, "n 8"]) -> Grid:
    """Return the grid over a scene, up to above its blocks and its relief.

    It is a single cell if the scene has neither.
    """
    west, south, _ = scene.extent_min_enu_m
    relief = scene.relief
    if len(blocks) == 0 and relief is None:
        return Grid((west, south, 0.0), (1, 1, 1))
    low_m, high_m = (0.0, 0.0) if relief is None else (relief.min_m, relief.max_m)
    sides = np.subtract(scene.extent_max_enu_m[:2], (west, south)) + 2.0 * _MARGIN_M
    height_m = float(blocks[:, 6].max(initial=high_m)) - low_m + _MARGIN_M
    nx, ny, nz = (math.ceil(side / _CELL_M) for side in (*sides, height_m))
    return Grid((west - _MARGIN_M, south - _MARGIN_M, low_m), (nx, ny, nz))


def ground_below(scene: Scene, grid: Grid) -> Float[np.ndarray, "nx ny"]:
    """Return the height of the ground below the middles of a grid's columns, m."""
    east, north, _ = grid.centres_m
    return ground_m(scene.relief, east[..., 0], north[..., 0])


def solve_shelter(
    grid: Grid,
    blocks: Float[np.ndarray, "n 8"],
    ground_below_m: Float[np.ndarray, "nx ny"],
    axis: tuple[float, float],
) -> Float[np.ndarray, "nx ny nz 3"]:
    """Return the velocity of the air in each cell for an open wind of 1 m/s.

    Args:
        grid: Grid over the scene.
        blocks: Rows of `BLOCK_COLUMNS`.
        ground_below_m: Height of the ground below each column.
        axis: Horizontal unit vector along which the wind blows.
    """
    along = np.ones(grid.shape)
    add_wakes(along, grid.centres_m, blocks, axis)
    is_solid = _solid(grid, blocks) | (grid.centres_m[2] < ground_below_m[..., None])
    along[is_solid] = 0.0
    guess = np.stack([along * axis[0], along * axis[1], np.zeros(grid.shape)], axis=-1)
    return mass_consistent(guess, is_solid)


def _solid(grid: Grid, blocks: np.ndarray) -> np.ndarray:
    """Cells whose middle lies in a block."""
    east, north, up = grid.centres_m
    is_solid = np.zeros(grid.shape, dtype=bool)
    for x, y, cosine, sine, length, width, top, _ in blocks:
        dx, dy = east - x, north - y
        along, across = np.abs(cosine * dx + sine * dy), np.abs(cosine * dy - sine * dx)
        is_solid |= (along < 0.5 * length) & (across < 0.5 * width) & (up < top)
    return is_solid


@kernel
def flow_at(
    field: np.ndarray,
    origin_enu_m: np.ndarray,
    cell_m: float,
    position: np.ndarray,
    out: np.ndarray,
) -> bool:
    """Interpolate a field at a position; false beyond the grid's outermost middles.

    Below the middle of the lowest cells it is theirs.

    Args:
        field: Velocities in the middle of cells (nx, ny, nz, 3).
        origin_enu_m: Corner of the first cell (3,).
        cell_m: Edge of a cell.
        position: The position (3,).
        out: Velocity there (3,), written.
    """
    nx, ny, nz = field.shape[0], field.shape[1], field.shape[2]
    # Coordinates count from the middle of the first cell.
    a = (position[0] - origin_enu_m[0]) / cell_m - 0.5
    b = (position[1] - origin_enu_m[1]) / cell_m - 0.5
    c = max((position[2] - origin_enu_m[2]) / cell_m - 0.5, 0.0)
    if not (0.0 <= a < nx - 1 and 0.0 <= b < ny - 1 and c < nz - 1):
        return False
    base = (int(a), int(b), int(c))
    share = (a - base[0], b - base[1], c - base[2])
    for m in range(3):
        total = 0.0
        for i in range(2):
            wx = share[0] if i == 1 else 1.0 - share[0]
            for j in range(2):
                wy = share[1] if j == 1 else 1.0 - share[1]
                for k in range(2):
                    wz = share[2] if k == 1 else 1.0 - share[2]
                    total += wx * wy * wz * field[base[0] + i, base[1] + j, base[2] + k, m]
        out[m] = total
    return True
