"""Distance field of a large scene, computed only where a caller asks for it.

A district of 400 m has 400 million cells of 25 cm, and a flight across it needs a tenth of them.
The cells are therefore computed in square tiles of columns, each from the solids around it, with
the same values that `build_distance_field` gives. All other cells stay 0, as if they were occupied,
and their memory is never touched.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.scene import Relief, Scene
from aeroscene.solids.freespace import MAX_DISTANCE_M, VoxelField, distance_to_occupied, field_grid
from aeroscene.solids.ground import ground_cells
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.solids import colliding
from aeroscene.solids.voxels import Grid, voxelise
from autonomy.pages import untouched_zeros

MOST_WHOLE_CELLS = 64_000_000
"""Number of cells up to which the whole field is computed at once. At 25 cm it is 150 x 150 m, 44 m
high.
"""
_TILE = 32
"""Cells along the side of a tile."""
_STRIP = 8
"""Most tiles in a row that are computed together. A margin around them is computed too, so longer
strips cost less, but take more memory.
"""


def is_wide(scene: Scene, resolution_m: float) -> bool:
    """True if a scene has too many cells to compute all of them.

    Args:
        scene: Scene.
        resolution_m: Edge of a cell.
    """
    return math.prod(field_grid(scene, resolution_m).shape) > MOST_WHOLE_CELLS


class WideField:
    """Distances of a scene, in the tiles that were asked for.

    Attributes:
        field: The distances; 0 in cells that were not computed.
        is_built: True for tiles that were computed.
    """

    def __init__(
        self,
        scene: Scene,
        resolution_m: float,
        primitives: Sequence[Primitive],
        cap_m: float = MAX_DISTANCE_M,
    ) -> None:
        """Prepare the field of a scene; nothing is computed yet.

        Args:
            scene: Scene.
            resolution_m: Edge of a cell.
            primitives: The scene's primitives.
            cap_m: Distance at which values are capped; it sets the margin around tiles.
        """
        self._grid = field_grid(scene, resolution_m)
        self._relief: Relief | None = scene.relief
        self._solids = colliding(primitives)
        self._cap_m = cap_m
        # Obstacles farther away than the cap cannot change a distance.
        self._margin = math.ceil(cap_m / resolution_m) + 1
        self.field = VoxelField(
            origin_enu_m=self._grid.origin_enu_m,
            resolution_m=resolution_m,
            distance_m=untouched_zeros(self._grid.shape, np.float32),
        )
        n_tiles = [-(-n // _TILE) for n in self._grid.shape[:2]]
        self.is_built: Bool[np.ndarray, "tx ty"] = np.zeros(n_tiles, dtype=bool)

    def build_about(self, points_enu_m: Float[np.ndarray, "n d"], reach_m: float) -> None:
        """Compute all tiles that come within a distance of some points, seen from above.

        Args:
            points_enu_m: Points, of which the first two coordinates count.
            reach_m: Distance.
        """
        side_m = _TILE * self._grid.resolution_m
        corner = np.array(self._grid.origin_enu_m[:2]) - self._grid.resolution_m / 2
        places = np.unique(np.floor((points_enu_m[:, :2] - corner) * 2 / side_m), axis=0) / 2
        middles = (np.indices(self.is_built.shape).reshape(2, -1).T + 0.5)[:, None]
        # Places are known to half a tile, so that few of them are compared.
        away_m = side_m * np.maximum(np.abs(places + 0.25 - middles) - 0.75, 0.0)
        is_near = (np.hypot(*np.moveaxis(away_m, 2, 0)) <= reach_m).any(axis=1)
        self._build(is_near.reshape(self.is_built.shape) & ~self.is_built)

    def _build(self, wanted: Bool[np.ndarray, "tx ty"]) -> None:
        for row in range(len(wanted)):
            columns = np.flatnonzero(wanted[row])
            # Neighbouring tiles share their margins, so a strip costs less than its tiles one by
            # one.
            for strip in np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1):
                for first in range(0, len(strip), _STRIP):
                    part = strip[first : first + _STRIP]
                    self._build_strip(row, int(part[0]), int(part[-1]) + 1)
        self.is_built |= wanted

    def _build_strip(self, row: int, first: int, beyond: int) -> None:
        """Compute neighbouring tiles, together with a margin that is not kept."""
        nx, ny, nz = self._grid.shape
        kept = _TILE * np.array([[row, first], [row + 1, beyond]])
        low = np.maximum(kept[0] - self._margin, 0)
        high = np.minimum(kept[1] + self._margin, (nx, ny))
        part = self._part(low, high - low, nz)
        # The kept tiles, first within the computed part, then within the whole field.
        inner, outer = (
            tuple(slice(a, b) for a, b in zip(*(kept - first_kept).tolist(), strict=True))
            for first_kept in (low, np.zeros(2, dtype=int))
        )
        self.field.distance_m[outer] = part[inner]

    def _part(
        self, low: Int[np.ndarray, " 2"], size: Int[np.ndarray, " 2"], nz: int
    ) -> Float[np.ndarray, "nx ny nz"]:
        """Distances in a block of columns, to the cells that are occupied there."""
        cell_m = self._grid.resolution_m
        x, y, z = self._grid.origin_enu_m
        origin = (x + cell_m * int(low[0]), y + cell_m * int(low[1]), z)
        grid = Grid(origin, cell_m, (int(size[0]), int(size[1]), nz))
        ends = np.array([origin, np.add(origin, cell_m * np.array(grid.shape))]) - cell_m / 2
        near = self._solids.near(ends[0], ends[1])
        occupied = voxelise([self._solids.primitives[i] for i in near], grid)
        if self._relief is not None:
            occupied |= ground_cells(self._relief, grid)
        occupied[:, :, 0] = True
        return distance_to_occupied(occupied, cell_m, self._cap_m)
