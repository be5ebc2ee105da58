"""Distance field: distance of every cell of a grid to the nearest obstacle.

Searches need the room of millions of cells, for which exact distances to solids would take too
long. Proofs use the exact `Obstacles` instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from autonomy.types import Vector3


@dataclass(frozen=True, kw_only=True, eq=False)
class DistanceField:
    """Distances on a regular grid in ENU."""

    origin_enu_m: Vector3
    """Centre of the cell with index (0, 0, 0)."""
    resolution_m: float
    distance_m: Float[np.ndarray, "nx ny nz"]
    """Distance from the centre of a cell to the nearest occupied cell; 0 in occupied cells."""

    def __post_init__(self) -> None:
        """Refuse a resolution or an array that makes no field."""
        if not self.resolution_m > 0:
            raise ValueError(f"resolution_m {self.resolution_m} is not positive; valid: metres")
        if self.distance_m.ndim != 3 or 0 in self.distance_m.shape:
            raise ValueError(
                f"distance_m has shape {self.distance_m.shape}; valid: three axes, none empty"
            )

    def cells(self, points_enu_m: Float[np.ndarray, "*b 3"]) -> Int[np.ndarray, "*b 3"]:
        """Indices of the cells that contain the points; off the grid, outside its shape."""
        offset = (np.asarray(points_enu_m) - self.origin_enu_m) / self.resolution_m
        return np.rint(offset).astype(np.int64)

    def centres(self, cells: Int[np.ndarray, "*b 3"]) -> Float[np.ndarray, "*b 3"]:
        """Centres of cells, ENU, m."""
        return np.asarray(self.origin_enu_m) + np.asarray(cells) * self.resolution_m

    @property
    def bounds_enu_m(self) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]:
        """Centres of the first and of the last cell, ENU, m."""
        return np.array(self.origin_enu_m), self.centres(np.array(self.distance_m.shape) - 1)

    def contains(self, points_enu_m: Float[np.ndarray, "*b 3"]) -> np.ndarray:
        """Return whether each point lies in a cell of the grid."""
        cells = self.cells(points_enu_m)
        return np.all((cells >= 0) & (cells < self.distance_m.shape), axis=-1)

    def part_about(self, points_enu_m: Float[np.ndarray, "n 3"], margin_m: float) -> DistanceField:
        """The field of the box that holds some points and a margin, cut at the grid's border."""
        cells, margin = self.cells(points_enu_m), math.ceil(margin_m / self.resolution_m)
        low = np.clip(cells.min(axis=0) - margin, 0, np.array(self.distance_m.shape) - 1)
        high = np.maximum(cells.max(axis=0) + margin + 1, low + 1)
        part = tuple(slice(a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True))
        x, y, z = self.centres(low).tolist()
        return DistanceField(
            origin_enu_m=(x, y, z),
            resolution_m=self.resolution_m,
            distance_m=np.ascontiguousarray(self.distance_m[part]),
        )
