"""Free space: distance of every cell to the nearest occupied cell, and flooding.

The distance is a lower bound of the true one, because occupied cells are a superset of the solids.
A path along which it stays above a drone's radius is therefore free of contact.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.scene import Scene, Vector3
from aeroscene.solids.ground import ground_cells
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.voxels import Grid, voxelise

MAX_DISTANCE_M = 3.0
"""Distance at which values are capped: an obstacle farther away does not hinder a drone."""
_START_SEARCH_M = 4.0
"""Greatest height above a start at which the first free cell may lie."""


class NoFreeSpaceError(ValueError):
    """Raised for a place from which no drone of a radius can start."""


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelField:
    """Distances on a regular grid."""

    origin_enu_m: Vector3
    """Centre of cell (0, 0, 0)."""
    resolution_m: float
    distance_m: Float[np.ndarray, "nx ny nz"]
    """Distance from a cell's centre to the nearest occupied cell, at most the cap; 0 inside."""
    reached: dict[float, list[np.ndarray]] = field(default_factory=dict, init=False, repr=False)
    """Results of `reachable` under their radius: parts of free space that are not connected."""

    def cell(self, position_enu_m: Vector3) -> tuple[int, int, int] | None:
        """Index of the cell that holds a point, or None for a point outside the grid."""
        offset = np.asarray(position_enu_m) - self.origin_enu_m
        i, j, k = np.rint(offset / self.resolution_m).astype(int).tolist()
        nx, ny, nz = self.distance_m.shape
        return (i, j, k) if 0 <= i < nx and 0 <= j < ny and 0 <= k < nz else None

    def centre(self, cell: tuple[int, int, int]) -> Vector3:
        """Centre of a cell, ENU, m."""
        x, y, z = (o + self.resolution_m * i for o, i in zip(self.origin_enu_m, cell, strict=True))
        return (x, y, z)


def build_distance_field(
    scene: Scene,
    resolution_m: float = 0.25,
    primitives: Iterable[Primitive] | None = None,
    cap_m: float = MAX_DISTANCE_M,
) -> VoxelField:
    """Distance field of a scene's flight volume; the ground below it counts as occupied.

    Args:
        scene: Scene.
        resolution_m: Edge of a cell.
        primitives: The scene's primitives, if the caller has them already.
        cap_m: Distance at which values are capped; a lower cap is faster.
    """
    grid = field_grid(scene, resolution_m)
    occupied = voxelise(scene_primitives(scene) if primitives is None else primitives, grid)
    if scene.relief is not None:
        occupied |= ground_cells(scene.relief, grid)
    occupied[:, :, 0] = True
    return VoxelField(
        origin_enu_m=grid.origin_enu_m,
        resolution_m=resolution_m,
        distance_m=distance_to_occupied(occupied, resolution_m, cap_m),
    )


def field_grid(scene: Scene, resolution_m: float) -> Grid:
    """Cells of a scene's flight volume, with one more layer below: the ground.

    Args:
        scene: Scene.
        resolution_m: Edge of a cell.
    """
    low, high = np.asarray(scene.extent_min_enu_m), np.asarray(scene.extent_max_enu_m)
    # The small term keeps rounding from adding a layer to a volume of whole cells.
    shape = np.maximum(1, np.ceil((high - low) / resolution_m - 1e-6)).astype(int)
    origin = low + resolution_m / 2
    origin[2] -= resolution_m
    return Grid(_vector(origin), resolution_m, (int(shape[0]), int(shape[1]), int(shape[2]) + 1))


