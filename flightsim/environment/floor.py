"""Floor plan of a scene in cells: room to walk, drive or fly at one height.

A column's floor is the top of its solid part from the ground up, relief included. An obstacle is
anything above it within the mover's height, or a step to the next column. A cell is occupied if
anything may reach into it, so distances to obstacles are never overestimated.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
import shapely
from jaxtyping import Bool, Float

from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.footprint import footprint
from aeroscene.scene.outline import OUTLINE
from aeroscene.solids.freespace import distance_to_occupied
from aeroscene.solids.ground import ground_cells
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.voxels import Grid, voxelise

CELL_M = 0.25
CLEARANCE_CAP_M = 3.0
_HIGHEST_FLOOR_M = 1.6  # a roof or a shelf higher than this is no floor
_STEP_M = 0.3  # steps up to this height are walked and driven over


@dataclass(frozen=True, eq=False)
class Columns:
    """Solids of a scene in cells, from the lowest flight height up to a few metres."""

    grid: Grid
    occupied: Bool[np.ndarray, "nx ny nz"]
    ground_m: Float[np.ndarray, "nx ny"]
    """Height of the ground, overestimated by up to one cell."""

    @classmethod
    def from_scene(cls, scene: Scene, solids: Iterable[Primitive], height_m: float) -> Columns:
        """Voxelise ground and solids up to a height above the scene's highest ground.

        Args:
            scene: The scene, for its extent and its relief.
            solids: Its static solids.
            height_m: Height of the cells above the highest ground.
        """
        low = np.array(scene.extent_min_enu_m)
        span = np.array(scene.extent_max_enu_m) - low
        nx, ny = (max(1, ceil(s / CELL_M - 1e-6)) for s in span[:2].tolist())
        x, y, z = (low + CELL_M / 2).tolist()
        relief = scene.relief
        rise_m = 0.0 if relief is None else relief.max_m - float(low[2])
        grid = Grid((x, y, z), CELL_M, (nx, ny, ceil((rise_m + height_m) / CELL_M)))
        occupied, ground_m = voxelise(solids, grid), np.full((nx, ny), low[2])
        if relief is not None:
            ground = ground_cells(relief, grid)
            occupied |= ground
            ground_m += CELL_M * ground.sum(axis=2)
        return cls(grid, occupied, ground_m)

    @property
    def centres_enu_m(self) -> tuple[Float[np.ndarray, "nx 1"], Float[np.ndarray, "1 ny"]]:
        """Coordinates of the columns' centres, east and north, of shapes that broadcast."""
        nx, ny, _ = self.grid.shape
        x0, y0, _ = self.grid.origin_enu_m
        return (x0 + CELL_M * np.arange(nx)[:, None], y0 + CELL_M * np.arange(ny)[None, :])

    def floor(self, height_m: float) -> Floor:
        """Return the room for movers of this height on the lowest floors."""
        full = self.occupied.all(axis=2)
        # Lowest free cell of each column. argmin finds the first False; a full column has none.
        layer = np.where(full, self.occupied.shape[2], np.argmin(self.occupied, axis=2))
        # Cells are counted from their centres: half a cell lower lies the bottom of the first.
        bottom_m = self.grid.origin_enu_m[2] - CELL_M / 2
        level_m = bottom_m + CELL_M * layer
        filled = np.concatenate(
            [np.zeros((*layer.shape, 1), int), np.cumsum(self.occupied, axis=2)], axis=2
        )
        # A prefix sum per column answers "is anything solid between these layers" in one
        # difference.
        top = np.minimum(layer + ceil(height_m / CELL_M), self.occupied.shape[2])
        at_floor = np.take_along_axis(filled, layer[..., None], axis=2)[..., 0]
        in_band = np.take_along_axis(filled, top[..., None], axis=2)[..., 0] - at_floor
        blocked = full | (in_band > 0) | (level_m - self.ground_m > _HIGHEST_FLOOR_M)
        return Floor(self, level_m, _clearance_m(blocked | _is_at_step(level_m)))

    def layer(self, bottom_m: float, height_m: float) -> Floor:
        """Return the room for movers that fly between two heights.

        Args:
            bottom_m: ENU height of their underside.
            height_m: Their own height.
        """
        base_m = self.grid.origin_enu_m[2] - CELL_M / 2
        first = max(0, int((bottom_m - base_m) / CELL_M))
        last = ceil((bottom_m + height_m - base_m) / CELL_M)
        blocked = np.any(self.occupied[:, :, first:last], axis=2)
        level_m = np.full(blocked.shape, bottom_m)
        return Floor(self, level_m, _clearance_m(blocked))

    def covered_by(self, objects: Sequence[SceneObject]) -> Bool[np.ndarray, "nx ny"]:
        """Return the columns whose centre lies in the footprint of any of the objects."""
        x, y = self.centres_enu_m
        inside = np.zeros(self.grid.shape[:2], dtype=bool)
        for obj in objects:
            if OUTLINE in obj.attributes:
                inside |= shapely.contains_xy(footprint(obj), x, y)
                continue
            yaw = obj.bbox.yaw_rad
            dx, dy = x - obj.bbox.p[0], y - obj.bbox.p[1]
            u = np.cos(yaw) * dx + np.sin(yaw) * dy
            v = np.cos(yaw) * dy - np.sin(yaw) * dx
            inside |= (np.abs(u) <= obj.bbox.s[0] / 2) & (np.abs(v) <= obj.bbox.s[1] / 2)
        return inside


@dataclass(frozen=True, eq=False)
class Floor:
    """Room to move on one level, per column."""

    columns: Columns
    level_m: Float[np.ndarray, "nx ny"]
    """Height of the floor, overestimated by up to one cell."""
    clearance_m: Float[np.ndarray, "nx ny"]
    """Horizontal distance from a column's centre to the nearest obstacle, capped."""

    def cells(self, points_enu_m: Float[np.ndarray, "n _"]) -> tuple[np.ndarray, np.ndarray]:
        """Return indexes of the columns of points; points outside take the nearest column."""
        grid = self.columns.grid
        index = np.rint((points_enu_m[:, :2] - np.array(grid.origin_enu_m[:2])) / CELL_M)
        i, j = np.clip(index.astype(int), 0, np.array(grid.shape[:2]) - 1).T
        return i, j


def _is_at_step(level_m: np.ndarray) -> Bool[np.ndarray, "nx ny"]:
    """Columns beside one whose floor differs in height by more than a step."""
    is_step = np.zeros(level_m.shape, dtype=bool)
    x = np.abs(np.diff(level_m, axis=0)) > _STEP_M
    y = np.abs(np.diff(level_m, axis=1)) > _STEP_M
    is_step[:-1] |= x
    is_step[1:] |= x
    is_step[:, :-1] |= y
    is_step[:, 1:] |= y
    return is_step


def _clearance_m(blocked: Bool[np.ndarray, "nx ny"]) -> Float[np.ndarray, "nx ny"]:
    """Distances to obstacles, including the border of the scene, m."""
    # The border is an obstacle: movers stay in the scene.
    rimmed = np.pad(blocked, 1, constant_values=True)
    distance = distance_to_occupied(rimmed[:, :, None], CELL_M, CLEARANCE_CAP_M)
    return distance[1:-1, 1:-1, 0]
