"""Relief: the height of the ground as a regular grid of nodes.

Four neighbouring nodes bound a cell, and a cell is two triangles. Their common edge runs from the
cell's south-west node to its north-east node. MuJoCo divides the cells of its height fields the
same way, so physics, rays, maps and pictures have one surface. Beyond the grid the ground continues
with the height of the nearest point of the grid's border.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from aeroscene.scene.errors import SceneError, require, require_finite, require_within

MOST_NODES = 512
"""Most nodes of a grid along one axis."""
MOST_HEIGHT_M = 200.0
"""Greatest height above or below the origin, m."""
MOST_SLOPE = 2.0
"""Steepest gradient of a triangle, rise over run: 63 degrees."""
SPACINGS_M = (0.1, 100.0)
"""Least and greatest distance between neighbouring nodes, m."""
_FARTHEST_M = 10_000.0
_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Relief:
    """Heights of the ground over a regular grid, ENU.

    Raises:
        SceneError: If there are fewer than 2 or more than `MOST_NODES` rows or columns, a height or
            the spacing is out of range, or a slope is steeper than `MOST_SLOPE`.
    """

    origin_enu_m: tuple[float, float]
    """East and north of the south-west node."""
    spacing_m: float
    """Distance between neighbouring nodes, the same on both axes."""
    heights_m: Float[np.ndarray, "rows columns"]
    """Heights of the nodes: rows from south to north, columns from west to east; read-only."""

    @classmethod
    def from_rows(
        cls, origin_enu_m: tuple[float, float], spacing_m: float, rows: Sequence[Sequence[float]]
    ) -> Relief:
        """Build a relief from rows of heights.

        Raises:
            SceneError: If the rows differ in length, or a rule of `Relief` is broken.
        """
        lengths = sorted({len(row) for row in rows})
        if len(lengths) > 1:
            raise SceneError(
                f"heights have rows of {lengths[0]} to {lengths[-1]} numbers; "
                "valid: rows of equal length"
            )
        _require_count(len(rows), "rows")
        _require_count(lengths[0], "columns")
        return cls(origin_enu_m, spacing_m, np.array(rows, dtype=float))

    def __post_init__(self) -> None:
        heights = np.array(self.heights_m, dtype=float)
        require(
            ok=heights.ndim == 2,
            field_name="heights",
            value=f"an array of {heights.ndim} dimensions",
            valid="rows of numbers",
        )
        for count, noun in zip(heights.shape, ("rows", "columns"), strict=True):
            _require_count(count, noun)
        require_finite(self.origin_enu_m, 2, "origin")
        require_within(self.origin_enu_m, _FARTHEST_M, "origin")
        least, most = SPACINGS_M
        ok = least <= self.spacing_m <= most
        valid = f"{least:g} to {most:g} m"
        require(ok=ok, field_name="spacing", value=self.spacing_m, valid=valid)
        _require_heights(heights)
        # The array is our own copy. Read-only, it can be hashed and shared between threads.
        heights.setflags(write=False)
        # The dataclass is frozen, hence the detour.
        object.__setattr__(self, "heights_m", heights)
        _require_gentle(self)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Relief) and self._facts == other._facts

    def __hash__(self) -> int:
        return hash(self._facts)

    @property
    def _facts(self) -> tuple[Any, ...]:
        return self.origin_enu_m, self.spacing_m, self.heights_m.shape, self.heights_m.tobytes()

    @property
    def min_m(self) -> float:
        """Height of the lowest point, m."""
        return float(self.heights_m.min())

    @property
    def max_m(self) -> float:
        """Height of the highest point, m."""
        return float(self.heights_m.max())

    def span_m(self, axis: int) -> tuple[float, float]:
        """Coordinates in m of the first and the last node along an axis: 0 is east, 1 is north."""
        first = self.origin_enu_m[axis]
        return first, first + (self.heights_m.shape[1 - axis] - 1) * self.spacing_m

    @cached_property
    def steepest(self) -> float:
        """Greatest gradient of any triangle, rise over run."""
        east, north = self.gradients()
        return float(np.hypot(east, north).max())

    def gradients(self) -> tuple[Float[np.ndarray, "2 r c"], Float[np.ndarray, "2 r c"]]:
        """Rise towards east and north of the triangles of each cell: south-eastern, north-western.

        Returns:
            Gradients towards east and towards north. The first axis is the triangle, the others are
            rows and columns of cells.
        """
        along, up = (np.diff(self.heights_m, axis=axis) / self.spacing_m for axis in (1, 0))
        return np.stack([along[:-1], along[1:]]), np.stack([up[:, 1:], up[:, :-1]])

    def height_m(
        self, x_m: float | Float[np.ndarray, "*n"], y_m: float | Float[np.ndarray, "*n"]
    ) -> Float[np.ndarray, "*n"]:
        """Height of the ground in m at places given by east and north, of shapes that broadcast.

        Beyond the grid it is the height of the nearest point of the border.
        """
        row, column, v, u = self._cells(np.asarray(x_m, float), np.asarray(y_m, float))
        h = self.heights_m
        south_west, north_east = h[row, column], h[row + 1, column + 1]
        is_south_east = u >= v
        corner = np.where(is_south_east, h[row, column + 1], h[row + 1, column])
        first, second = np.where(is_south_east, u, v), np.where(is_south_east, v, u)
        # A plane through three nodes: along the edge that the triangle shares with the cell's
        # border first, then to the north-east node.
        return south_west + first * (corner - south_west) + second * (north_east - corner)

    def _cells(self, x_m: np.ndarray, y_m: np.ndarray) -> tuple[np.ndarray, ...]:
        """Row and column of the cell at each place, and the place in it, 0 to 1 each."""
        x_m, y_m = np.broadcast_arrays(x_m, y_m)
        found: list[np.ndarray] = []
        for axis, (place_m, start_m) in enumerate(
            zip((y_m, x_m), reversed(self.origin_enu_m), strict=True)
        ):
            n_cells = self.heights_m.shape[axis] - 1
            along = np.clip((place_m - start_m) / self.spacing_m, 0.0, float(n_cells))
            # The northernmost and easternmost nodes belong to the last cell.
            cell = np.minimum(along.astype(np.int64), n_cells - 1)
            found += [cell, along - cell]
        row, v, column, u = found
        return row, column, v, u

    def normal_enu(self, x_m: Float[np.ndarray, "*n"], y_m: Float[np.ndarray, "*n"]) -> np.ndarray:
        """Upward unit normals, shape (*n, 3), of the triangles at places."""
        row, column, v, u = self._cells(np.asarray(x_m, float), np.asarray(y_m, float))
        which = (u < v).astype(np.int64)
        east, north = (gradient[which, row, column] for gradient in self.gradients())
        normal = np.stack([-east, -north, np.ones_like(east)], axis=-1)
        return normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def ground_m(
    relief: Relief | None, x_m: float | np.ndarray, y_m: float | np.ndarray
) -> Float[np.ndarray, "*n"]:
    """Height of the ground in m at places; 0 without a relief.

    Code calls this instead of `Relief.height_m`, so that flat scenes need no case of their own.
    """
    if relief is None:
        return np.zeros(np.broadcast_shapes(np.shape(x_m), np.shape(y_m)))
    return relief.height_m(x_m, y_m)


def _require_count(count: int, noun: str) -> None:
    if not 2 <= count <= MOST_NODES:
        raise SceneError(f"heights have {count} {noun}; valid: 2 to {MOST_NODES}")


def _require_heights(heights_m: np.ndarray) -> None:
    is_wrong = ~(np.abs(heights_m) <= MOST_HEIGHT_M)  # true also for NaN
    if is_wrong.any():
        row, column = np.argwhere(is_wrong)[0].tolist()
        name, most = f"heights[{row}][{column}]", MOST_HEIGHT_M
        require_within((float(heights_m[row, column]),), most, name)


def _require_gentle(relief: Relief) -> None:
    if relief.steepest <= MOST_SLOPE + _SLACK:
        return
    slopes = np.hypot(*relief.gradients()).max(axis=0)
    row, column = np.unravel_index(int(slopes.argmax()), slopes.shape)
    degrees, most = (math.degrees(math.atan(s)) for s in (relief.steepest, MOST_SLOPE))
    raise SceneError(
        f"heights rise by {degrees:.1f} degrees at heights[{row}][{column}]; "
        f"valid: at most {most:.1f} degrees"
    )
