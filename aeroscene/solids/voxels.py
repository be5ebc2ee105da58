"""Conservative voxelisation: a cell is occupied when a solid may reach into it.

Sampling the cells' centres would miss thin walls and wires, and a drone would fly through them.
Every test here is a superset of the truth by less than a cell's half diagonal. It is exact for the
solids that most scenes consist of: boxes turned about the vertical, upright cylinders, round
ellipsoids. Solids are tested one by one, each only in the block of cells around its bounding box.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.scene import Vector3
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.solids import colliding, hull_faces

_TOUCH_M = 1e-6
"""A face on the border between two cells occupies only the cell behind it."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Cubic cells along the axes."""

    origin_enu_m: Vector3
    """Centre of cell (0, 0, 0)."""
    resolution_m: float
    shape: tuple[int, int, int]

    def block(
        self, low: Float[np.ndarray, " 3"], high: Float[np.ndarray, " 3"]
    ) -> tuple[slice, slice, slice] | None:
        """Cells that an axis-aligned box reaches into, or None if it lies outside the grid.

        Args:
            low: Lower corner of the box, ENU, m.
            high: Upper corner.
        """
        corner = np.asarray(self.origin_enu_m) - self.resolution_m / 2
        first = np.floor((low - corner + _TOUCH_M) / self.resolution_m).astype(int)
        last = np.ceil((high - corner - _TOUCH_M) / self.resolution_m).astype(int)
        first = np.maximum(first, 0)
        # At least one cell along each axis, however thin the box is.
        last = np.minimum(np.maximum(last, first), self.shape)
        if np.any(first >= last):
            return None
        return (slice(first[0], last[0]), slice(first[1], last[1]), slice(first[2], last[2]))

    def centres(self, block: tuple[slice, slice, slice]) -> list[Float[np.ndarray, " n"]]:
        """Coordinates of the cell centres of a block along each axis."""
        return [
            self.origin_enu_m[axis] + self.resolution_m * np.arange(part.start, part.stop)
            for axis, part in enumerate(block)
        ]


def voxelise(primitives: Iterable[Primitive], grid: Grid) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells that solids may reach into.

    Args:
        primitives: Primitives; those that do not collide leave no trace.
        grid: Cells.
    """
    occupied = np.zeros(grid.shape, dtype=bool)
    solids = colliding(primitives)
    for index, primitive in enumerate(solids.primitives):
        block = grid.block(solids.low_m[index], solids.high_m[index])
        if block is not None:
            _add(occupied, primitive, solids.rotation[index], block, grid)
    return occupied


def _add(
    occupied: np.ndarray,
    primitive: Primitive,
    rotation: np.ndarray,
    block: tuple[slice, slice, slice],
    grid: Grid,
) -> None:
    # Most solids are boxes along the axes: their block of cells is the answer.
    is_upright = abs(rotation[2, 2]) > 1 - 1e-9
    is_aligned = is_upright and np.abs(rotation[:2, :2]).max() > 1 - 1e-9
    if primitive.kind == "box" and is_aligned:
        occupied[block] = True
        return
    axes = grid.centres(block)
    half_cell = grid.resolution_m / 2 - _TOUCH_M
    offsets = [axis - p for axis, p in zip(axes, primitive.position_enu_m, strict=True)]
    if is_upright and primitive.kind in {"box", "cylinder"}:
        plane = _touches_from_above(primitive, rotation, offsets[0], offsets[1], half_cell)
        occupied[block] |= plane[:, :, None]
    else:
        occupied[block] |= _touches(primitive, rotation, offsets, half_cell)


def _touches_from_above(
    primitive: Primitive, rotation: np.ndarray, x: np.ndarray, y: np.ndarray, half_cell: float
) -> Bool[np.ndarray, "nx ny"]:
    """Exact test in the plane of an upright box or cylinder; the block settles the height."""
    half_u, half_v = primitive.size_m[0] / 2, primitive.size_m[1] / 2
    if primitive.kind == "cylinder":
        # Nearest point of the square cell to the axis.
        near_x = np.maximum(np.abs(x) - half_cell, 0.0)[:, None]
        near_y = np.maximum(np.abs(y) - half_cell, 0.0)[None, :]
        return near_x**2 + near_y**2 < half_u**2
    c, s = rotation[0, 0], rotation[1, 0]
    # Reach of a square cell along a box's rotated axes.
    reach = half_cell * (abs(c) + abs(s))
    u = np.abs(c * x[:, None] + s * y[None, :])
    v = np.abs(c * y[None, :] - s * x[:, None])
    return (u < half_u + reach) & (v < half_v + reach)


def _touches(
    primitive: Primitive, rotation: np.ndarray, offsets: list[np.ndarray], half_cell: float
) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells whose centre lies in the solid, enlarged by the cell's reach along each face normal."""
    x, y, z = np.meshgrid(*offsets, indexing="ij", sparse=True)
    if primitive.kind == "mesh":
        inside = np.ones(np.broadcast_shapes(x.shape, y.shape, z.shape), dtype=bool)
        for nx, ny, nz, offset in hull_faces(primitive.vertices_m).planes:
            normal = rotation @ (nx, ny, nz)
            reach = half_cell * np.abs(normal).sum()
            inside &= normal[0] * x + normal[1] * y + normal[2] * z + offset < reach
        return inside
    half = np.asarray(primitive.size_m) / 2
    local = [rotation[0, i] * x + rotation[1, i] * y + rotation[2, i] * z for i in range(3)]
    reach = half_cell * np.abs(rotation).sum(axis=0)
    beyond = [np.maximum(np.abs(local[i]) - reach[i], 0.0) for i in range(3)]
    if primitive.kind == "ellipsoid":
        squares = [(beyond[i] / half[i]) ** 2 for i in range(3)]
        return squares[0] + squares[1] + squares[2] < 1.0
    inside = (beyond[0] < half[0]) & (beyond[1] < half[1]) & (beyond[2] < half[2])
    if primitive.kind == "cylinder":
        inside &= beyond[0] ** 2 + beyond[1] ** 2 < half[0] ** 2
    return inside