def distance_to_occupied(
    occupied: Bool[np.ndarray, "nx ny nz"], resolution_m: float, cap_m: float = MAX_DISTANCE_M
) -> Float[np.ndarray, "nx ny nz"]:
    """Exact distance from cell centres to the nearest occupied cell's surface, capped.

    Separable: along one axis, cells n apart are (2n - 1)/2 cells apart from centre to surface, and
    squares add up over the axes. Integers in units of half a cell keep it exact and fast.
    """
    # Steps along an axis after which the cap is reached.
    n_max = ceil(cap_m / resolution_m + 0.5)
    heights = np.flatnonzero(occupied.any(axis=(0, 1)))
    distance = np.full(occupied.shape, cap_m, dtype=np.float32)
    # Free space everywhere: `top` below needs at least one occupied cell.
    if not len(heights):
        return distance
    # Layers farther above the highest occupied one are capped anyway.
    top = min(occupied.shape[2], int(heights[-1]) + n_max + 1)
    steps = np.maximum(2 * np.arange(n_max + 2, dtype=np.int64) - 1, 0)
    far = int(3 * steps[-1] ** 2)
    # Integers of 16 bits are exact and fast. The last cost stands for "too far", and a quarter of
    # the range leaves room for the sum of costs along three axes.
    costs = (steps**2).astype(np.uint16)
    costs[-1] = min(far, np.iinfo(np.uint16).max // 4)
    squared = costs[_steps_along_x(occupied[:, :, :top], n_max + 1)]
    lookup = np.minimum(np.sqrt(np.arange(int(costs[-1]) + 1)) * resolution_m / 2, cap_m)
    lookup = lookup.astype(np.float32)
    for i in range(len(squared)):
        plane = _spread(squared[i], costs, n_max)
        plane = _spread(np.ascontiguousarray(plane.T), costs, n_max).T
        distance[i, :, :top] = lookup[plane]
    return distance


def _steps_along_x(occupied: np.ndarray, limit: int) -> Int[np.ndarray, "nx ny nz"]:
    """Cells to the nearest occupied cell along the first axis, at most `limit`."""
    steps = np.full(occupied.shape, limit, dtype=np.uint8)
    steps[occupied] = 0
    # Two sweeps, one in each direction, find the nearest cell on either side.
    for order in (range(1, len(steps)), range(len(steps) - 2, -1, -1)):
        step = 1 if order.step < 0 else -1
        for i in order:
            np.minimum(steps[i], steps[i + step] + np.uint8(1), out=steps[i])
    return steps


def _spread(squared: np.ndarray, costs: np.ndarray, n_max: int) -> Int[np.ndarray, "a b"]:
    """Least sum of cost and shift cost over all shifts along the first axis of a plane."""
    best = squared.copy()
    limit = costs[-1]
    moved = np.empty_like(squared)
    for n in range(1, min(n_max, len(squared) - 1) + 1):
        np.add(squared, costs[n], out=moved)
        np.minimum(best[n:], moved[:-n], out=best[n:])
        np.minimum(best[:-n], moved[n:], out=best[:-n])
    return np.minimum(best, limit, out=best)


def reachable(
    field: VoxelField, start_enu_m: Vector3, radius_m: float
) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells to which a ball can move from above a start without touching anything.

    Args:
        field: Distances. It keeps the result for the next call, so the array must not be changed.
        start_enu_m: Point on or above a surface; the ball rises from it to the first free cell.
        radius_m: Radius of the ball.

    Raises:
        NoFreeSpaceError: If no cell within 4 m above the start has that much space.
    """
    # Start-up time: floods are rare.
    from aeroscene.solids.flood import flooded

    cell = start_cell(field, start_enu_m, radius_m)
    parts = field.reached.setdefault(radius_m, [])
    # A start in a part that was flooded before needs no new flood.
    part = next((part for part in parts if part[cell]), None)
    if part is None:
        part = flooded(field.distance_m, np.float32(radius_m), *cell)
        parts.append(part)
    return part


def start_cell(field: VoxelField, start_enu_m: Vector3, radius_m: float) -> tuple[int, int, int]:
    """Lowest cell above a point in which a ball has space.

    A start lies on a surface, where no ball fits: it has to rise by about its radius first.

    Raises:
        NoFreeSpaceError: If there is none within 4 m.
    """
    cell = field.cell(start_enu_m)
    if cell is not None:
        i, j, k = cell
        column = field.distance_m[i, j, k : k + round(_START_SEARCH_M / field.resolution_m)]
        free = np.flatnonzero(column >= radius_m)
        if len(free):
            return (i, j, k + int(free[0]))
    raise NoFreeSpaceError(
        f"start {start_enu_m} has no free ball of radius {radius_m} m within {_START_SEARCH_M} m "
        "above it; valid: a point inside the grid under open space"
    )


def _vector(values: np.ndarray) -> Vector3:
    x, y, z = values.tolist()
    return (x, y, z)
